"""What the web server needs of a planner."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from jtik.planner.edits import messages as edits
from jtik.planner.web.outgoing import Published

if TYPE_CHECKING:
    from jtik.planner.attempts.attempt import Attempt
    from jtik.planner.attempts.history import History
    from jtik.planner.session.arm import Arm
    from jtik.planner.web.desk import Exported
    from jtik.planner.web.meshes import Meshes


class Planning(Protocol):
    """What the server needs of a planner; all of it may be called from any thread."""

    @property
    def loop(self) -> Running:
        """The loop, which publishes frames and takes edits."""

    @property
    def arm(self) -> Arm:
        """The robot."""

    def measures(self, attempt: Attempt) -> Mapping[str, Any]:
        """The measures of an attempt by name."""

    def findings(self, attempt: Attempt) -> Sequence[str]:
        """What a check of an attempt finds, in words."""

    def exported(self, attempt: Attempt, kind: str) -> Exported:
        """An attempt as a file of a kind."""

    def meshes(self) -> Meshes:
        """The meshes of the robot."""

    def plan_text(self) -> str:
        """The whole plan as a file."""

    def load_text(self, text: str, name: str) -> None:
        """Go on from the text of a plan."""


class Running(Published, Protocol):
    """What the server needs of a loop."""

    @property
    def history(self) -> History:
        """The attempts."""

    def submit(self, edit: edits.Edit) -> bool:
        """Hand an edit to the loop; False where too many wait."""

    def listen(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Have a function called when something is published; the answer ends that."""

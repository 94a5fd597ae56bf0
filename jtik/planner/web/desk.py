"""What the page asks of a planner beside edits: measures, checks and files of attempts, the plan as one file."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jtik.errors import ArgumentError
from jtik.planner.attempts.attempt import Attempt
from jtik.planner.attempts.compare import measure
from jtik.planner.commit.committing import check, commit
from jtik.planner.edits import of_attempts as edits
from jtik.planner.files.plain import LONGEST_NAME
from jtik.planner.files.plan_file import Plan
from jtik.planner.session.targets import guided_frame
from jtik.planner.web.meshes import Meshes, encoded

if TYPE_CHECKING:
    from jtik.planner.session.loop import Loop

KINDS = {
    "csv": "csv",
    "json": "json",
    "npz": "npz",
    "ros2.json": "ros2_json",
    "ros2.yaml": "ros2_yaml",
    "png": "figure",
    "svg": "figure",
    "gif": "animation",
}
"""Suffixes of the files that an attempt can be exported as, and the formats of `jtik.planner.commit.committing`."""


@dataclass(frozen=True)
class Exported:
    """A file of an attempt.

    Attributes:
        body: what is in it.
        findings: what a check of the motion in it finds, in words.
        about: how the motion was timed, in words.
    """

    body: bytes
    findings: tuple[str, ...]
    about: str


class Desk:
    """Answers the questions of a page, in any thread. Attempts and settings are immutable, so nothing is locked.

    Args:
        loop: the loop of a planner.

    Attributes:
        loop: the loop.
        arm: the robot.
    """

    def __init__(self, loop: Loop) -> None:
        self.loop, self.arm = loop, loop.arm
        self._robot: Any = self.arm.robot
        self._meshes: Meshes | None = None
        self._reading = threading.Lock()

    def measures(self, attempt: Attempt) -> Mapping[str, Any]:
        """The measures of an attempt by name."""
        return measure(attempt, self._robot, frame=guided_frame(attempt.settings, self.arm)).to_json()

    def findings(self, attempt: Attempt) -> list[str]:
        """What a check of an attempt finds, in words: limits, speeds, accelerations, clearance between samples."""
        return [finding.text for finding in check(attempt, self._robot, safe=self._safe())]

    def meshes(self) -> Meshes:
        """The meshes of the robot, whose files are read once."""
        with self._reading:
            if self._meshes is None:
                self._meshes = encoded(self._robot)
            return self._meshes

    def _safe(self) -> float:
        """Smallest distance to obstacles that is asked for [m]: 0, which is contact, while the clearance is off."""
        return self.loop.settings.safe if self.loop.settings.clearance else 0.0

    def exported(self, attempt: Attempt, kind: str) -> Exported:
        """An attempt as a file, timed within the limits, and what is wrong with the motion in it.

        Args:
            attempt: the attempt.
            kind: suffix of the file, one of `KINDS`.

        Raises:
            ArgumentError: for another kind, or an attempt that cannot be exported.
        """
        if kind not in KINDS:
            raise ArgumentError("format", kind, f"one of {', '.join(KINDS)}")
        with tempfile.TemporaryDirectory(prefix="jtik-export-") as folder:
            path = Path(folder) / f"attempt.{kind}"
            done = commit(attempt, self._robot, path, KINDS[kind], safe=self._safe())
            about = f"{done.commands.times[-1]:.2f} s, timed by {done.commands.method}"
            notes = [about, *([done.commands.note] if done.commands.note else [])]
            return Exported(path.read_bytes(), tuple(each.text for each in done.findings), "; ".join(notes))

    def plan_text(self) -> str:
        """The whole plan as a file."""
        with tempfile.TemporaryDirectory(prefix="jtik-export-") as folder:
            path = Path(folder) / "plan.json"
            self.loop.plan().save(path)
            return path.read_text(encoding="utf-8")

    def load_text(self, text: str, name: str = "plan.json") -> None:
        """Go on from the text of a plan.

        Args:
            text: what a file of a plan has in it.
            name: name of that file, for messages.

        Raises:
            ArgumentError: for anything that is no plan, or one of another robot.
        """
        with tempfile.TemporaryDirectory(prefix="jtik-plan-") as folder:
            path, called = Path(folder) / "plan.json", _shown(name)
            path.write_bytes(text.encode("utf-8", "replace"))
            try:
                plan = Plan.load(path, self._robot)
            except ArgumentError as error:
                place = error.argument.replace(path.name, called, 1).removeprefix("path")
                given = str(error.given).replace(str(path), called)
                raise ArgumentError(place or "plan", given, error.accepted) from None
        self.loop.submit(edits.TakePlan(plan))


def _shown(name: str) -> str:
    """The name of a file that a stranger chose, for messages."""
    kept = "".join(each for each in name.replace("\\", "/").rsplit("/", 1)[-1] if each.isprintable())
    return kept[:LONGEST_NAME] or "plan.json"

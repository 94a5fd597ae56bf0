"""What the page asks of a planner beside edits: measures, checks and files of attempts, the plan as one file."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jtik.errors import ArgumentError
from jtik.planner.attempts.attempt import Attempt
from jtik.planner.attempts.compare import measure
from jtik.planner.commit.committing import check, commit
from jtik.planner.edits import of_attempts as edits
from jtik.planner.files.plan_file import Plan

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

    def measures(self, attempt: Attempt) -> Mapping[str, Any]:
        """The measures of an attempt by name."""
        return measure(attempt, self._robot, frame=self.arm.tip).to_json()

    def findings(self, attempt: Attempt) -> list[str]:
        """What a check of an attempt finds, in words: limits, speeds, accelerations, clearance between samples."""
        return [finding.text for finding in check(attempt, self._robot, safe=self._safe())]

    def _safe(self) -> float:
        """Smallest distance to obstacles that is asked for [m]: 0, which is contact, while the clearance is off."""
        return self.loop.settings.safe if self.loop.settings.clearance else 0.0

    def exported(self, attempt: Attempt, kind: str) -> bytes:
        """An attempt as a file, timed within the limits.

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
            return commit(attempt, self._robot, path, KINDS[kind], safe=self._safe()).path.read_bytes()

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
            path = Path(folder) / (Path(name).name or "plan.json")
            path.write_text(text, encoding="utf-8")
            try:
                plan = Plan.load(path, self._robot)
            except ArgumentError as error:
                raise ArgumentError("plan", str(error.given).replace(str(path), path.name), error.accepted) from None
        self.loop.submit(edits.TakePlan(plan))

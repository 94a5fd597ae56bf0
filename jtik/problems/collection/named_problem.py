"""A problem of the collection: robot, task, criteria, and cases with known solutions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from jtik.criterion.base import Criterion, CriterionSum
from jtik.problems.case import ProblemSet
from jtik.registry import criteria
from jtik.robot import Robot
from jtik.task import Task
from jtik.types import Array


@dataclass(frozen=True, kw_only=True)
class NamedProblem:
    """A problem of the collection.

    Attributes:
        name: its name in `jtik.problems.named`.
        summary: one-line description.
        robot: the robot.
        task: the task.
        criteria: criteria to minimise in the null space of the task, or None.
        problems: the cases, with the known results in ``known``.
        origin: the source.
    """

    name: str
    summary: str
    robot: Robot
    task: Task
    criteria: Criterion | CriterionSum | None = None
    problems: ProblemSet
    origin: str

    def __repr__(self) -> str:
        return f"NamedProblem({self.name!r}, {self.robot!r}, {len(self.problems)} cases: {self.summary})"


def centering(preferred: Array) -> Criterion:
    """Joint centring around the ``preferred`` angles [rad], found by its registered name."""
    build: Callable[..., Criterion] = criteria["joint_centering"]
    return build(preferred=preferred)

"""A problem, or a few, of which the answer is known: what it is about, and everything to solve it with."""

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
class Named:
    """An entry of the collection.

    Attributes:
        name: what `jtik.problems.named` finds it by.
        summary: what it asks, in a line.
        robot: the robot.
        task: the task.
        criteria: what to minimise with the freedom left, or None.
        problems: the cases, with the answers in ``known``.
        origin: where it comes from.
    """

    name: str
    summary: str
    robot: Robot
    task: Task
    criteria: Criterion | CriterionSum | None = None
    problems: ProblemSet
    origin: str

    def __repr__(self) -> str:
        return f"Named({self.name!r}, {self.robot!r}, {len(self.problems)} cases: {self.summary})"


def centering(preferred: Array) -> Criterion:
    """Joint centring about the ``preferred`` angles [rad], by its registered name."""
    build: Callable[..., Criterion] = criteria["joint_centering"]
    return build(preferred=preferred)

"""Targets that no configuration meets: they lie beyond the length of the arm."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError, finite_array
from jtik.problems.case import Case, ProblemSet
from jtik.problems.mover import Mover
from jtik.problems.start import Starts
from jtik.problems.subject import Subject, drawn
from jtik.robot import Robot
from jtik.task import Task


def unreachable(
    robot: Robot,
    task: Task | Iterable[Task],
    count: int = 100,
    *,
    seed: int = 0,
    beyond: tuple[float, float] = (1.01, 1.2),
    q0: ArrayLike | None = None,
    joints: str | Iterable[str] | None = None,
    at: ArrayLike | None = None,
) -> ProblemSet:
    """Problems without a solution: how near does a strategy come, and does it say so?

    Drawn for each case: a start and a goal as in `reachable`; a direction, uniform; a distance, uniform in ``beyond``.
    The targets are those of the goal, except that the position of the first `FrameTask` that has one lies in that
    direction at that distance from the arm's first joint. The distance is a share of the summed lengths of the links
    and strokes of the slides, which nothing can pass, so the claim needs no search. ``known["error"]`` is the least
    error [m] where it has a closed form: the position of a planar chain of hinges without limits.

    Args:
        robot, task, joints, at: as `InverseKinematics` takes them; starts are of its reduced robot.
        count: how many cases.
        seed: of the random numbers; case i is the same for every count.
        beyond: least and greatest distance, as shares of the summed lengths, above 1.
        q0: start of every case (nq,); drawn when None.

    Raises:
        ArgumentError: for tasks none of which reads a position, a robot without bounds, or an argument that cannot be
            used.
    """
    subject = Subject(robot, task, joints, at)
    mover, starts = Mover.of(subject), Starts(subject, q0)
    low, high = finite_array("beyond", beyond, (2,)).tolist()
    if not 1 < low <= high:
        raise ArgumentError("beyond", beyond, "two shares above 1, such as (1.01, 1.2)")
    bound, center = bounded(mover), mover.center
    origin = f"{low:g} to {high:g} times the summed lengths of the links from the first joint"

    def draw(name: str, generator: np.random.Generator) -> Case:
        start, goal = starts.draw(generator), subject.robot.random_configuration(generator)
        direction, distance = mover.direction(generator), bound * generator.uniform(low, high)
        there = mover.only(center + distance * direction - mover.position(goal))
        return Case(
            name=name,
            kind="unreachable",
            q0=start,
            targets=(mover.moved(subject.target_at(goal), there),),
            reachable=False,
            known={"error": distance - bound} if mover.is_exact else {},
            origin=origin,
        )

    return drawn("unreachable", count, seed, draw, origin)


def bounded(mover: Mover) -> float:
    """The mover's bound [m]; raises ArgumentError where there is none."""
    if not math.isfinite(mover.bound):
        accepted = "a robot whose reach ends: no free joint, and limits on every slide"
        raise ArgumentError("robot", mover.subject.robot, accepted)
    return mover.bound

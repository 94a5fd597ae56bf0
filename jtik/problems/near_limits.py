"""Targets met by configurations that have joints next to their limits."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError, finite_array
from jtik.problems.case import Case, ProblemSet
from jtik.problems.start import Starts
from jtik.problems.subject import Subject, drawn
from jtik.robot import Robot
from jtik.task import Task


def near_limits(
    robot: Robot,
    task: Task | Iterable[Task],
    count: int = 100,
    *,
    seed: int = 0,
    share: float = 0.02,
    q0: ArrayLike | None = None,
    joints: str | Iterable[str] | None = None,
    at: ArrayLike | None = None,
) -> ProblemSet:
    """Problems on which a law that forgets its limits, or gives way to them too soon, fails.

    Drawn for each case: a start and a goal as in `reachable`; then how many joints are at a limit, uniform from 1 to
    all that have two limits; which ones; at which end, evenly; and how far from it, uniform in (0, share) of the
    range. The target is what the tasks read at that goal. For every task of jtik.

    Args:
        robot, task, joints, at: as `InverseKinematics` takes them; starts are of its reduced robot.
        count: how many cases.
        seed: of the random numbers; case i is the same for every count.
        share: greatest distance from the limit as a share of the joint's range, in (0, 0.5].
        q0: start of every case (nq,); drawn when None.

    Raises:
        ArgumentError: for a robot of which no joint has two limits, or an argument that cannot be used.
    """
    subject = Subject(robot, task, joints, at)
    starts, arm = Starts(subject, q0), subject.robot
    part = float(finite_array("share", share, ()))
    if not 0 < part <= 0.5:
        raise ArgumentError("share", share, "a share of the range in (0, 0.5]")
    width = arm.upper - arm.lower
    bounded = np.flatnonzero(np.isfinite(width) & (width > 0))
    if not len(bounded):
        raise ArgumentError("robot", arm, "a robot with a joint that has a lower and an upper limit")
    origin = f"a goal with joints within {100 * part:g} % of their range from a limit"

    def draw(name: str, generator: np.random.Generator) -> Case:
        start, goal = starts.draw(generator), arm.random_configuration(generator)
        number = int(generator.integers(1, len(bounded) + 1))
        pressed = generator.permutation(bounded)[:number]
        high = generator.random(number) < 0.5
        away = part * width[pressed] * generator.random(number)
        goal[pressed] = np.where(high, arm.upper[pressed] - away, arm.lower[pressed] + away)
        return Case(
            name=name,
            kind="near_limits",
            q0=start,
            targets=(subject.target_at(goal),),
            reachable=True,
            known={"error": 0.0},
            origin=origin,
        )

    return drawn("near_limits", count, seed, draw, origin)

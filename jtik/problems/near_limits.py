"""Generator of targets whose goal configurations have joints close to their limits."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import number
from jtik.errors import ArgumentError
from jtik.problems.case import Case, ProblemSet
from jtik.problems.problem_setup import ProblemSetup, draw_set
from jtik.problems.start_sampler import StartSampler
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
    """Draw problems whose goals have joints close to their limits, which test how a strategy handles limits.

    For each case, a start and a goal are drawn as in `reachable`. The number of joints to move to a limit is uniform,
    from 1 to the number of joints with two limits. The joints and the side (lower or upper) are uniform. The distance
    to the limit is uniform in (0, share) of the range. The target is the task value at that goal. All tasks of jtik
    are supported.

    Args:
        robot: the robot.
        task: a Task, or several.
        count: number of cases.
        seed: seed of the random numbers; case i is the same for every count.
        share: largest distance to the limit as a share of the joint's range, in (0, 0.5].
        q0: start of every case, (nq,) of the reduced robot; drawn when None.
        joints: joints that move, as in `InverseKinematics`.
        at: configuration at which the other joints are locked, as in `InverseKinematics`.

    Raises:
        ArgumentError: if no joint has two limits, or an argument is invalid.
    """
    setup = ProblemSetup(robot, task, joints, at)
    starts, arm = StartSampler(setup, q0), setup.robot
    part = number("share", share, "a share of the range in (0, 0.5]")
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
        at_limit = generator.permutation(bounded)[:number]
        high = generator.random(number) < 0.5
        away = part * width[at_limit] * generator.random(number)
        goal[at_limit] = np.where(high, arm.upper[at_limit] - away, arm.lower[at_limit] + away)
        return Case(
            name=name,
            kind="near_limits",
            q0=start,
            targets=(setup.target_at(goal),),
            reachable=True,
            known={"error": 0.0},
            origin=origin,
        )

    return draw_set("near_limits", count, seed, draw, origin)

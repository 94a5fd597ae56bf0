"""Generator of reachable targets, each taken from a drawn goal configuration."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from jtik.problems.case import Case, ProblemSet
from jtik.problems.problem_setup import ProblemSetup, draw_set
from jtik.problems.start_sampler import StartSampler
from jtik.robot import Robot
from jtik.task import Task

ORIGIN = "start and goal uniform within the limits; the target is the task value at the goal"


def reachable(
    robot: Robot,
    task: Task | Iterable[Task],
    count: int = 100,
    *,
    seed: int = 0,
    q0: ArrayLike | None = None,
    joints: str | Iterable[str] | None = None,
    at: ArrayLike | None = None,
) -> ProblemSet:
    """Draw general problems: random reachable targets from random starts.

    For each case, a start and then a goal are drawn by `Robot.random_configuration`: uniform within the limits,
    unlimited revolute joints within (-pi, pi), unlimited prismatic joints within 1 m, quaternions uniform. The target
    is the task value at the goal, so it can be reached within the limits. All tasks of jtik are supported.

    Args:
        robot: the robot.
        task: a Task, or several.
        count: number of cases.
        seed: seed of the random numbers; case i is the same for every count.
        q0: start of every case, (nq,) of the reduced robot; drawn when None.
        joints: joints that move, as in `InverseKinematics`.
        at: configuration at which the other joints are locked, as in `InverseKinematics`.

    Raises:
        ArgumentError: naming an invalid argument.
    """
    setup = ProblemSetup(robot, task, joints, at)
    starts = StartSampler(setup, q0)

    def draw(name: str, generator: np.random.Generator) -> Case:
        start = starts.draw(generator)
        goal = setup.robot.random_configuration(generator)
        return Case(
            name=name,
            kind="reachable",
            q0=start,
            targets=(setup.target_at(goal),),
            reachable=True,
            known={"error": 0.0},
            origin=ORIGIN,
        )

    return draw_set("reachable", count, seed, draw, ORIGIN)

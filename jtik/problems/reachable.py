"""Targets that can be reached, because a configuration that meets them was drawn first."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from jtik.problems.case import Case, ProblemSet
from jtik.problems.start import Starts
from jtik.problems.subject import Subject, drawn
from jtik.robot import Robot
from jtik.task import Task

ORIGIN = "start and goal uniform within the limits; the target is where the goal is"


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
    """Ordinary problems: from anywhere to anywhere.

    Drawn for each case: a start, then a goal, by `Robot.random_configuration`: uniform within the limits; a hinge
    without limits within (-pi, pi), a length without within 1 m, quaternions uniform. The target is what the tasks
    read at the goal, so that it can be reached within the limits. For every task of jtik.

    Args:
        robot, task, joints, at: as `InverseKinematics` takes them; starts are of its reduced robot.
        count: how many cases.
        seed: of the random numbers; case i is the same for every count.
        q0: start of every case (nq,); drawn when None.

    Raises:
        ArgumentError: for an argument that cannot be used, naming it.
    """
    subject = Subject(robot, task, joints, at)
    starts = Starts(subject, q0)

    def draw(name: str, generator: np.random.Generator) -> Case:
        start = starts.draw(generator)
        goal = subject.robot.random_configuration(generator)
        return Case(
            name=name,
            kind="reachable",
            q0=start,
            targets=(subject.target_at(goal),),
            reachable=True,
            known={"error": 0.0},
            origin=ORIGIN,
        )

    return drawn("reachable", count, seed, draw, ORIGIN)

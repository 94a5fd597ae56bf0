"""Generator of unreachable targets, which lie beyond the total link length of the arm."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import finite_array
from jtik.errors import ArgumentError
from jtik.problems.case import Case, ProblemSet
from jtik.problems.position_task import PositionTask
from jtik.problems.problem_setup import ProblemSetup, draw_set
from jtik.problems.start_sampler import StartSampler
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
    """Draw problems without a solution, which show the remaining error of a strategy and the status it reports.

    For each case, a start and a goal are drawn as in `reachable`. The direction is uniform. The distance is uniform in
    ``beyond``. The position target of the first `FrameTask` that has a position lies in that direction, at that
    distance from the arm's first joint. All other targets are those of the goal. The distance is relative to the total
    length of the links and of the strokes of the prismatic joints, an upper bound on the reach, so no search is needed.

    ``known["error"]`` is the smallest error [m], for a position task on a planar chain of revolute joints without
    limits. It is absent for other robots and tasks.

    Args:
        robot: the robot.
        task: a Task, or several.
        count: number of cases.
        seed: seed of the random numbers; case i is the same for every count.
        beyond: smallest and largest distance, relative to the total link length, above 1.
        q0: start of every case, (nq,) of the reduced robot; drawn when None.
        joints: joints that move, as in `InverseKinematics`.
        at: configuration at which the other joints are locked, as in `InverseKinematics`.

    Raises:
        ArgumentError: if no task has a position, the robot's reach is unbounded, or an argument is invalid.
    """
    setup = ProblemSetup(robot, task, joints, at)
    position_task, starts = PositionTask.of(setup), StartSampler(setup, q0)
    low, high = finite_array("beyond", beyond, (2,)).tolist()
    if not 1 < low <= high:
        raise ArgumentError("beyond", beyond, "two factors above 1 in ascending order, such as (1.01, 1.2)")
    bound, center = bounded(position_task), position_task.center
    origin = f"{low:g} to {high:g} times the total link length from the first joint"

    def draw(name: str, generator: np.random.Generator) -> Case:
        start, goal = starts.draw(generator), setup.robot.random_configuration(generator)
        direction, distance = position_task.direction(generator), bound * generator.uniform(low, high)
        offset = position_task.only(center + distance * direction - position_task.position(goal))
        return Case(
            name=name,
            kind="unreachable",
            q0=start,
            targets=(position_task.moved(setup.target_at(goal), offset),),
            reachable=False,
            known={"error": distance - bound} if position_task.is_exact else {},
            origin=origin,
        )

    return draw_set("unreachable", count, seed, draw, origin)


def bounded(position_task: PositionTask) -> float:
    """The bound on the reach [m]. Raises ArgumentError if the reach is unbounded."""
    if not math.isfinite(position_task.bound):
        accepted = "a robot of bounded reach: no free joint, and limits on every prismatic joint"
        raise ArgumentError("robot", position_task.setup.robot, accepted)
    return position_task.bound

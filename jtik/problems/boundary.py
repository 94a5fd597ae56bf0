"""Generator of targets at the boundary of the workspace, where the Jacobian loses rank."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import number
from jtik.errors import ArgumentError
from jtik.problems.case import Case, ProblemSet
from jtik.problems.position_task import PositionTask
from jtik.problems.problem_setup import MAX_ITERATIONS, ProblemSetup, draw_set
from jtik.problems.start_sampler import StartSampler
from jtik.problems.unreachable import bounded
from jtik.robot import Robot
from jtik.task import Task
from jtik.types import Array

RESOLUTION = 1e-5
"""Accuracy of the boundary distance, relative to the total link length."""

COARSE = 1e-2
"""Interval width, relative to the total link length, above which failed attempts are restarted."""

RESTARTS = 10
"""Number of restarts."""

RESTARTED_ITERATIONS = 100
"""Maximum iterations of an attempt when restarts follow it."""

ATTEMPTS = 50
"""Maximum number of goals drawn for one case."""


def boundary(
    robot: Robot,
    task: Task | Iterable[Task],
    count: int = 100,
    *,
    seed: int = 0,
    share: float = 0.9999,
    q0: ArrayLike | None = None,
    joints: str | Iterable[str] | None = None,
    at: ArrayLike | None = None,
) -> ProblemSet:
    """Draw problems at the boundary of the workspace, which only nearly singular postures reach.

    For each case, a start and a goal are drawn as in `reachable`. A ray starts at the arm's first joint and passes
    through the goal position of the first `FrameTask` that has a position. All other coordinates, orientations and
    tasks keep their values at the goal. Bisection along the ray finds the boundary, between the goal and the total
    link length. Each bisection step starts from the last posture found; while the interval is wide it also tries ten
    other starts. The target lies at ``share`` of the boundary distance and has been reached by the solver.

    ``known["reach"]`` is the distance of the boundary from the first joint [m]. It is exact for a planar chain of
    revolute joints without limits, and otherwise accurate to about 1e-5 of the total link length. It is the boundary
    that the search finds: for poses of a Panda, about one ray in twenty continues beyond it.

    Args:
        robot: the robot.
        task: a Task, or several.
        count: number of cases.
        seed: seed of the random numbers; case i is the same for every count.
        share: distance of the target as a share of the boundary distance, in (0, 1).
        q0: start of every case, (nq,) of the reduced robot; drawn when None.
        joints: joints that move, as in `InverseKinematics`.
        at: configuration at which the other joints are locked, as in `InverseKinematics`.

    Raises:
        ArgumentError: if no task has a position, the robot's reach is unbounded, no boundary is found, or an argument
            is invalid.
    """
    setup = ProblemSetup(robot, task, joints, at)
    position_task, starts = PositionTask.of(setup), StartSampler(setup, q0)
    part = number("share", share, "a number between 0 and 1")
    if not 0 < part < 1:
        raise ArgumentError("share", share, "a number between 0 and 1")
    bounded(position_task)
    origin = f"{100 * part:g} % of the distance from the first joint to the boundary of the workspace, found by solving"

    def draw(name: str, generator: np.random.Generator) -> Case:
        start = starts.draw(generator)
        for _ in range(ATTEMPTS):
            found = _boundary_target(position_task, setup.robot.random_configuration(generator), part)
            if found is None:
                continue
            target, reach = found
            return Case(
                name=name,
                kind="boundary",
                q0=start,
                targets=(target,),
                reachable=True,
                known={"error": 0.0, "reach": reach},
                origin=origin,
            )
        raise ArgumentError("robot", setup.robot, f"a robot whose workspace boundary is found with {ATTEMPTS} rays")

    return draw_set("boundary", count, seed, draw, origin)


def _boundary_target(position_task: PositionTask, goal: Array, share: float) -> tuple[Any, float] | None:
    """The target on the ray through the goal and the boundary distance [m]; None if the ray is unusable."""
    setup, bound = position_task.setup, position_task.bound
    away = position_task.only(position_task.position(goal) - position_task.center)
    begin = float(np.linalg.norm(away))
    if begin <= COARSE * bound:
        return None
    direction, target = away / begin, setup.target_at(goal)

    def at(distance: float) -> Any:
        return position_task.moved(target, (distance - begin) * direction)

    low, q = (bound, goal) if position_task.is_exact else _bisected(setup, at, begin, bound, goal)
    reached = setup.solve(at(share * low), q, restarts=RESTARTS)
    return None if reached is None else (at(share * low), low)


def _bisected(
    setup: ProblemSetup, at: Callable[[float], Any], begin: float, bound: float, q: Array
) -> tuple[float, Array]:
    """The boundary distance between ``begin``, which q reaches, and ``bound`` [m], and the last posture found."""
    low, high = begin, bound
    while high - low > RESOLUTION * bound:
        middle = (low + high) / 2
        wide = high - low > COARSE * bound
        found = setup.solve(
            at(middle),
            q,
            restarts=RESTARTS if wide else 0,
            max_iterations=RESTARTED_ITERATIONS if wide else MAX_ITERATIONS,
            tolerance=0.1 * RESOLUTION * bound,
        )
        low, high, q = (low, middle, q) if found is None else (middle, high, found)
    return low, q

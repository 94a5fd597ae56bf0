"""Following a path of targets: every solve starts where the last one ended and stays within reach of the velocities."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik.robot import Robot
from jtik.solution import Solution
from jtik.trajectory import Trajectory

Array = NDArray[np.float64]
Solve = Callable[[Any, Array], Solution]
Moved = Callable[[Solution, Array], Solution]


def follow(
    robot: Robot,
    targets: Sequence[Any],
    q0: Array,
    dt: float,
    limits: tuple[Array, Array],
    solve: Solve,
    moved: Moved,
) -> Trajectory:
    """One configuration a target, ``dt`` [s] apart, none farther from the last than the velocity limits allow.

    Args:
        robot: the robot.
        targets: what the tasks read as one, each.
        q0: where the robot stands at time 0, (nq,).
        dt: time from one target to the next [s].
        limits: the memory that a solve reads its box from, narrowed for each target and restored at the end.
        solve: a solve of one target from a configuration.
        moved: the same solution told of another configuration.
    """
    lower, upper = limits
    low, high = lower.copy(), upper.copy()
    reach = np.full(robot.nq, np.inf)
    reach[robot.scalar_q] = robot.velocity_limit[robot.scalar_v] * dt
    q, solutions, steps = q0, [], []
    try:
        for target in targets:
            down, up = q - reach, q + reach
            # outside the position limits the box is what the velocity limits allow on the way back
            lower[:] = np.minimum(np.maximum(low, down), up)
            upper[:] = np.maximum(np.minimum(high, up), down)
            solution = solve(target, q)
            if robot.nq != robot.n:
                solution = _slowed(robot, q, solution, dt, moved)
            steps.append(robot.difference(q, solution.q) if robot.nq != robot.n else solution.q - q)
            solutions.append(solution)
            q = solution.q
    finally:
        lower[:], upper[:] = low, high
    return Trajectory(
        times=dt * np.arange(1, len(solutions) + 1, dtype=np.float64),
        q=np.array([solution.q for solution in solutions]),
        dq=np.array(steps) / dt,
        errors=np.array([np.linalg.norm(solution.error) for solution in solutions]),
        statuses=tuple(solution.status for solution in solutions),
        iterations=np.array([solution.iterations for solution in solutions], dtype=np.int64),
        seconds=np.array([solution.seconds for solution in solutions]),
        joint_names=robot.joint_names,
    )


def _slowed(robot: Robot, start: Array, solution: Solution, dt: float, moved: Moved) -> Solution:
    """The solution, or how far the way to it leads in dt if a ball or free joint is too fast for the rest."""
    way = robot.difference(start, solution.q)
    allowed = robot.velocity_limit * dt
    share = float(np.min(np.divide(allowed, np.abs(way), out=np.ones(len(way)), where=np.abs(way) > allowed)))
    if share >= 1:
        return solution
    return replace(moved(solution, robot.integrate(start, share * way)), converged=False)

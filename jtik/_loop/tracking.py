"""Tracking: a path of targets, each solve starting where the last one ended and ending where the limits allow."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from jtik.constraints.step_box import StepBox
from jtik.result.length import lengths
from jtik.result.solution import Solution
from jtik.result.trajectory import Trajectory
from jtik.robot import Robot
from jtik.types import Array

Solve = Callable[[Any, Array], Solution]
Moved = Callable[[Solution, Array], Solution]


def follow(
    robot: Robot,
    targets: Iterable[Any],
    q0: Array,
    dt: float,
    box: StepBox,
    solve: Solve,
    moved: Moved,
) -> Trajectory:
    """Follow a path: one configuration a target, each within the box of a step from the one before.

    Ctrl-C ends the path after the last target that was solved for; before the first it is raised.

    Args:
        robot: the robot.
        targets: the targets.
        q0: where the robot stands still at time 0, (nq,).
        dt: time from one target to the next [s].
        box: the box on each step, on the memory that a solve reads, which is restored at the end.
        solve: solves for one target from a configuration.
        moved: gives the same solution for another configuration.
    """
    low, high = box.lower.copy(), box.upper.copy()
    q, solutions, steps, complete = q0, list[Solution](), list[Array](), True
    box.rest()
    try:
        for target in targets:
            box.narrow(q, dt)
            start = box.start()
            solution = solve(target, start)
            if not solution.converged and (solution.q == start).all():  # no step was accepted
                solution = moved(solution, box.braked())
            allowed = box.slowed(solution.q)
            if allowed is not solution.q:
                solution = replace(moved(solution, allowed), converged=False)
            steps.append(robot.difference(q, solution.q) if robot.nq != robot.n else solution.q - q)
            solutions.append(solution)
            q = solution.q
            box.moved(q)
    except KeyboardInterrupt:
        if not solutions:
            raise
        complete = False
    finally:
        box.lower[:], box.upper[:] = low, high
    steps = steps[: len(solutions)]
    errors = np.array([solution.error for solution in solutions])
    linear = solutions[0].report.linear
    return Trajectory(
        times=dt * np.arange(1, len(solutions) + 1, dtype=np.float64),
        start=q0.copy(),
        q=np.array([solution.q for solution in solutions]),
        dq=np.array(steps) / dt,
        error_norm=lengths(errors),
        position_error=lengths(errors[:, linear]),
        orientation_error=lengths(errors[:, ~linear]),
        status=tuple(solution.status for solution in solutions),
        iterations=np.array([solution.iterations for solution in solutions], dtype=np.int64),
        seconds=np.array([solution.seconds for solution in solutions]),
        joint_names=robot.joint_names,
        joint_sizes=tuple(joint.type.nq for joint in robot.independent_joints),
        complete=complete,
    )

"""Distant targets: a step approaches a nearer point in the same direction (formulations/distant_targets.md)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from jtik._step.symbolic_problem import SymbolicProblem
from jtik.robot import Robot
from jtik.robot.stroke import stroke
from jtik.symbolic import Expression, if_else, ratio, sqrt, sumsqr, zeros

NEARER = 0.5
"""Length of the residual that a step towards a distant target is made for, relative to the size of the robot."""


def left_out(problem: SymbolicProblem, residual: Expression, *, by_level: bool) -> Expression | None:
    """The part of the residual that a step leaves out because its target is distant (m, 1).

    A target is distant where the residual is longer than it can be for a target within reach, by `distant`.

    Args:
        problem: the problem.
        residual: the residual (m, 1).
        by_level: whether each level of priority is shortened by itself, rather than all rows alike.

    Returns:
        It, zero where no target is distant; None where none can be.
    """
    size, shares = robot_size(problem.robot), zeros(problem.m)
    groups = problem.levels if by_level else (tuple(range(problem.m)),)
    bounds = [distant(problem, rows, size) for rows in groups]
    if not any(map(math.isfinite, bounds)):
        return None
    for rows, bound in zip(groups, bounds, strict=True):
        if math.isfinite(bound):
            squared, nearer = sumsqr(residual[list(rows)]), NEARER * size * _stretch(problem, rows)
            shares[list(rows)] = if_else(squared > bound**2, 1 - ratio(nearer, sqrt(squared)), 0)
    return shares * residual


def distant(problem: SymbolicProblem, rows: Sequence[int], size: float) -> float:
    """The longest residual of these rows for a target within reach of a robot of this size; infinite for angles.

    A point is at most as far as twice the size of the robot from a target within its reach, and pi [rad] turned from
    it.
    """
    lengths = sum(problem.linear[row] for row in rows)
    if not lengths:
        return math.inf
    squared = math.ceil(lengths / 3) * (2 * size) ** 2 + math.ceil((len(rows) - lengths) / 3) * math.pi**2
    return _stretch(problem, rows) * math.sqrt(squared)


def robot_size(robot: Robot) -> float:
    """An upper bound of the distance of a frame from the base [m]; infinite with an unlimited translation."""
    strokes = {joint.name: float(stroke(robot, joint, robot.lower, robot.upper)) for joint in robot.joints}

    def distance(frame: str) -> float:
        return sum(float(np.linalg.norm(j.origin[:3, 3])) + strokes[j.name] for j in robot.path(frame))

    return max(map(distance, robot.frame_names))


def _stretch(problem: SymbolicProblem, rows: Sequence[int]) -> float:
    """The most by which the weighting lengthens an error of these rows."""
    return float(np.linalg.norm(problem.factor[:, list(rows)], 2))

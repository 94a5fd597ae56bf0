"""Distant targets: a step approaches a nearer point in the same direction (formulations/distant_targets.md)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jtik._step.symbolic_problem import SymbolicProblem
from jtik.result.length import length
from jtik.robot import Robot
from jtik.robot.stroke import stroke
from jtik.symbolic import (
    TINY,
    Expression,
    diag,
    fmin,
    if_else,
    is_symbolic,
    logic_and,
    mmax,
    norm,
    ratio,
    sqrt,
    sumsqr,
    vertcat,
)
from jtik.symbolic.factorization import squared_length
from jtik.types import Array

REACH = 2.0
"""Distance above which a target is distant, relative to the size of the robot: no target within reach is."""

NEARER = 0.5
"""Distance of the point that a step towards a distant target is made for, relative to the size of the robot."""

LARGEST_WEIGHT = 1e12
"""Largest weight of a joint: beyond it the orientation is lost in the rounding of V, and squares may overflow."""


@dataclass(frozen=True)
class NearerTarget:
    """The residual of a step towards a distant target: rows in [m] less a part of them, rows in [rad] weighted less.

    Both leave the direction of J' r as it is. For a target that is not distant the residual is as it is.

    Attributes:
        weights: what a row of the residual is multiplied by (m, 1).
        shift: what is then subtracted from it (m, 1).
        residual: the residual of the step (m, 1).
        weights_differ: whether any weight can differ from 1.
        share: share of the rows in [m] that the step is made for; of the lowest level where each has its own.
        linear: the rows in [m].
    """

    weights: Expression
    shift: Expression
    residual: Expression
    weights_differ: bool
    share: Expression
    linear: list[int]

    @classmethod
    def of(cls, problem: SymbolicProblem, residual: Expression, *, by_level: bool) -> NearerTarget | None:
        """That for a residual (m, 1); None for a problem without distant targets.

        Args:
            problem: the problem.
            residual: the residual to the target.
            by_level: whether each level of priority is considered by itself, rather than all rows together.
        """
        size = robot_size(problem.robot, problem.bounded)
        groups = problem.levels if by_level else (tuple(range(problem.m)),)
        bounds = [_largest(problem, rows, size) for rows in groups]
        if not any(map(math.isfinite, bounds)):
            return None
        weights, shift, share = [1] * problem.m, [0] * problem.m, 1
        of_step = [residual[row] for row in range(problem.m)]
        for rows, bound in zip(groups, bounds, strict=True):
            if math.isinf(bound):
                continue
            squared = sumsqr(residual[[row for row in rows if problem.linear[row]]])
            share = if_else(squared > bound**2, ratio(NEARER / REACH * bound, sqrt(squared)), 1)
            for row in rows:
                if problem.linear[row]:
                    of_step[row] = share * residual[row]
                    shift[row] = residual[row] - of_step[row]
                else:
                    weights[row] = sqrt(share)
                    of_step[row] = weights[row] * residual[row]
        linear = [row for row in range(problem.m) if problem.linear[row]]
        differ = any(map(is_symbolic, weights))
        return cls(vertcat(*weights), vertcat(*shift), vertcat(*of_step), differ, share, linear)

    def joint_scale(self, J: Expression, where: Expression) -> list[Expression]:
        """Displacements of the joints per coordinate of a step in which a joint weighs as much as its curvature of V.

        Args:
            J: the Jacobian of the residual to the target (m, n).
            where: 1 where a distant target is approached in these coordinates; else all are 1.
        """
        n, angular = J.shape[1], [row for row in range(J.shape[0]) if row not in self.linear]
        distance = ratio(norm(self.residual[self.linear]), self.share)
        of_angles = squared_length(J[angular, :]) / n + TINY
        weights = [1 + fmin(distance * norm(J[self.linear, j]) / of_angles, LARGEST_WEIGHT) for j in range(n)]
        largest = mmax(vertcat(*weights))
        where = logic_and(where, self.share < 1)
        return [if_else(where, sqrt(largest / weight), 1) for weight in weights]

    def weighted(self, rows: Expression) -> Expression:
        """A matrix (m, k) with its rows multiplied by the weights."""
        return diag(self.weights) @ rows if self.weights_differ else rows


def is_distant(problem: SymbolicProblem, residual: Array) -> bool:
    """Whether a residual (m,), of all rows together, is that of a distant target."""
    rows = [row for row in range(problem.m) if problem.linear[row]]
    return length(residual[rows]) > _largest(problem, range(problem.m), robot_size(problem.robot, problem.bounded))


def _largest(problem: SymbolicProblem, rows: Sequence[int], size: float) -> float:
    """Norm of the rows in [m] above which the target is beyond the reach of a robot of this size; infinite if none is.

    Without rows in [m] there is none, nor where the stiffness couples them with rows in [rad].
    """
    linear = [row for row in rows if problem.linear[row]]
    angular = [row for row in rows if not problem.linear[row]]
    if not linear or problem.factor[np.ix_(linear, angular)].any() or problem.factor[np.ix_(angular, linear)].any():
        return math.inf
    stretch = float(np.linalg.norm(problem.factor[:, linear], 2))
    points = math.ceil(len(linear) / 3)
    return stretch * math.sqrt(points) * REACH * size


def robot_size(robot: Robot, bounded: Sequence[tuple[int, int]]) -> float:
    """An upper bound of the distance of a frame from the base [m]; infinite with an unlimited translation.

    Args:
        robot: the robot.
        bounded: (q index, v index) of the joints whose limits hold.
    """
    held = [i for i, _ in bounded]
    lower, upper = np.full(robot.nq, -math.inf), np.full(robot.nq, math.inf)
    lower[held], upper[held] = robot.lower[held], robot.upper[held]
    strokes = {joint.name: float(stroke(robot, joint, lower, upper)) for joint in robot.joints}

    def distance(frame: str) -> float:
        return sum(float(np.linalg.norm(joint.origin[:3, 3])) + strokes[joint.name] for joint in robot.path(frame))

    return max(map(distance, robot.frame_names))

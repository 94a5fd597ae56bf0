"""The Hessian of H on the task's solutions, from the changes of gradients (formulations/weighted_qp.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jtik.strategy import LocalModel, Shape, State
from jtik.symbolic import Expression, dot, fmin, if_else, logic_and, norm, norm_inf, ratio, reshape, vec
from jtik.types import Array

SAME = 1e-9
"""Largest distance of q from where the last step ended for which the change of the gradients belongs to that step."""

SHORTEST = 1e-9
"""Shortest step that is evaluated: for a shorter one the change of the gradients is mostly rounding."""

DAMPED = 0.2
"""Smallest curvature along a step, relative to what B had there, that an update takes over: B stays definite."""

ANGLE = 1e-2
"""Smallest cosine between a step and the change of the gradient it is given: below it the update would make B huge."""

LARGEST = 3.0
"""Largest multipliers, relative to those of the task in H: far from the target r is too large to be one."""

HESSIAN, GRADIENT, JACOBIAN, STEP, ARRIVED = (
    f"secant_{name}" for name in ("hessian", "gradient", "jacobian", "step", "arrived")
)
"""Names of its state: lower triangle of B; gradient of H and J at the last q; the last step and where it ended."""


@dataclass(frozen=True)
class SecantHessian:
    """An estimate B of d2(H + lambda' r)/dv2 by the damped BFGS method, positive definite.

    It needs no second derivatives: they cost several times the step itself where H measures many distances.

    Attributes:
        first: curvature of H that is assumed before the first step, [unit of H / rad^2].

    Source: Powell (1978); Nocedal and Wright (2006), procedure 18.2.
    """

    first: float

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """``first`` times the identity, and no last step."""
        return {
            HESSIAN: self.first * np.eye(shape.n)[np.tril_indices(shape.n)],
            GRADIENT: np.zeros(shape.n),
            JACOBIAN: np.zeros(shape.m * shape.n),
            STEP: np.zeros(shape.n),
            ARRIVED: np.zeros(shape.nq),
        }

    def at(self, model: LocalModel, state: State, multipliers: Expression) -> Expression:
        """B (n, n) at q, after what the last step has shown.

        Args:
            model: the local model.
            state: its state.
            multipliers: lambda (m, 1) at q.
        """
        n = model.robot.n
        B = _symmetric(state[HESSIAN], n)
        is_there = norm_inf(model.here.q - state[ARRIVED]) <= SAME
        s = if_else(logic_and(is_there, norm_inf(state[STEP]) >= SHORTEST), state[STEP], 0)
        multipliers = fmin(1, ratio(LARGEST * norm(model.multipliers), norm(multipliers))) * multipliers
        change = (model.J - reshape(state[JACOBIAN], *model.J.shape)).T @ multipliers
        y = model.gradient - state[GRADIENT] + change
        Bs = B @ s
        expected, found = dot(s, Bs), dot(s, y)
        share = if_else(found >= DAMPED * expected, 1, (1 - DAMPED) * ratio(expected, expected - found))
        z = share * y + (1 - share) * Bs
        curvature = dot(s, z)
        learns = logic_and(expected > 0, curvature >= ANGLE * norm(s) * norm(z))
        gained, lost = ratio(learns, curvature), ratio(learns, expected)
        return _symmetric(_triangle(B + (gained * z) @ z.T - (lost * Bs) @ Bs.T), n)

    def known(self, model: LocalModel, B: Expression) -> State:
        """The entries of the state that belong to q, where B is the estimate."""
        return {HESSIAN: _triangle(B), GRADIENT: model.gradient, JACOBIAN: vec(model.J)}

    def after(self, model: LocalModel, dq: Expression, accepted: Expression) -> State:
        """The entries of the state that belong to the step ``dq`` (n, 1) from q."""
        return {STEP: if_else(accepted, dq, 0), ARRIVED: model.candidate(dq).q}


def _triangle(matrix: Expression) -> Expression:
    """The lower triangle of a matrix (n, n), row by row."""
    n = matrix.shape[0]
    rows, columns = np.tril_indices(n)
    return vec(matrix)[(rows + n * columns).tolist()]


def _symmetric(triangle: Expression, n: int) -> Expression:
    """The symmetric matrix (n, n) with this lower triangle, row by row."""
    rows, columns = np.indices((n, n))
    row, column = np.maximum(rows, columns), np.minimum(rows, columns)
    return reshape(triangle[(row * (row + 1) // 2 + column).ravel().tolist()], n, n)

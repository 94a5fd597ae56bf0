"""The task displacement within clearances, along them if they forbid the proposed one (formulations/clearance.md)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from jtik.qp import QuadraticProgram, Rows
from jtik.strategy import LocalModel
from jtik.symbolic import (
    TINY,
    Expression,
    dot,
    fmax,
    fmin,
    if_else,
    logic_and,
    mmax,
    mmin,
    norm,
    ratio,
    sqrt,
    sumsqr,
    vertcat,
    zeros,
)
from jtik.types import Array

DAMPING = 0.1
"""Curvature of the model in the null space of the task, relative to |r|^2 [1/rad^2]."""

SMALLEST_CURVATURE, LARGEST_CURVATURE = 1e-6, 1e-1
"""Its limits, relative to |J|^2."""

SMALLEST_COSINE = 1e-2
"""Cosine of the angle between displacement and -J' r above which the model of V has the displacement as its minimum."""

NEGLIGIBLE = 1e-6
"""Change of a displacement [rad] below which it is not reported."""

COMPLETE = 0.999
"""A share of the task displacement above this counts as 1: the rest is the solver's tolerance."""


@dataclass(frozen=True)
class ClearDisplacement:
    """A task displacement within the clearances.

    Attributes:
        dq: displacement (n, 1), the restoration of distances that are too small included.
        share: share of the decrease of V by the proposed displacement that it achieves in the model, 0 to 1.
        relaxed: the missing share, 0 where the proposed displacement is taken as it is.
    """

    dq: Expression
    share: Expression
    relaxed: Expression


def within_clearances(model: LocalModel, t: Expression, weight: Array) -> ClearDisplacement:
    """The displacement within limits and clearances that is closest to t in a model of V.

    Args:
        model: the local model, with clearances.
        t: proposed task displacement (n, 1).
        weight: cost of the motion of each velocity entry, (n,), positive.
    """
    n, (low, high) = model.robot.n, model.box
    metric, rows = _Metric(model, t, weight / weight.mean()), model.restoration.rows
    lower, upper, missing = low - t, high - t, rows.lower - rows.product(t)
    within = logic_and(mmax(lower) <= 0, logic_and(mmin(upper) >= 0, mmax(missing) <= 0))
    solution = model.solve(
        QuadraticProgram(
            P=metric.matrix,
            q=zeros(n),
            lower=lower,
            upper=upper,
            rows=[Rows(rows.name, rows.matrix, missing, rows.upper)],
            name="task step",
            closed_form=(zeros(n), within),
        )
    )
    change = solution.x
    lost = metric.square(change)
    if model.clearance and model.clearance.restores:  # what the restoration changes is not missing
        lost = fmax(sqrt(lost + TINY) - sqrt(metric.square(model.restoration.dq) + TINY), 0) ** 2
    share = fmax(1 - ratio(lost, metric.square_of_t), 0)
    short = logic_and(norm(change) > NEGLIGIBLE, share < COMPLETE)
    dq = fmin(fmax(t + change, low), high)  # the solver's tolerance must not leave the box
    return ClearDisplacement(dq, share, if_else(short, 1 - share, 0))


@dataclass(frozen=True)
class _Metric:
    """The Hessian P of a quadratic model of V whose minimiser is t, scaled so that its smallest eigenvalue is about 1.

    That of Gauss and Newton, (J'J + mu W) / mu, is changed in one direction so that P t is a multiple of -J' r:
    P = W + A'A + b b' - c c'.

    Attributes:
        model: the local model.
        t: the displacement (n, 1).
        weight: diagonal of W, (n,).
    """

    model: LocalModel
    t: Expression
    weight: Array

    @cached_property
    def _gauss_newton(self) -> tuple[Expression, Expression]:
        """A (m, n), and (W + A'A) t (n, 1)."""
        size = self.model.row_space.squared_length
        if self.model.timed:
            curvature = self.model.curvature
        else:
            curvature = fmin(DAMPING * sumsqr(self.model.here.residual), LARGEST_CURVATURE * size)
        A = self.model.J / sqrt(fmax(curvature, SMALLEST_CURVATURE * size) + TINY)
        return A, vertcat(*self.weight.tolist()) * self.t + A.T @ (A @ self.t)

    @cached_property
    def _change(self) -> tuple[Expression, Expression]:
        """b and c (n, 1); zeros where t is nearly orthogonal to J' r, or V rises along it."""
        along, gradient = self._gauss_newton[1], self.model.J.T @ self.model.here.residual
        decrease = -dot(gradient, self.t)
        falls = decrease > SMALLEST_COSINE * sqrt(sumsqr(gradient) * sumsqr(self.t))
        length = sqrt(self.square_of_t + TINY)
        return falls * ratio(length, fmax(decrease, 0)) * gradient, falls / length * along

    @cached_property
    def square_of_t(self) -> Expression:
        """t' P t."""
        return dot(self.t, self._gauss_newton[1])

    @cached_property
    def matrix(self) -> Expression:
        """P (n, n), each entry computed once."""
        (A, _), (b, c), n = self._gauss_newton, self._change, len(self.weight)
        P = zeros(n, n)
        for i in range(n):
            for j in range(i, n):
                P[i, j] = P[j, i] = dot(A[:, i], A[:, j]) + b[i] * b[j] - c[i] * c[j]
            P[i, i] += self.weight[i]
        return P

    def square(self, x: Expression) -> Expression:
        """x' P x."""
        (A, _), (b, c) = self._gauss_newton, self._change
        weighted = dot(vertcat(*self.weight.tolist()) * x, x)
        return weighted + sumsqr(A @ x) + dot(b, x) ** 2 - dot(c, x) ** 2

"""The null-space step as a quadratic program, with the joint limits as its box (formulations/qp_secondary.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jtik import register_secondary
from jtik._step.active_set import AT_LIMIT
from jtik.errors import ArgumentError
from jtik.qp import QuadraticProgram, Rows
from jtik.strategy import LocalModel, NullMove, State
from jtik.symbolic import (
    TINY,
    Expression,
    diag,
    dot,
    fmax,
    fmin,
    horzcat,
    if_else,
    logic_and,
    logic_not,
    logic_or,
    norm,
    ratio,
    sqrt,
    vertcat,
    zeros,
)
from jtik.symbolic.factorization import RowSpace
from jtik.types import Array
from jtik_formulations.strategies.projected_gradient import NOISE, ProjectedGradient


@register_secondary("qp")
@dataclass(frozen=True, kw_only=True)
class QPSecondary(ProjectedGradient):
    """nu minimises 1/2 nu' W nu + beta grad H' nu where J nu = 0 and task step and nu together keep to the limits.

    Without limits and with W = I it is the projected gradient. With them, a joint that meets its limit does not stop
    the others: the program finds the best direction among those that are left, all at once.

    Attributes:
        weight: diagonal of W, one positive number or one a joint: a heavier joint moves less.

    beta follows the rule of `ProjectedGradient`, whose options are here too.

    Source: Siciliano, Sciavicco, Villani and Oriolo (2009), section 3.5.1 for the projection as a program; Kanoun,
    Lamiraux and Wieber (2011) for inequalities beside equalities.
    """

    weight: float | Sequence[float] = 1.0

    summary = "null-space step by a QP with the joint limits in it"
    source = "Kanoun, Lamiraux and Wieber 2011"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rule != "merit":
            raise ArgumentError("rule", self.rule, "'merit': the other rules know nothing of limits")
        try:
            weight = np.asarray(self.weight, dtype=float)
        except (TypeError, ValueError):
            weight = np.full(1, np.nan)
        if weight.ndim > 1 or not (np.isfinite(weight).all() and (weight > 0).all()):
            raise ArgumentError("weight", self.weight, "a positive number, or one for each velocity entry")

    def uses_qp(self) -> bool:
        """Yes."""
        return True

    def supports_clearances(self) -> bool:
        """Yes."""
        return True

    def free_gradient(self, model: LocalModel) -> Expression:
        """That of all joints: a program finds out by itself who is held."""
        return model.full_null_gradient

    def propose(self, model: LocalModel, state: State, task_term: Expression) -> NullMove:
        """The program's answer, and how far H is from stationary: |nu| / beta."""
        h, n = _reduced_gradient(model), model.robot.n
        weight = np.asarray(self.weight, dtype=float)
        if weight.shape not in ((), (n,)):
            raise ArgumentError("weight", self.weight, f"a positive number, or {n}, one for each velocity entry")
        weight = np.broadcast_to(weight, n)
        length = norm(h)
        beta = fmin(self.barzilai_borwein(model, state), ratio(state["null_cap"], length))
        figures, relaxed = dict[str, Expression](), dict[tuple[str, str], Expression]()
        if model.clearance:
            move, scale = self._clear(model, weight, beta, task_term)
            figures["task_share"] = scale
            short = logic_and((1 - scale) * norm(task_term) > SHORT, scale < MOST)
            relaxed["task step", "share"] = if_else(short, 1 - scale, 0)
        else:
            move, scale = self._within_limits(model, weight, beta, length, task_term), 1
        moved = norm(move)
        return NullMove(
            term=-move,
            length=moved,
            decrease=-dot(model.full_gradient, move),
            beta=beta,
            stationarity_residual=ratio(norm(weight * move), beta),
            task_scale=scale,
            keeps_limits=True,
            figures=figures,
            relaxed=relaxed,
        )

    def _within_limits(
        self, model: LocalModel, weight: Array, beta: Expression, length: Expression, task_term: Expression
    ) -> Expression:
        """nu: no motion of the task, and the sum of both terms in the box."""
        low, high = model.box
        worth = if_else(length > NOISE * norm(model.full_gradient), 1, 0)
        answer = model.solve(
            QuadraticProgram(
                P=diag(vertcat(*weight.tolist())),
                q=worth * beta * model.full_null_gradient,  # the rest of the gradient is the multipliers' alone
                lower=low + task_term,
                upper=high + task_term,
                rows=[_task_rows(model, model.full_rows.unit_basis)],
                name="null-space step",
            )
        )
        return worth * answer.x

    def _clear(
        self, model: LocalModel, weight: Array, beta: Expression, task_term: Expression
    ) -> tuple[Expression, Expression]:
        """nu and the share s of the task step t that the clearances leave room for, from (y, s) with y = s t + nu.

        Without bodies that are too near y = 0, s = 0 is always feasible, with them y = x, s = 0, the step that moves
        them out, whose motion of the task stays. s comes before H: its price is far above what nu could gain. Its
        unit in the program is chosen so that the curvature is 1, however short t is.
        """
        n, t = model.robot.n, -task_term
        low, high = model.box
        K = model.full_rows.unit_basis
        Wt, slope = weight * t, beta * model.full_null_gradient  # the rest of the gradient is the multipliers' alone
        price = _PRICE * (dot(t, Wt) + norm(slope) * norm(t) + TINY) + _LEAST_PRICE
        unit = sqrt(dot(t, Wt) + price)
        P = vertcat(horzcat(diag(vertcat(*weight.tolist())), -Wt / unit), horzcat(-Wt.T / unit, 1))
        q = vertcat(slope, -(dot(slope, t) + price) / unit)
        room = model.recovery
        kept, demanded = room.rows, K @ room.step
        answer = model.solve(
            QuadraticProgram(
                P=P,
                q=q,
                lower=vertcat(low, 0),
                upper=vertcat(high, unit),
                rows=[
                    _task_rows(model, horzcat(K, -K @ t / unit), demanded),
                    Rows(kept.name, horzcat(kept.matrix, zeros(kept.count)), kept.lower, kept.upper),
                ],
                name="null-space step",
            )
        )
        y, scale = answer.x[:n], fmin(fmax(answer.x[n] / unit, 0), 1)
        return y - scale * t, scale


def _reduced_gradient(model: LocalModel) -> Expression:
    """(I - J+ J) dH/dv over the joints that its own direction does not press against a limit, (n, 1): for the gain.

    A guess of what the program will find, right at the end: there it vanishes, where that of all joints need not.
    """
    h = model.full_null_gradient
    if not model.bounded:
        return h
    low, high = model.box
    free: list[Expression] = [1] * model.robot.n
    for _, j in model.bounded:
        pressed = logic_or(logic_and(high[j] < AT_LIMIT, h[j] < 0), logic_and(low[j] > -AT_LIMIT, h[j] > 0))
        free[j] = logic_not(pressed)
    J = horzcat(*[model.full_J[:, j] * keep for j, keep in enumerate(free)])
    return RowSpace(J).split(vertcat(*free) * model.full_gradient).null


def _task_rows(model: LocalModel, matrix: Expression, to: Expression = 0) -> Rows:
    """matrix x = to; rows of zeros, of a dependent task, are free."""
    return Rows("task", matrix, *[to + model.full_rows.dependent_bounds(side) for side in (-1, 1)])


SHORT = 1e-6
"""Length of a task step [rad] below which it is no matter how much of it is left out."""

MOST = 0.999
"""A share of the task step above this is all of it, but for the solver's rounding."""

_PRICE = 1e4
"""Price of a share of the task step in units of what the null space could gain: near enough to strict priority."""

_LEAST_PRICE = 1e-9
"""Keeps the program strictly convex in s where there is no task step left."""

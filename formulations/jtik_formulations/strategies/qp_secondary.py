"""The null-space step as a quadratic program, with the joint limits as its box (formulations/qp_secondary.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jtik import register_secondary
from jtik.constraints.limits import AT_LIMIT
from jtik.errors import ArgumentError
from jtik.qp import QuadraticProgram, Rows
from jtik.strategy import LocalModel, NullSpaceDisplacement, Outcome, State
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
    sumsqr,
    vertcat,
    zeros,
)
from jtik.symbolic.factorization import RowSpace
from jtik.types import Array
from jtik_formulations.strategies._parts.significance import in_null_space, significant
from jtik_formulations.strategies.projected_gradient import ProjectedGradient

NEGLIGIBLE = 1e-6
"""Norm of the omitted part of a task displacement [rad] below which it is not reported."""

COMPLETE = 0.999
"""A share of the task displacement above this counts as 1: the rest is the solver's tolerance."""

PENALTY = 1e4
"""Penalty weight of the omitted share over the possible decrease in the null space: nearly strict priority."""

SMALLEST_PENALTY = 1e-9
"""Keeps the quadratic program strictly convex in s where the task displacement is zero."""


@register_secondary("qp")
@dataclass(frozen=True, kw_only=True)
class QPSecondary(ProjectedGradient):
    """nu minimises 1/2 nu' W nu + beta grad H' nu where J nu = 0 and task step and nu together are within the limits.

    Without limits and with W = I it is the projected gradient. With limits, a joint that reaches its limit does not
    stop the others: the quadratic program finds the best of the directions that the limits allow. beta follows
    the rule "merit" of `ProjectedGradient`.

    Attributes:
        weight: diagonal of W, one positive number, or one for each velocity entry: a heavier joint moves less.
        rule: "merit".
        step_limit: longest null-space step [rad].
        beta_max: first gain; the unit of q^2 over that of H.
        floor: not used.

    Source: Siciliano, Sciavicco, Villani and Oriolo (2009), section 3.5.1 for the projection as a quadratic program;
    Kanoun, Lamiraux and Wieber (2011) for inequalities beside equalities.
    """

    weight: float | Sequence[float] = 1.0

    summary = "null-space step by a QP with the joint limits in it"
    source = "Kanoun, Lamiraux and Wieber 2011"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rule != "merit":
            raise ArgumentError("rule", self.rule, "'merit': the other rules ignore limits")
        try:
            weight = np.asarray(self.weight, dtype=float)
        except (TypeError, ValueError):
            weight = np.full(1, np.nan)
        if weight.ndim > 1 or not (np.isfinite(weight).all() and (weight > 0).all()):
            raise ArgumentError("weight", self.weight, "a positive number, or one for each velocity entry")

    def uses_qp(self) -> bool:
        """Always."""
        return True

    def supports_clearances(self) -> bool:
        """Always."""
        return True

    def propose(self, model: LocalModel, state: State, task_dq: Expression) -> NullSpaceDisplacement:
        """The solution of the quadratic program, and the stationarity residual of H, |W nu| / beta."""
        h, n = _reduced_gradient(model), model.robot.n
        weight = np.asarray(self.weight, dtype=float)
        if weight.shape not in ((), (n,)):
            raise ArgumentError("weight", self.weight, f"a positive number, or {n}, one for each velocity entry")
        weight = np.broadcast_to(weight, n)
        length = norm(h)
        # of all joints: a quadratic program finds the active limits by itself
        beta = fmin(self.gain.gain(model, state, model.null_gradient), ratio(state["null_cap"], length))
        figures, relaxed = dict[str, Expression](), dict[tuple[str, str], Expression]()
        if model.clearance:
            dq, scale = self._with_clearances(model, weight, beta, task_dq)
            figures["task_share"] = scale
            short = logic_and((1 - scale) * norm(task_dq) > NEGLIGIBLE, scale < COMPLETE)
            relaxed["task step", "share"] = if_else(short, 1 - scale, 0)
        else:
            dq, scale = self._within_limits(model, weight, beta, length, task_dq), 1
        return NullSpaceDisplacement(
            dq=self._without_leakage(model, dq, scale * task_dq),
            beta=beta,
            stationarity_residual=ratio(norm(weight * dq), beta),
            task_scale=scale,
            within_limits=True,
            figures=figures,
            relaxed=relaxed,
        )

    def adapt(self, model: LocalModel, state: State, null_space: NullSpaceDisplacement, outcome: Outcome) -> State:
        """The state of the gain after the outcome is known."""
        return self.gain.adapt(model, state, model.null_gradient, null_space, outcome)

    def _within_limits(
        self, model: LocalModel, weight: Array, beta: Expression, length: Expression, task_dq: Expression
    ) -> Expression:
        """nu that does not move the end effector, the sum of both displacements in the box."""
        low, high = model.box
        is_significant = if_else(significant(length, norm(model.gradient)), 1, 0)
        solution = model.solve(
            QuadraticProgram(
                P=diag(vertcat(*weight.tolist())),
                q=is_significant * beta * model.null_gradient,  # the rest of the gradient changes only the multipliers
                lower=low - task_dq,
                upper=high - task_dq,
                rows=[_task_rows(model, model.row_space.unit_basis)],
                name="null-space step",
            )
        )
        return is_significant * solution.x

    @staticmethod
    def _without_leakage(model: LocalModel, dq: Expression, task_dq: Expression) -> Expression:
        """dq where it is in the null space, or restores a clearance, else zero: it is then the solver's noise."""
        K = model.row_space.unit_basis
        if not model.clearance:
            return in_null_space(K, dq, task_dq) * dq
        # the share of the task displacement, of order 1, is a variable of the same quadratic program
        restores = sumsqr(model.restoration.dq) > 0 if model.clearance.restores else 0
        return logic_or(restores, in_null_space(K, dq, task_dq, shortest=1.0)) * dq

    def _with_clearances(
        self, model: LocalModel, weight: Array, beta: Expression, t: Expression
    ) -> tuple[Expression, Expression]:
        """nu and the share s of the task displacement t that the clearances allow, from (y, s) with y = s t + nu.

        If no distance is too small, y = 0 and s = 0 are feasible; otherwise y = x and s = 0, with x the restoration
        step, whose change of the task is kept. s has priority over H: its penalty weight is far above any
        decrease of H by nu. Its unit in the quadratic program is chosen so that the curvature is 1, however short t is.
        """
        n = model.robot.n
        low, high = model.box
        K = model.row_space.unit_basis
        Wt, gradient = weight * t, beta * model.null_gradient  # the rest of it changes only the multipliers
        penalty = PENALTY * (dot(t, Wt) + norm(gradient) * norm(t) + TINY) + SMALLEST_PENALTY
        unit = sqrt(dot(t, Wt) + penalty)
        P = vertcat(horzcat(diag(vertcat(*weight.tolist())), -Wt / unit), horzcat(-Wt.T / unit, 1))
        q = vertcat(gradient, -(dot(gradient, t) + penalty) / unit)
        restoration = model.restoration
        kept, demanded = restoration.rows, K @ restoration.dq
        solution = model.solve(
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
        y, scale = solution.x[:n], fmin(fmax(solution.x[n] / unit, 0), 1)
        return y - scale * t, scale


def _reduced_gradient(model: LocalModel) -> Expression:
    """(I - J+ J) dH/dv of the joints that -h does not push outward at a limit, (n, 1): for the gain.

    An estimate of what the quadratic program will find. At the optimum it vanishes, where that of all joints need not.
    """
    h = model.null_gradient
    if not model.bounded:
        return h
    low, high = model.box
    free: list[Expression] = [1] * model.robot.n
    for _, j in model.bounded:
        outward = logic_or(logic_and(high[j] < AT_LIMIT, h[j] < 0), logic_and(low[j] > -AT_LIMIT, h[j] > 0))
        free[j] = logic_not(outward)
    J = horzcat(*[model.J[:, j] * keep for j, keep in enumerate(free)])
    return RowSpace(J).split(vertcat(*free) * model.gradient).null


def _task_rows(model: LocalModel, matrix: Expression, to: Expression = 0) -> Rows:
    """matrix x = to, exactly; rows of zeros, of a dependent task, are free."""
    return Rows.in_null_space("task", model.row_space, matrix, to)

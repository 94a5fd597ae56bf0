"""The null-space term by second derivatives: a Newton step on the conditions of optimality, as a quadratic program
(formulations/second_order.md).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from jtik import register_secondary
from jtik._step.active_set import AT_LIMIT
from jtik.errors import ArgumentError
from jtik.qp import QuadraticProgram, Rows
from jtik.strategy import LocalModel, NullMove, Outcome, SecondaryTerm, Shape, State
from jtik.strategy.curvature import lagrangian_hessian
from jtik.symbolic import (
    TINY,
    Expression,
    diag,
    dot,
    fabs,
    fmax,
    fmin,
    horzcat,
    identity,
    if_else,
    logic_and,
    logic_not,
    logic_or,
    norm,
    norm_inf,
    ratio,
    sumsqr,
    vec,
    vertcat,
)
from jtik.symbolic.factorization import RowSpace, Split
from jtik.types import Array
from jtik_formulations.strategies.projected_gradient import NOISE

FLAT, RAISED = 1e-8, 1e-2
"""A pivot of the reduced Hessian below the first fraction of its largest entry counts as zero; what it is raised to."""

NEGATIVE = 1e-3
"""A pivot below minus this fraction is a way down without an end in sight: the step goes as far as its cap."""

SHORT = 0.5
"""A second-order correction longer than this share of the step it corrects is no small one, and is left out."""

STIFFEST = 1e3
"""Most by which the Hessian without the task's curvature is scaled up."""


@register_secondary("second_order")
@dataclass(frozen=True, kw_only=True)
class SecondOrder(SecondaryTerm):
    """With Newton's task step t, both together are the SQP step: quadratic convergence to the constrained optimum.

    x = -nu minimises (dH/dv - W t)' x + 1/2 x' W x where J x = 0 and t and x together keep to the limits, with
    W = d2(H + lambda' r)/dv2 at v = 0. Where W is not positive definite on the null space it is made so.

    Prefer it where the optimum is wanted to the last digits, or where H is so badly scaled that the gradient creeps;
    a step costs several times that of `ProjectedGradient`.

    Attributes:
        curvature: ``"exact"``: W as above; ``"gauss_newton"``: without the curvature of the task, the term with
            lambda. Cheaper, and convex where H is, but of linear convergence where lambda is not zero.
        step_limit: longest null-space step [rad].
        corrections: how often the step is mended by J+ times what the tip would miss on it. Without any the merit
            refuses good steps near the optimum (Maratos effect); with one still those along a valley of H.

    Source: Nocedal and Wright, *Numerical Optimization*, chapters 15 and 18; Gill, Murray and Wright (1981) for the
    modified factorisation; Maratos (1978), Fletcher (1982) for the correction.
    """

    curvature: Literal["exact", "gauss_newton"] = "exact"
    step_limit: float = 0.3
    corrections: int = 2

    summary = "null-space step by the Hessian of the Lagrangian: quadratic convergence"
    source = "Nocedal and Wright 2006, chapter 18; Gill, Murray and Wright 1981"

    def __post_init__(self) -> None:
        if not (isinstance(self.curvature, str) and self.curvature in ("exact", "gauss_newton")):
            raise ArgumentError("curvature", self.curvature, "'exact' or 'gauss_newton'")
        if not 0 < self.step_limit < math.inf:
            raise ArgumentError("step_limit", self.step_limit, "a positive, finite length [rad]")
        if isinstance(self.corrections, bool) or not (isinstance(self.corrections, int) and self.corrections >= 0):
            raise ArgumentError("corrections", self.corrections, "an integer from 0")

    def uses_qp(self) -> bool:
        """Yes."""
        return True

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The cap of the step; without the exact Hessian also the last step and the slope it began with."""
        first = {"null_cap": np.full(1, self.step_limit)}
        if self.curvature == "gauss_newton":
            first |= {"null_step": np.zeros(shape.n), "slope": np.zeros(shape.n)}
        return first

    def propose(self, model: LocalModel, state: State, task_term: Expression) -> NullMove:
        """The program's answer, and how far H is from stationary."""
        free, rows, split, slope = _optimality(model)
        W = lagrangian_hessian(
            model.robot,
            model.criterion_function,
            model.residual_function,
            q=model.here.q,
            target=model.target,
            parameters=model.parameters,
            multipliers=-split.multipliers if self.curvature == "exact" else None,
        )
        if self.curvature == "gauss_newton":
            W = _stiffness(W, state["null_step"], slope - state["slope"]) * W
        basis = rows.unit_basis
        onto_null = diag(free) - basis.T @ basis
        reduced = onto_null @ W @ onto_null
        slope_there = slope - onto_null @ (W @ rows.least_squares(model.full_J @ task_term).vector)
        size = fmax(norm_inf(vec(reduced)), norm_inf(slope_there) / self.step_limit) + TINY
        others = identity(model.robot.n) - onto_null
        bend, definite, lowest = convexified(reduced / size + others)

        cap = state["null_cap"]
        low, high = model.box
        lower, upper = fmax(low + task_term, -cap), fmin(high + task_term, cap)
        moving = _moving(model)
        tip = RowSpace(_masked(model.full_J, moving)) if model.bounded else model.rows
        fixed = Rows("task", tip.unit_basis, *[tip.dependent_bounds(side) for side in (-1, 1)])
        # solvers have absolute tolerances: an answer of order 1 to data of order 1. A step that the cap cuts most of
        # goes down the slope, as one of infinite curvature does
        push = moving * slope_there / size
        steep = norm_inf(push)
        unit, ease = fmin(cap, steep) + TINY, fmax(1, ratio(steep, cap))
        P = (bend + (ease - 1) * identity(model.robot.n)) / ease
        answer = model.solve(
            QuadraticProgram(P, ratio(push, steep), lower / unit, upper / unit, [fixed], "null-space step")
        )
        x = fmin(fmax(unit * answer.x, lower), upper)
        significant = norm(slope_there) > NOISE * norm(model.full_gradient)
        longest = ratio(cap, norm(x))
        x = if_else(significant, 1, 0) * if_else(lowest < -NEGATIVE, longest, fmin(1, longest)) * x
        stationarity_residual = _stationarity_residual(model, slope)
        return NullMove(
            term=-x,
            length=norm(x),
            decrease=-dot(slope, x),
            beta=math.nan,
            stationarity_residual=stationarity_residual,
            figures={"null_residual": stationarity_residual, "positive_definite": definite},
        )

    def correct(self, model: LocalModel, term: Expression) -> Expression:
        """Near the target the step lengthened by J+ times what the tip misses on it, again and again."""
        if not self.corrections:
            return term
        wanted = model.here.residual - model.full_J @ term
        there, mended = model.moved(term), term
        rows = RowSpace(_masked(model.full_J, _free(model, there.q))) if model.bounded else model.rows
        for k in range(self.corrections):
            missed = (there if k == 0 else model.moved(mended)).residual - wanted
            mended = model.within_limits(mended + rows.least_squares(missed).vector)
        small = logic_and(model.near, norm(mended - term) <= SHORT * norm(term))
        return if_else(small, mended, term)

    def adapt(self, model: LocalModel, state: State, move: NullMove, outcome: Outcome) -> State:
        """The cap: four times after an acceptance, a quarter of the step after a refusal that is its fault."""
        cap, tried = state["null_cap"], outcome.null.length
        shorter = if_else(outcome.null_blamed, fmin(tried, cap) / 4, cap)
        after = {"null_cap": if_else(outcome.accepted, fmin(4 * cap, self.step_limit), shorter)}
        if self.curvature == "gauss_newton":
            after["null_step"] = if_else(outcome.accepted, -outcome.null.term, state["null_step"])
            after["slope"] = if_else(outcome.accepted, _optimality(model)[3], state["slope"])
        return after


def convexified(A: Expression) -> tuple[Expression, Expression, Expression]:
    """A symmetric ``A`` (n, n) with entries of order 1, plus a diagonal that makes it positive definite; whether that
    is zero; and the lowest pivot, or 0.

    It is exactly zero where A is positive definite. By the modified factorisation L D L' of Gill, Murray and Wright
    (1981): a pivot that is not above FLAT, or too small for the column it divides, is raised.
    """
    n = A.shape[0]
    diagonal = [fabs(A[i, i]) for i in range(n)]
    others = [fabs(A[i, j]) for i in range(n) for j in range(i)]
    most = fmax(2 * _largest(diagonal), _largest(others)) + TINY  # of any entry of L D^1/2, squared
    rest = [[A[i, j] for j in range(i + 1)] for i in range(n)]
    added, definite, lowest = [], 1, 0
    for j in range(n):
        column = [rest[i][j] for i in range(j + 1, n)]
        least = _largest([fabs(entry) for entry in column]) ** 2 / most
        pivot = rest[j][j]
        good = logic_and(pivot > FLAT, pivot >= least)
        used = if_else(good, pivot, fmax(fmax(fabs(pivot), least), RAISED))
        added.append(used - pivot)
        definite = logic_and(definite, good)
        lowest = fmin(lowest, pivot)
        for i in range(j + 1, n):
            factor = rest[i][j] / used
            for k in range(j + 1, i + 1):
                rest[i][k] = rest[i][k] - factor * rest[k][j]
    return A + diag(vertcat(*added)), definite, lowest


def _optimality(model: LocalModel) -> tuple[Expression, RowSpace, Split, Expression]:
    """Joints not at a limit, the row space of their Jacobian, their gradient in it, and the slope of the Lagrangian."""
    free = _free(model, model.here.q)
    rows = RowSpace(_masked(model.full_J, free)) if model.bounded else model.rows
    split = rows.split(free * model.full_gradient)
    pressed = model.full_gradient - model.full_J.T @ split.multipliers
    return free, rows, split, if_else(free, split.null, pressed)


def _stiffness(W: Expression, step: Expression, change: Expression) -> Expression:
    """How much more the slope changed along the last step than W says, from 1: what W leaves out must not overshoot."""
    said = dot(step, W @ step)
    return if_else(said > 0, fmin(fmax(ratio(dot(step, change), fmax(said, 0)), 1), STIFFEST), 1)


def _largest(values: Sequence[Expression]) -> Expression:
    largest: Expression = 0
    for value in values:
        largest = fmax(largest, value)
    return largest


def _free(model: LocalModel, q: Expression) -> Expression:
    """1 for each velocity entry that is not at a limit, else 0, (n, 1)."""
    entries: list[Expression] = [1] * model.robot.n
    for i, j in model.bounded:
        entries[j] = logic_and(q[i] < model.upper[i] - AT_LIMIT, q[i] > model.lower[i] + AT_LIMIT)
    return vertcat(*entries)


def _moving(model: LocalModel) -> Expression:
    """0 for the joints whose limit the task presses them against on the way to the target, else 1, (n, 1)."""
    entries: list[Expression] = [1] * model.robot.n
    for _, j in model.bounded:
        pressed = logic_and(sumsqr(model.J[:, j]) == 0, sumsqr(model.full_J[:, j]) > 0)
        entries[j] = logic_or(model.near, logic_not(pressed))
    return vertcat(*entries)


def _masked(J: Expression, free: Expression) -> Expression:
    """J with zeros in the columns of the joints at a limit."""
    return horzcat(*[J[:, j] * free[j] for j in range(J.shape[1])])


def _stationarity_residual(model: LocalModel, slope: Expression) -> Expression:
    """Norm of the slope of the Lagrangian over the joints it does not press against a limit they are at."""
    q = model.here.q
    entries = [slope[j] for j in range(model.robot.n)]
    for i, j in model.bounded:
        entries[j] = if_else(q[i] >= model.upper[i] - AT_LIMIT, fmax(entries[j], 0), entries[j])
        entries[j] = if_else(q[i] <= model.lower[i] + AT_LIMIT, fmin(entries[j], 0), entries[j])
    return norm(vertcat(*entries))

"""The null-space term by second derivatives: a Newton step on the conditions of optimality, as a quadratic program
(formulations/second_order.md).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from jtik import register_secondary
from jtik.constraints.limits import AT_LIMIT
from jtik.qp import QuadraticProgram, Rows
from jtik.strategy import (
    LocalModel,
    NullSpaceDisplacement,
    Outcome,
    Positive,
    SecondaryTerm,
    Shape,
    State,
)
from jtik.strategy.curvature import lagrangian_hessian
from jtik.symbolic import (
    TINY,
    Expression,
    diag,
    dot,
    fmax,
    fmin,
    horzcat,
    identity,
    if_else,
    is_finite,
    is_symbolic,
    logic_and,
    logic_not,
    logic_or,
    looped,
    norm,
    norm_inf,
    ratio,
    sumsqr,
    vec,
    vertcat,
)
from jtik.symbolic.convexified import convexified
from jtik.symbolic.factorization import RowSpace, Split
from jtik.types import Array
from jtik_formulations.bibliography import GILL_1981, NOCEDAL_WRIGHT_2006
from jtik_formulations.strategies._parts.significance import in_null_space, significant

NEGATIVE = 1e-3
"""A pivot below minus this fraction is negative curvature: the step then is as long as its cap allows."""

SMALLEST_SHARE = 1e-6
"""Smallest share of a step for which its bounds are enlarged."""

UNROLLED = 12
"""Most joints for which products and the factorisation of matrices are written out, which is faster for a few."""

SHORT = 0.5
"""Longest second-order correction, relative to the step that it corrects; a longer one is omitted."""

SHORTEST = 1e-9
"""Length of the solution of the quadratic program, whose data are of order 1, up to which it is the solver's noise."""

LARGEST_ENTRY = 1e3
"""Largest entry of its gradient: a joint that is pushed outward at a limit stays there."""

LARGEST_SCALE = 1e3
"""Largest factor by which the Hessian without the task's curvature is scaled."""


@register_secondary("second_order")
@dataclass(frozen=True, kw_only=True)
class SecondOrder(SecondaryTerm):
    """With Newton's task step t, both together are the SQP step: quadratic convergence to the constrained optimum.

    x minimises (dH/dv + W t)' x + 1/2 x' W x where J x = 0 and t + x keeps to the limits, with t the task displacement
    and W = d2(H + lambda' r)/dv2 at v = 0. Where W is not positive definite on the null space it is made so, by the
    Gauss-Newton Hessian of a criterion in residual form (`jtik.criterion.ResidualCriterion`), otherwise by a diagonal.

    Prefer it where the optimum is wanted with high accuracy, or where H is so badly scaled that gradient steps are
    slow; a step needs several times the computation of `ProjectedGradient`.

    Attributes:
        curvature: ``"exact"``: W as above; ``"gauss_newton"``: without the curvature of the task, the term with
            lambda, and with the Gauss-Newton Hessian of each criterion in residual form. It needs less computation and
            is convex where H is, but converges linearly where lambda is not zero.
        step_limit: longest null-space step [rad].
        corrections: number of second-order corrections, each -J+ times the task error that the step would leave.
            Without any the merit function refuses good steps near the optimum (Maratos effect); with one it still
            refuses those along a valley of H.

    Source: Nocedal and Wright, *Numerical Optimization*, chapters 15 and 18; Gill, Murray and Wright (1981) for the
    modified factorisation; Maratos (1978), Fletcher (1982) for the correction.
    """

    curvature: Literal["exact", "gauss_newton"] = "exact"
    step_limit: Positive = 0.3
    corrections: int = 2

    summary = "null-space step by the Hessian of the Lagrangian: quadratic convergence"
    source = "Nocedal and Wright 2006, chapter 18; Gill, Murray and Wright 1981"
    bibtex = "\n".join((NOCEDAL_WRIGHT_2006, GILL_1981))

    def uses_qp(self) -> bool:
        """Always."""
        return True

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The cap of the step; without the exact Hessian also the last step and the gradient it began with."""
        first = {"null_cap": np.full(1, self.step_limit)}
        if self.curvature == "gauss_newton":
            first |= {"null_step": np.zeros(shape.n), "lagrangian_gradient": np.zeros(shape.n)}
        return first

    def propose(self, model: LocalModel, state: State, task_dq: Expression) -> NullSpaceDisplacement:
        """The solution of the quadratic program, and the stationarity residual of H."""
        free, rows, split, gradient = _optimality(model)
        exact = self.curvature == "exact"
        W = _hessian(model, -split.multipliers if exact else None, exact=exact)
        W = if_else(is_finite(W), W, 0)  # as the gradient where H is not differentiable
        if self.curvature == "gauss_newton":
            W = _hessian_scale(W, state["null_step"], gradient - state["lagrangian_gradient"]) * W
        basis, moved = rows.unit_basis, rows.least_squares(model.J @ task_dq).vector
        loops = model.robot.n > UNROLLED
        reduced, largest, change = looped(_reduced, W, basis, free, moved, when=loops)
        if exact and model.least_squares is not None:
            definite = looped(_made_convex, reduced, largest + TINY, basis, free, when=loops)[1]
            gauss_newton = _hessian(model, None, exact=False)
            W = if_else(definite, W, if_else(is_finite(gauss_newton), gauss_newton, 0))
            reduced, largest, change = looped(_reduced, W, basis, free, moved, when=loops)
        after_task = gradient + change
        size = fmax(largest, norm_inf(after_task) / self.step_limit) + TINY
        hessian, definite, lowest = looped(_made_convex, reduced, size, basis, free, when=loops)

        cap = state["null_cap"]
        low, high = model.box
        share = model.null_space_share  # the whole step may leave the box where the share that is taken does not
        whole = fmax(share, SMALLEST_SHARE) if is_symbolic(share) else share
        lower, upper = fmax((low - task_dq) / whole, -cap), fmin((high - task_dq) / whole, cap)
        moving = _moving(model)
        task = RowSpace(_masked(model.J, moving)) if model.bounded else model.row_space_free
        fixed = Rows.in_null_space("task", task)
        # solvers have absolute tolerances: data and solution are scaled to order 1. A step much longer than the cap
        # follows the negative gradient, as one of infinite curvature does
        scaled, wanted = (moving * each / size for each in (after_task, _without_outward(model, after_task)))
        gradient_size = norm_inf(wanted)
        unit, stretch = fmin(cap, gradient_size) + TINY, fmax(1, ratio(gradient_size, cap))
        is_significant = significant(norm(wanted), fmax(norm(scaled), norm(model.gradient) / size))
        q = is_significant * fmax(fmin(ratio(scaled, gradient_size), LARGEST_ENTRY), -LARGEST_ENTRY)
        P = (hessian + (stretch - 1) * identity(model.robot.n)) / stretch
        qp = QuadraticProgram(P, q, lower / unit, upper / unit, [fixed], "null-space step", known_convex=True)
        solution = model.solve(qp)
        x = moving * fmin(fmax(unit * solution.x, lower), upper)
        longest = ratio(cap, norm(x))
        x = if_else(norm(solution.x) > SHORTEST, if_else(lowest < -NEGATIVE, longest, fmin(1, longest)), 0) * x
        x = share * in_null_space(task.unit_basis, x, task_dq) * x  # as long as it is taken
        residual = model.joint_gradient_norm(_without_outward(model, gradient))
        return NullSpaceDisplacement(
            dq=x,
            decrease=-dot(gradient, x),
            stationarity_residual=residual,
            figures={"null_residual": residual, "positive_definite": definite},
        )

    def correct(self, model: LocalModel, dq: Expression) -> Expression:
        """Near the target the step with its second-order corrections, -J+ times the task error that it would leave."""
        if not self.corrections:
            return dq
        wanted = model.here.residual + model.J @ dq
        candidate, corrected = model.candidate(dq), dq
        rows = RowSpace(_masked(model.J, _free(model, candidate.q))) if model.bounded else model.row_space_free
        for k in range(self.corrections):
            error = (candidate if k == 0 else model.candidate(corrected)).residual - wanted
            corrected = model.within_limits(corrected - rows.least_squares(error).vector)
        small = logic_and(model.near_target, norm(corrected - dq) <= SHORT * norm(dq))
        return if_else(small, corrected, dq)

    def adapt(self, model: LocalModel, state: State, null_space: NullSpaceDisplacement, outcome: Outcome) -> State:
        """The cap: four times after an acceptance, a quarter of the step after a refusal for its length."""
        cap, tried = state["null_cap"], ratio(outcome.null_space.length, model.null_space_share)
        shorter = if_else(outcome.shorten_null_space, fmin(tried, cap) / 4, cap)
        after = {"null_cap": if_else(outcome.accepted, fmin(4 * cap, self.step_limit), shorter)}
        if self.curvature == "gauss_newton":
            after["null_step"] = if_else(outcome.accepted, outcome.null_space.dq, state["null_step"])
            gradient, before = _optimality(model)[3], state["lagrangian_gradient"]
            after["lagrangian_gradient"] = if_else(outcome.accepted, gradient, before)
        return after


def _optimality(model: LocalModel) -> tuple[Expression, RowSpace, Split, Expression]:
    """Joints not at a limit, the row space of their Jacobian, their gradient in it, and that of the Lagrangian."""
    free = _free(model, model.here.q)
    rows = RowSpace(_masked(model.J, free)) if model.bounded else model.row_space_free
    split = rows.split(free * model.gradient)
    at_limit = model.gradient - model.J.T @ split.multipliers
    return free, rows, split, if_else(free, split.null, at_limit)


def _hessian(model: LocalModel, multipliers: Expression | None, *, exact: bool) -> Expression:
    """The Hessian of the Lagrangian; without multipliers that of H, by Gauss-Newton for criteria in residual form."""
    second = lagrangian_hessian(
        model.robot,
        model.criterion_function,
        model.residual_function,
        q=model.here.q,
        target=model.target,
        parameters=model.parameters,
        multipliers=multipliers,
        least_squares=None if exact else model.least_squares,
    )
    return model.coordinates.hessian(second)


def _reduced(
    W: Expression, basis: Expression, free: Expression, moved: Expression
) -> tuple[Expression, Expression, Expression]:
    """N W N (n, n), its largest entry, and N W t (n, 1), N being the projector diag(free) - basis' basis.

    Args:
        W: the Hessian (n, n).
        basis: orthonormal rows of the row space, zero for joints at a limit (m, n).
        free: 1 for each joint that is not at a limit, else 0 (n, 1).
        moved: t (n, 1).
    """
    rows, n = basis.shape
    if 2 * rows < n:  # then products with the basis are fewer than those with N
        once = diag(free) @ W - basis.T @ (basis @ W)
        reduced, change = once @ diag(free) - (once @ basis.T) @ basis, once @ moved
    else:
        onto_null = diag(free) - basis.T @ basis
        reduced, change = onto_null @ W @ onto_null, onto_null @ (W @ moved)
    return reduced, norm_inf(vec(reduced)), change


def _made_convex(
    reduced: Expression, size: Expression, basis: Expression, free: Expression
) -> tuple[Expression, Expression, Expression]:
    """N W N / size + I - N, convexified (n, n), and the other results of `convexified`; N as in `_reduced`."""
    onto_null = diag(free) - basis.T @ basis
    return convexified(reduced / size + (np.eye(free.shape[0]) - onto_null))


def _hessian_scale(W: Expression, step: Expression, change: Expression) -> Expression:
    """How much more the gradient changed along the last step than W predicts, at least 1, to prevent overshoot."""
    predicted = dot(step, W @ step)
    return if_else(predicted > 0, fmin(fmax(ratio(dot(step, change), fmax(predicted, 0)), 1), LARGEST_SCALE), 1)


def _free(model: LocalModel, q: Expression) -> Expression:
    """1 for each velocity entry that is not at a limit, else 0, (n, 1)."""
    entries: list[Expression] = [1] * model.robot.n
    for i, j in model.bounded:
        entries[j] = logic_and(q[i] < model.upper[i] - AT_LIMIT, q[i] > model.lower[i] + AT_LIMIT)
    return vertcat(*entries)


def _moving(model: LocalModel) -> Expression:
    """0 for the joints that the task pushes outward at a limit on the way to the target, else 1, (n, 1)."""
    entries: list[Expression] = [1] * model.robot.n
    for _, j in model.bounded:
        outward = logic_and(sumsqr(model.J_free[:, j]) == 0, sumsqr(model.J[:, j]) > 0)
        entries[j] = logic_or(model.near_target, logic_not(outward))
    return vertcat(*entries)


def _masked(J: Expression, free: Expression) -> Expression:
    """J with zeros in the columns of the joints at a limit."""
    return horzcat(*[J[:, j] * free[j] for j in range(J.shape[1])])


def _without_outward(model: LocalModel, gradient: Expression) -> Expression:
    """The gradient (n, 1) with zeros for the joints that its negative pushes outward at a limit."""
    q = model.here.q
    entries = [gradient[j] for j in range(model.robot.n)]
    for i, j in model.bounded:
        entries[j] = if_else(q[i] >= model.upper[i] - AT_LIMIT, fmax(entries[j], 0), entries[j])
        entries[j] = if_else(q[i] <= model.lower[i] + AT_LIMIT, fmin(entries[j], 0), entries[j])
    return vertcat(*entries)

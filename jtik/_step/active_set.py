"""Joint limits inside the fused step: which joints a limit holds, so that the others go on without them.

A joint at a limit that descent presses it against is *held*: its columns of J and of the gradient are zero, and the
law works with the joints that are left. Who is held is the working set, part of the state
(formulations/joint_limits.md):

- Far from the target, or without a criterion, the task decides: held is whom -J' r presses outwards, and after a
  refused step also whom that step pushed outwards. A strategy that refuses nothing needs no memory for that.
- Near the target the working set of an active-set method is kept: a joint enters when a step pushes it outwards, and
  one joint at a time leaves, the one whose multiplier has the most wrong sign, once that is larger than the
  projected gradient.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

from jtik._step.symbolic_problem import SymbolicProblem
from jtik.strategy import LocalModel, Point, Update
from jtik.symbolic import (
    Expression,
    fmax,
    fmin,
    horzcat,
    if_else,
    logic_and,
    logic_not,
    logic_or,
    norm,
    sumsqr,
    vertcat,
)

AT_LIMIT = 1e-9
"""Distance [rad] or [m] at which a joint is at its limit."""


def inside(q: Expression, lower: Expression, upper: Expression, bounded: tuple[tuple[int, int], ...]) -> Expression:
    """q led back into the box."""
    entries = [q[i] for i in range(q.shape[0])]
    for i, _ in bounded:
        entries[i] = fmin(fmax(entries[i], lower[i]), upper[i])
    return vertcat(*entries)


class ActiveSet:
    """Who is held in this step, and who will be in the next; one entry a bounded joint, 0 or 1."""

    def __init__(
        self,
        problem: SymbolicProblem,
        state: Mapping[str, Expression],
        here: Point,
        near: Expression,
        J: Expression,
        gradient: Expression,
        lower: Expression,
        upper: Expression,
        *,
        programs: bool = False,
    ) -> None:
        self._problem, self._here, self._J, self._gradient = problem, here, J, gradient
        self._lower, self._upper = lower, upper
        # whether the working set is kept from step to step; a program finds out by itself who is held
        self._keeps = near if problem.has_criterion and not programs else 0
        self._force = J.T @ here.residual
        pairs = zip(self._at(here.q), self._outwards(self._force), strict=True)
        self._pressed = [logic_and(at, outwards) for at, outwards in pairs]
        self.held: list[Expression] = self._pressed
        if "held" in state:
            kept = [logic_and(at, state["held"][k]) for k, at in enumerate(self._at(here.q))]
            self.held = [
                if_else(self._keeps, own, logic_or(own, pressed))
                for own, pressed in zip(kept, self._pressed, strict=True)
            ]

    def masked(self, columns: Expression) -> Expression:
        """The matrix with zeros in the columns of the joints held."""
        free = dict.fromkeys(range(columns.shape[1]), 1)
        free |= {j: logic_not(held) for (_, j), held in zip(self._problem.bounded, self.held, strict=True)}
        return horzcat(*[columns[:, j] * keep for j, keep in free.items()])

    def _at(self, q: Expression) -> list[Expression]:
        """Whether each bounded joint is at one of its limits."""
        return [
            logic_or(q[i] >= self._upper[i] - AT_LIMIT, q[i] <= self._lower[i] + AT_LIMIT)
            for i, _ in self._problem.bounded
        ]

    def _outwards(self, slope: Expression, q: Expression | None = None) -> list[Expression]:
        """Whether going down ``slope`` (n, 1) takes each bounded joint away from the middle of its range."""
        q = self._here.q if q is None else q
        return [
            if_else(q[i] >= self._upper[i] - AT_LIMIT, slope[j] < 0, slope[j] > 0) for i, j in self._problem.bounded
        ]

    @cached_property
    def task_slope(self) -> Expression:
        """Norm of dV/dv over the joints that the task itself does not press against a limit."""
        pairs = zip(self._pressed, self._problem.bounded, strict=True)
        lost = sum(if_else(pressed, self._force[j] ** 2, 0) for pressed, (_, j) in pairs)
        return fmax(sumsqr(self._force) - lost, 0) ** 0.5

    def _wrong(self, model: LocalModel) -> list[Expression]:
        """For each joint held how strongly descent of H + lambda' r + 1/2 c |r|^2 would take it inwards, from 0."""
        c = (12 * norm(model.multipliers) + model.gradient_length / model.jacobian_length) / model.tube
        slope = self._gradient + self._J.T @ (c * self._here.residual - model.multipliers)
        signs = [if_else(self._here.q[i] >= self._upper[i] - AT_LIMIT, 1, -1) for i, _ in self._problem.bounded]
        return [
            if_else(held, fmax(sign * slope[j], 0), 0)
            for held, sign, (_, j) in zip(self.held, signs, self._problem.bounded, strict=True)
        ]

    def wrong(self, model: LocalModel) -> Expression:
        """The largest multiplier of wrong sign: 0 where the joints held are held rightly."""
        largest: Expression = 0
        for each in self._wrong(model):
            largest = fmax(largest, each)
        return largest

    def after(self, model: LocalModel, update: Update, accepted: Expression) -> Expression:
        """The working set the next step starts from, (bounded, 1)."""
        q = if_else(accepted, update.point.q, self._here.q)
        pushed = [logic_and(at, out) for at, out in zip(self._at(q), self._outwards(update.wanted, q), strict=True)]
        blocked = [if_else(accepted, 0, logic_or(held, push)) for held, push in zip(self.held, pushed, strict=True)]
        if not self._problem.has_criterion:
            return vertcat(*blocked)
        wrong, largest = self._wrong(model), self.wrong(model)
        leaves = largest > model.null_length
        kept = [
            logic_or(push, logic_and(held, logic_not(logic_and(leaves, each == largest))))
            for held, push, each in zip(self.held, pushed, wrong, strict=True)
        ]
        return vertcat(*[if_else(self._keeps, near, far) for near, far in zip(kept, blocked, strict=True)])

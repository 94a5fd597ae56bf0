"""The active set: which joint limits are active in a step, so that the step is made with the other joints.

A joint whose limit is *active* has zero columns in J and zero entries in the gradient, and the strategy works with the
remaining joints. The active set is part of the state (formulations/joint_limits.md):

- Far from the target, or without a criterion, the task decides: the limit of a joint at its limit that -J' r pushes
  outward is active, and after a refused step also that of a joint that the step pushed outward. The state of a
  strategy that accepts every step has no active set.
- Near the target the working set of an active-set method is kept: a joint enters when a step pushes it outward, and
  one joint at a time leaves, the one with the largest multiplier of the wrong sign, once that is larger than the
  projected gradient.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property

from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.limits import AT_LIMIT
from jtik.strategy import Evaluation, LocalModel
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


def clamped(q: Expression, lower: Expression, upper: Expression, bounded: tuple[tuple[int, int], ...]) -> Expression:
    """q clamped to the limits."""
    entries = [q[i] for i in range(q.shape[0])]
    for i, _ in bounded:
        entries[i] = fmin(fmax(entries[i], lower[i]), upper[i])
    return vertcat(*entries)


class ActiveSet:
    """Which limits are active in this step, and in the next; one entry for each bounded joint, 0 or 1.

    Args:
        problem: the problem.
        state: state of the step; "active" is the active set of the step before.
        here: task and criterion at q.
        near_target: 1 in the neighbourhood of the target.
        J: Jacobian of the residual of all joints (m, n).
        gradient: dH/dv of all joints (n, 1).
        limits: lower and upper limits of q.
        uses_qp: whether the strategy's quadratic programs find the active limits by themselves.
        moving: whether the limits move from step to step: a joint may be at the other limit than in the step before.

    Attributes:
        active: 1 for each bounded joint whose limit is active in this step, else 0.
    """

    def __init__(
        self,
        problem: SymbolicProblem,
        state: Mapping[str, Expression],
        here: Evaluation,
        near_target: Expression,
        J: Expression,
        gradient: Expression,
        limits: tuple[Expression, Expression],
        *,
        uses_qp: bool = False,
        moving: bool = False,
    ) -> None:
        self._problem, self._here, self._J, self._gradient = problem, here, J, gradient
        self._lower, self._upper = limits
        self._moving = moving
        # whether the active set is kept from step to step
        self._kept = near_target if problem.has_criterion and not uses_qp else 0
        self._task_gradient = J.T @ here.residual
        pairs = zip(self._at_limit(here.q), self._outward(-self._task_gradient), strict=True)
        self._pushed = [logic_and(at, outward) for at, outward in pairs]
        self.active: list[Expression] = self._pushed
        if "active" in state:
            before = self._still_at_limit(here.q, state["active"])
            self.active = [
                if_else(self._kept, active, logic_or(active, pushed))
                for active, pushed in zip(before, self._pushed, strict=True)
            ]

    def masked(self, columns: Expression) -> Expression:
        """The matrix with zeros in the columns of the joints whose limit is active."""
        free = dict.fromkeys(range(columns.shape[1]), 1)
        free |= {j: logic_not(active) for (_, j), active in zip(self._problem.bounded, self.active, strict=True)}
        return horzcat(*[columns[:, j] * keep for j, keep in free.items()])

    def _at_limit(self, q: Expression) -> list[Expression]:
        """Whether each bounded joint is at one of its limits."""
        return [logic_or(upper, lower) for upper, lower in self._sides_at(q)]

    def _sides_at(self, q: Expression) -> list[tuple[Expression, Expression]]:
        """Whether each bounded joint is at its upper limit, and whether at its lower one."""
        return [
            (q[i] >= self._upper[i] - AT_LIMIT, q[i] <= self._lower[i] + AT_LIMIT) for i, _ in self._problem.bounded
        ]

    def _still_at_limit(self, q: Expression, before: Expression) -> list[Expression]:
        """Whether each bounded joint is at the limit that was active before, on the same side."""
        sides = enumerate(self._sides_at(q))
        if not self._moving:
            return [logic_and(logic_or(upper, lower), before[k]) for k, (upper, lower) in sides]
        return [before[k] * (upper - lower) > 0 for k, (upper, lower) in sides]

    def _noted(self, active: Sequence[Expression], q: Expression) -> Expression:
        """The state of the active set at ``q``, (bounded, 1); of moving limits 1 at an upper and -1 at a lower one."""
        if not self._moving:
            return vertcat(*active)
        return vertcat(*[each * (2 * upper - 1) for each, (upper, _) in zip(active, self._sides_at(q), strict=True)])

    def _outward(self, dq: Expression, q: Expression | None = None) -> list[Expression]:
        """Whether ``dq`` (n, 1) moves each bounded joint, which is at a limit, beyond it."""
        q = self._here.q if q is None else q
        return [if_else(q[i] >= self._upper[i] - AT_LIMIT, dq[j] > 0, dq[j] < 0) for i, j in self._problem.bounded]

    @cached_property
    def task_gradient_norm(self) -> Expression:
        """Norm of dV/dv over the joints that the task itself does not push outward at a limit."""
        return fmax(sumsqr(self._task_gradient) - self._squared_outward, 0) ** 0.5

    @property
    def limits_task(self) -> Expression:
        """1 where the task itself pushes a joint outward at a limit, else 0."""
        return self._squared_outward > 0

    @cached_property
    def _squared_outward(self) -> Expression:
        """Squared norm of the part of dV/dv that `task_gradient_norm` leaves out."""
        pairs = zip(self._pushed, self._problem.bounded, strict=True)
        return sum(if_else(pushed, self._task_gradient[j] ** 2, 0) for pushed, (_, j) in pairs)

    @cached_property
    def _sides(self) -> list[Expression]:
        """For each bounded joint 1 where its upper limit is active, -1 where its lower limit is, else 0."""
        pairs = zip(self.active, self._sides_at(self._here.q), strict=True)
        return [active * (2 * upper - 1) for active, (upper, _) in pairs]

    def _wrong_multipliers(self, model: LocalModel, gradient: Expression) -> list[Expression]:
        """For each active limit by how much its multiplier has the wrong sign, non-negative.

        It is the inward part of the negative ``gradient`` (n, 1), that of a Lagrangian.
        """
        gradient = model.coordinates.gradient_by_joints(gradient)
        pairs = zip(self._sides, self._problem.bounded, strict=True)
        return [fmax(side * gradient[j], 0) for side, (_, j) in pairs]

    def _lagrangian_gradient(self, model: LocalModel) -> Expression:
        """Gradient of H + lambda' r over all joints, with the multipliers of the free joints, (n, 1)."""
        return self._gradient - self._J.T @ model.multipliers

    def stationarity_residual(self, model: LocalModel) -> Expression:
        """Norm of h and of all multipliers of the wrong sign: 0 where the first-order conditions of H hold.

        No multipliers make it smaller than that of `jtik.result.reduced_gradient`, which is the smallest.
        """
        wrong = self._wrong_multipliers(model, self._lagrangian_gradient(model))
        return norm(vertcat(model.stationarity_residual, *wrong))

    def after(self, model: LocalModel, wanted: Expression, arrived: Expression, accepted: Expression) -> Expression:
        """The active set the next step starts from, (bounded, 1).

        Args:
            model: the local model.
            wanted: displacement before limits shortened it (n, 1).
            arrived: configuration of the candidate (nq, 1).
            accepted: whether the step is taken.
        """
        q = if_else(accepted, arrived, self._here.q)
        pushed = [logic_and(at, out) for at, out in zip(self._at_limit(q), self._outward(wanted, q), strict=True)]
        blocked = [if_else(accepted, 0, logic_or(own, out)) for own, out in zip(self.active, pushed, strict=True)]
        if not self._problem.has_criterion:
            return self._noted(blocked, q)
        # off the target the task decides, by the penalty term 1/2 c |r|^2
        c = (12 * norm(model.multipliers) + model.gradient_norm / model.jacobian_norm) / model.neighbourhood
        wrong = self._wrong_multipliers(model, self._lagrangian_gradient(model) + c * self._task_gradient)
        largest: Expression = 0
        for each in wrong:
            largest = fmax(largest, each)
        leaves = largest > model.stationarity_residual
        kept = [
            logic_or(push, logic_and(own, logic_not(logic_and(leaves, each == largest))))
            for own, push, each in zip(self.active, pushed, wrong, strict=True)
        ]
        pairs = zip(kept, blocked, strict=True)
        return self._noted([if_else(self._kept, inside, outside) for inside, outside in pairs], q)

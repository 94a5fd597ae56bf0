"""Feasibility restoration: distances that are too small are restored first (formulations/clearance.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf

from jtik.constraints.clearance import ClearanceModel
from jtik.qp.quadratic_program import QPSolution, QuadraticProgram, Rows
from jtik.qp.recorder import QPRecorder
from jtik.symbolic import (
    TINY,
    Expression,
    dot,
    fabs,
    fmax,
    fmin,
    identity,
    if_else,
    is_finite,
    logic_and,
    logic_or,
    mmax,
    mmin,
    norm,
    sumsqr,
    zeros,
)

LONGEST = 0.3
"""Largest motion of each velocity entry in a restoration step [rad] or [m]; refused steps reduce it."""

TASK_WEIGHT = 1e2
"""Weight of a motion that changes the task, relative to one of the same length that does not."""

PENALTY = 1e5
"""Penalty weight of a demand that is not met, for a row of the largest possible length; shorter rows weigh less."""

SIGNIFICANT = 1e-6
"""Distance [m] below which a demand, or what a step gains, is solver tolerance."""

SUFFICIENT = 0.1
"""Share of the promised gain that a step must keep to be accepted for the restoration."""

MET = 0.9
"""A demand of which a smaller share is met counts as relaxed."""


@dataclass(frozen=True)
class FeasibilityRestoration:
    """The step that restores distances that are too small, and the rows that it leaves for the step's QPs.

    Attributes:
        dq: displacement that restores them (n, 1); zero where none is too small.
        gained: C dq, its increase of each distance to first order (k, 1) [m].
        clearance: the clearances at q.
        jacobian: Jacobian of the residual of the task (m, n).
        length: norm of the residual.
        record: smallest violation so far [m].
    """

    dq: Expression
    gained: Expression
    clearance: ClearanceModel
    jacobian: Expression
    length: Expression
    record: Expression

    @cached_property
    def rows(self) -> Rows:
        """Rows for a displacement; ``dq`` satisfies them all, and so does 0 where nothing can be gained."""
        low = self.clearance.low
        if self.clearance.restores:
            low = fmin(low, self.gained)
        return Rows("clearance", self.clearance.jacobian, low, inf + 0 * low)

    def within(self, lower: Expression, upper: Expression) -> FeasibilityRestoration:
        """The same with the displacement shortened into a box that contains 0."""
        if not self.clearance.restores:
            return self
        share: Expression = 1
        for j in range(self.dq.shape[0]):
            size = fabs(self.dq[j]) + TINY
            share = fmin(share, if_else(self.dq[j] < 0, -lower[j], upper[j]) / size)
        return replace(self, dq=share * self.dq, gained=share * self.gained)

    @cached_property
    def _met(self) -> Expression:
        """How much of each demand is met [m]."""
        return fmax(fmin(self.gained, self.clearance.demand), 0)

    def _violation(self, dq: Expression) -> Expression:
        """The violation after the displacement dq [m]."""
        return self.clearance.violation(self.clearance.after(dq))

    def accepts(self, dq: Expression, length: Expression) -> Expression:
        """1 where the displacement dq is accepted for what it restores, whatever it does to the criterion.

        It must keep a share of the promised gain, reduce the smallest violation so far, and may not increase the
        residual by more than the restoration explains.

        Args:
            dq: displacement (n, 1).
            length: norm of the residual after it.
        """
        if not self.clearance.restores:
            return 0
        promised = mmax(self._met)
        made = self.record - self._violation(dq)
        first_order = norm(self.jacobian @ self.dq)
        second_order = norm(self.jacobian.reshape((-1, 1))) * sumsqr(self.dq)
        explained = length <= self.length + 2 * first_order + second_order
        return logic_and(logic_and(promised > SIGNIFICANT, made >= SUFFICIENT * promised), explained)

    def after(self, dq: Expression, accepted: Expression) -> dict[str, Expression]:
        """The state for the next step: how far a restoration step may go, and the smallest violation.

        Where a distance was not safe on the whole way, the longer part of the step is shortened.
        """
        longest = self.clearance.longest
        reached = fmin(self.record, self._violation(dq))
        shorten = logic_or(self.clearance.keeps(dq), 4 * sumsqr(self.dq) >= sumsqr(dq))
        return {
            "longest": if_else(accepted, fmin(2 * longest, LONGEST), if_else(shorten, longest / 4, longest)),
            "violation": if_else(accepted, reached, self.record),
        }

    @cached_property
    def pending(self) -> Expression:
        """1 where a distance below safe can still be increased."""
        violated = self.clearance.distance < self.clearance.safe
        return mmax(if_else(violated, self.gained, 0)) > SIGNIFICANT

    @cached_property
    def missing(self) -> Expression:
        """By how much each distance stays below its aim where it cannot be restored, (k, 1) [m]; else 0."""
        demand = self.clearance.demand
        relaxed = logic_and(self._met < MET * demand, demand > 10 * SIGNIFICANT)
        return if_else(relaxed, self.clearance.aim - self.clearance.distance, 0)


def feasibility_restoration(
    clearance: ClearanceModel,
    qps: QPRecorder,
    box: tuple[Expression, Expression],
    task_rows: Callable[[], Expression],
    jacobian: Expression,
    length: Expression,
) -> FeasibilityRestoration:
    """The shortest displacement that meets the demands of the distances that are too small, as far as possible.

    Args:
        clearance: distances and what is demanded of them.
        qps: takes the quadratic program, which is solved only where there is a demand.
        box: lower and upper bounds of dq, (n, 1) each, with 0 between them.
        task_rows: returns orthonormal rows of the directions that change the task.
        jacobian: Jacobian of the residual (m, n).
        length: norm of the residual.
    """
    n = jacobian.shape[1]
    if not clearance.restores:
        none = zeros(n), zeros(clearance.distance.shape[0])
        return FeasibilityRestoration(*none, clearance, jacobian, length, 0)
    C, K, demand = clearance.jacobian, task_rows(), clearance.demand
    lower, upper = fmax(box[0], -clearance.longest), fmin(box[1], clearance.longest)
    penalty = PENALTY * (1 + TASK_WEIGHT) / clearance.lever**2
    floor = clearance.low - demand
    program = QuadraticProgram(
        P=identity(n) + TASK_WEIGHT * K.T @ K + penalty * _gram(if_else(demand > 0, 1, 0), C),
        q=-penalty * C.T @ demand,
        lower=lower,
        upper=upper,
        rows=[Rows("clearance", C, floor, inf + 0 * floor)],
        name="restoration",
    )

    def results(answer: QPSolution) -> list[Expression]:
        dq = fmin(fmax(answer.x, lower), upper)  # rounding must not leave the box
        gained = C @ dq
        # of the solution only this must hold: no distance becomes smaller than it may; else nothing is restored
        feasible = logic_and(is_finite(answer.x), mmin(gained - floor) >= -qps.accuracy)
        return [if_else(feasible, dq, 0), if_else(feasible, gained, 0)]

    dq, gained = qps.prepare(mmax(demand) > SIGNIFICANT, program, results)
    record = fmin(clearance.record, clearance.violation(clearance.distance))
    return FeasibilityRestoration(dq, gained, clearance, jacobian, length, record)


def _gram(weights: Expression, matrix: Expression) -> Expression:
    """matrix' diag(weights) matrix, (n, n), each entry computed once."""
    n, weighted = matrix.shape[1], [weights * matrix[:, j] for j in range(matrix.shape[1])]
    product = zeros(n, n)
    for i in range(n):
        for j in range(i, n):
            product[i, j] = product[j, i] = dot(weighted[i], matrix[:, j])
    return product

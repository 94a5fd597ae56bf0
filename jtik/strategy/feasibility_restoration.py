"""Feasibility restoration: a step that first increases distances that are too small (formulations/clearance.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf

from jtik.constraints.clearance import LONGEST, ClearanceModel
from jtik.qp.quadratic_program import QPSolution, QuadraticProgram, Rows
from jtik.qp.recorder import QPRecorder
from jtik.symbolic import (
    TINY,
    Expression,
    fabs,
    fmax,
    fmin,
    gram,
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
from jtik.symbolic.row_sums import weighted_sums

TASK_WEIGHT = 1e2
"""Weight of a motion that changes the task, relative to one of the same length that does not."""

PENALTY = 1e5
"""Penalty weight of a demand that is not met, for a row of the largest possible length; shorter rows weigh less."""

SIGNIFICANT = 1e-6
"""Distance [m] below which a demanded or an achieved increase is within the tolerance of the QP solver."""

SLACK = 1e-7
"""What the rows of demands that cannot be met concede [m], so that more than one displacement satisfies all rows.

A solver may find no solution, within its tolerance, where there is only one.
"""

SUFFICIENT = 0.1
"""Share of the predicted increase that a step must achieve to be accepted for the restoration."""

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
        smallest_violation: smallest violation so far [m].
    """

    dq: Expression
    gained: Expression
    clearance: ClearanceModel
    jacobian: Expression
    length: Expression
    smallest_violation: Expression

    @cached_property
    def rows(self) -> Rows:
        """Rows for a displacement. ``dq`` satisfies all of them, and so does 0 where no distance can be increased."""
        low = self.clearance.low
        if self.clearance.restores:
            low = fmin(low, self.gained - SLACK * (self.gained < low))
        return Rows("clearance", self.clearance.jacobian, low, inf + 0 * low)

    def within(self, lower: Expression, upper: Expression) -> FeasibilityRestoration:
        """The same with the displacement shortened into a box that contains 0.

        Args:
            lower: lower bounds of the displacement (n, 1), at most 0.
            upper: upper bounds of the displacement (n, 1), at least 0.
        """
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

    def accepts(self, dq: Expression, length: Expression) -> Expression:
        """1 where the displacement dq is accepted for the restoration, without regard to the criterion.

        It must achieve a share of the predicted increase, reduce the smallest violation so far, and not increase the
        residual by more than the restoration does.

        Args:
            dq: displacement (n, 1).
            length: norm of the residual after it.
        """
        if not self.clearance.restores:
            return 0
        predicted = mmax(self._met)
        achieved = self.smallest_violation - self.clearance.violation_after(dq)
        first_order = norm(self.jacobian @ self.dq)
        second_order = norm(self.jacobian.reshape((-1, 1))) * sumsqr(self.dq)
        explained = length <= self.length + 2 * first_order + second_order
        return logic_and(logic_and(predicted > SIGNIFICANT, achieved >= SUFFICIENT * predicted), explained)

    def after(self, dq: Expression, accepted: Expression) -> dict[str, Expression]:
        """The state of the next step: the largest motion in a restoration step, and the smallest violation.

        Where the path of the step was not safe, only the longer part of the step is shortened.

        Args:
            dq: the displacement of the step (n, 1).
            accepted: 1 if the step is taken, else 0.
        """
        longest = self.clearance.longest
        reached = fmin(self.smallest_violation, self.clearance.violation_after(dq))
        longer = logic_or(self.clearance.keeps(dq), 4 * sumsqr(self.dq) >= sumsqr(dq))
        shorten = logic_and(sumsqr(self.dq) > 0, longer)
        return {
            "longest": if_else(accepted, fmin(2 * longest, LONGEST), if_else(shorten, longest / 4, longest)),
            "violation": if_else(accepted, reached, self.smallest_violation),
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
        qps: records the quadratic program, which is solved only where there is a demand.
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
    penalty = PENALTY * (1 + TASK_WEIGHT) / clearance.motion.row_norm_bound**2
    floor = clearance.low - demand
    rows = Rows("clearance", C, floor, inf + 0 * floor)
    demanded, wanted = weighted_sums(C, if_else(demand > 0, 1, 0), demand)
    qp = QuadraticProgram(
        P=identity(n) + TASK_WEIGHT * gram(K) + penalty * demanded,
        q=-penalty * wanted,
        lower=lower,
        upper=upper,
        rows=[rows],
        name="restoration",
        known_convex=True,
    )

    def results(solution: QPSolution) -> list[Expression]:
        dq = fmin(fmax(solution.x, lower), upper)  # rounding must not leave the box
        gained = rows.product(dq)
        # the only check of the solution: if a distance becomes smaller than allowed, nothing is restored
        feasible = logic_and(is_finite(solution.x), mmin(gained - floor) >= -qps.accuracy)
        return [if_else(feasible, dq, 0), if_else(feasible, gained, 0)]

    dq, gained = qps.prepare(mmax(demand) > SIGNIFICANT, qp, results)
    smallest_violation = fmin(clearance.smallest_violation, clearance.violation)
    return FeasibilityRestoration(dq, gained, clearance, jacobian, length, smallest_violation)

"""Making room: what starts nearer than it should is moved out, before anything else (formulations/clearance.md)."""

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
"""Most that each velocity entry moves in a step to make room [rad] or [m]; refused steps bring it down."""

ASIDE = 1e2
"""Price of a motion that the task feels, beside one of the same length that it does not."""

TIGHT = 1e5
"""How much dearer still it is to miss a demand, for a row as long as a row can be: shorter ones are missed by more."""

WORTH = 1e-6
"""Distance [m] that is worth a demand, a step for its sake, or to go on for: less is what solvers leave."""

ENOUGH = 0.1
"""Share of what making room promises that a step must keep to be taken for its sake."""

MISSED = 0.9
"""A demand of which a smaller share is met has given way."""


@dataclass(frozen=True)
class Recovery:
    """How far the bodies that are too near can be moved out, and the rows that this leaves for the step's programs.

    Attributes: step x (n, 1) that moves them out, zero where none is too near; gained, C x, what that gains of each
    distance to first order (k, 1) [m]; clearance; jacobian and length of the residual; record, the least violation so
    far [m].
    """

    step: Expression
    gained: Expression
    clearance: ClearanceModel
    jacobian: Expression
    length: Expression
    record: Expression

    @cached_property
    def rows(self) -> Rows:
        """Rows for a displacement; ``step`` satisfies them all, and so does 0 where nothing can be gained."""
        low = self.clearance.low
        if self.clearance.recovers:
            low = fmin(low, self.gained)
        return Rows("clearance", self.clearance.jacobian, low, inf + 0 * low)

    def within(self, lower: Expression, upper: Expression) -> Recovery:
        """The same with the step shortened into a box that contains 0."""
        if not self.clearance.recovers:
            return self
        share: Expression = 1
        for j in range(self.step.shape[0]):
            size = fabs(self.step[j]) + TINY
            share = fmin(share, if_else(self.step[j] < 0, -lower[j], upper[j]) / size)
        return replace(self, step=share * self.step, gained=share * self.gained)

    @cached_property
    def _met(self) -> Expression:
        """How much of each demand is met [m]."""
        return fmax(fmin(self.gained, self.clearance.demand), 0)

    def _left(self, term: Expression) -> Expression:
        """The violation after the step -term [m]."""
        return self.clearance.violation(self.clearance.elsewhere(term))

    def takes(self, term: Expression, length: Expression) -> Expression:
        """1 where the step -term is worth being taken for the room it makes, whatever it does to the criterion.

        It must keep what making room promised, undercut the record, and may leave the residual no longer (``length``)
        than making room does.
        """
        if not self.clearance.recovers:
            return 0
        promised = mmax(self._met)
        made = self.record - self._left(term)
        away = norm(self.jacobian @ self.step)
        bent = norm(self.jacobian.reshape((-1, 1))) * sumsqr(self.step)
        explained = length <= self.length + 2 * away + bent
        return logic_and(logic_and(promised > WORTH, made >= ENOUGH * promised), explained)

    def after(self, term: Expression, accepted: Expression) -> dict[str, Expression]:
        """What the next step has to know: how far it may go to make room, and the record.

        A way that was not clear is the fault of the longer part, and the rest of the step gets shorter by itself.
        """
        longest = self.clearance.longest
        reached = fmin(self.record, self._left(term))
        blamed = logic_or(self.clearance.keeps(term), 4 * sumsqr(self.step) >= sumsqr(term))
        return {
            "longest": if_else(accepted, fmin(2 * longest, LONGEST), if_else(blamed, longest / 4, longest)),
            "violation": if_else(accepted, reached, self.record),
        }

    @cached_property
    def pending(self) -> Expression:
        """1 where a body nearer than safe can still be moved out."""
        inside = self.clearance.distance < self.clearance.safe
        return mmax(if_else(inside, self.gained, 0)) > WORTH

    @cached_property
    def missing(self) -> Expression:
        """By how much each distance stays below its aim, where it cannot be moved out, (k, 1) [m]; else 0."""
        demand = self.clearance.demand
        missed = logic_and(self._met < MISSED * demand, demand > 10 * WORTH)
        return if_else(missed, self.clearance.aim - self.clearance.distance, 0)


def recovery(
    clearance: ClearanceModel,
    programs: QPRecorder,
    box: tuple[Expression, Expression],
    task_rows: Callable[[], Expression],
    jacobian: Expression,
    length: Expression,
) -> Recovery:
    """The shortest x that meets the demands of the bodies that are too near, as far as that can be.

    Args:
        clearance: distances and what is asked of them.
        programs: takes the program, which is solved where there is a demand.
        box: lower and upper bounds of x, (n, 1) each, with 0 between them.
        task_rows: orthonormal rows of the directions that the task feels.
        jacobian, length: of the residual.
    """
    n = jacobian.shape[1]
    if not clearance.recovers:
        return Recovery(zeros(n), zeros(clearance.distance.shape[0]), clearance, jacobian, length, 0)
    C, K, demand = clearance.jacobian, task_rows(), clearance.demand
    lower, upper = fmax(box[0], -clearance.longest), fmin(box[1], clearance.longest)
    price = TIGHT * (1 + ASIDE) / clearance.lever**2
    floor = clearance.low - demand
    program = QuadraticProgram(
        P=identity(n) + ASIDE * K.T @ K + price * _gram(if_else(demand > 0, 1, 0), C),
        q=-price * C.T @ demand,
        lower=lower,
        upper=upper,
        rows=[Rows("clearance", C, floor, inf + 0 * floor)],
        name="recovery",
    )

    def results(answer: QPSolution) -> list[Expression]:
        step = fmin(fmax(answer.x, lower), upper)  # rounding must not leave the box
        gained = C @ step
        # all that must be right of the answer is that nothing comes nearer than it may; else no room is made
        right = logic_and(is_finite(answer.x), mmin(gained - floor) >= -programs.accuracy)
        return [if_else(right, step, 0), if_else(right, gained, 0)]

    step, gained = programs.prepare(mmax(demand) > WORTH, program, results)
    record = fmin(clearance.record, clearance.violation(clearance.distance))
    return Recovery(step, gained, clearance, jacobian, length, record)


def _gram(weights: Expression, matrix: Expression) -> Expression:
    """matrix' diag(weights) matrix, (n, n), each entry computed once."""
    n, weighted = matrix.shape[1], [weights * matrix[:, j] for j in range(matrix.shape[1])]
    product = zeros(n, n)
    for i in range(n):
        for j in range(i, n):
            product[i, j] = product[j, i] = dot(weighted[i], matrix[:, j])
    return product

"""The solution of a quadratic program as symbols, and the check of its optimality conditions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from jtik.errors import ArgumentError
from jtik.qp.elastic import multiplier_error
from jtik.result.deprecated import RenamedAttribute
from jtik.symbolic import Expression, fmax, is_finite, logic_and, mmax, norm_inf, vertcat

if TYPE_CHECKING:
    from jtik.qp.quadratic_program import QuadraticProgram


@dataclass(frozen=True)
class QPSolution:
    """The solution of a QP, as expressions: ``P x + q + C' row_multipliers + box_multipliers = 0``.

    Attributes:
        x: minimiser (n, 1).
        row_multipliers: multipliers of all rows (k, 1), positive where an upper bound is active.
        box_multipliers: multipliers of the box (n, 1), positive where an upper bound is active.
        qp: the QP.
    """

    x: Expression
    row_multipliers: Expression
    box_multipliers: Expression
    qp: QuadraticProgram
    program = RenamedAttribute("qp")

    def multipliers(self, name: str) -> Expression:
        """Multipliers of one group of rows, (k, 1).

        Args:
            name: name of the group.

        Raises:
            ArgumentError: if there is no group of that name.
        """
        return self.row_multipliers[self.qp.rows_of(name)[1]]

    def slack(self, name: str) -> Expression:
        """How far each row of an elastic group is relaxed, (k, 1), non-negative.

        Args:
            name: name of the group.

        Raises:
            ArgumentError: if there is no elastic group of that name.
        """
        group, _ = self.qp.rows_of(name)
        if group.elastic is None:
            elastic = [each.name for each in self.qp.rows if each.elastic]
            raise ArgumentError("name", name, f"an elastic group of rows, one of {elastic}")
        used = group.product(self.x)
        return fmax(fmax(group.lower - used, used - group.upper), 0)

    @cached_property
    def violation(self) -> Expression:
        """Largest violation of a row, beyond its largest slack, or of the box."""
        _, _, C, low, high, lower, upper = self.qp.data()
        worst = fmax(mmax(lower - self.x), mmax(self.x - upper))
        if self.qp.row_count:
            Cx = C @ self.x
            below, above = low - Cx, Cx - high
            if self.qp.expansion:
                rows, max_slack = list(self.qp.expansion.elastic), self.qp.penalties[2]
                below[rows] -= max_slack
                above[rows] -= max_slack
            worst = fmax(worst, fmax(mmax(below), mmax(above)))
        return fmax(worst, 0)

    @cached_property
    def stationarity(self) -> Expression:
        """Stationarity residual: the largest entry of P x + q + C' row_multipliers + box_multipliers."""
        P, q, C = self.qp.data()[:3]
        return norm_inf(P @ self.x + q + (self.row_multipliers.T @ C).T + self.box_multipliers)

    def solved(self, accuracy: float) -> Expression:
        """1 where the solution is valid, else 0.

        Violation, and stationarity relative to 1 + |q|, are at most ``accuracy``; P is convex; nothing is NaN.

        Args:
            accuracy: largest violation and stationarity residual of a valid solution.
        """
        scale = 1 + norm_inf(self.qp.q)
        good = logic_and(self.violation <= accuracy, self.stationarity <= accuracy * scale)
        good = logic_and(good, self.qp.convex)
        if not self.qp.has_many_rows:  # otherwise that is checked before a solver is called
            good = logic_and(good, self.qp.valid)
        if self.qp.expansion:
            groups = [group.name for group in self.qp.rows if group.elastic]
            slacks, multipliers = (vertcat(*map(of, groups)) for of in (self.slack, self.multipliers))
            good = logic_and(good, multiplier_error(slacks, multipliers, self.qp.penalties, accuracy) <= accuracy)
        # maxima pass over NaN, sums do not
        return logic_and(good, is_finite(vertcat(self.x, self.row_multipliers, self.box_multipliers)))

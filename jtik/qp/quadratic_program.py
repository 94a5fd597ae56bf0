"""A quadratic program (QP) as symbolic data, with named groups of rows, and its solution as symbols.

    minimise 1/2 x' P x + q' x   subject to   l <= C x <= u (each group of rows),   lb <= x <= ub

A strategy writes a QP where it needs the solution and continues with the solution as an expression; the engine calls
the solver in between. A strategy may use several QPs, and each may depend on the solutions of those before it. Rows may
be elastic: they are relaxed where they cannot be satisfied, with a penalty, and the solution reports by how much.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from jtik.arguments import flag
from jtik.errors import ArgumentError
from jtik.qp import rows
from jtik.qp.convexity import ZERO_PIVOT, is_convex, smallest_eigenvalue
from jtik.qp.elastic import Elastic, SlackExpansion
from jtik.qp.rows import Rows
from jtik.qp.solution import QPSolution
from jtik.symbolic import (
    LDL,
    SX,
    Expression,
    if_else,
    is_finite,
    logic_and,
    logic_not,
    logic_or,
    mmax,
    mmin,
    norm_inf,
    vertcat,
    zeros,
)

__all__ = ["QPSolution", "QuadraticProgram", "Rows"]

CROSSING_TOLERANCE = 1e-9
"""A lower bound may exceed its upper bound by this much: rounding."""

ROUNDING = 1e-12
"""Largest violation of a row, and of P x + q = 0 relative to 1 + |q|, of an unconstrained minimiser."""

LARGEST_UNROLLED = 225
"""Entries of P, of 15 variables if it is dense, up to which the unconstrained minimiser is computed: the operations of
an unrolled factorisation grow with the cube of the variables, and a solver is faster."""


@dataclass(frozen=True)
class QuadraticProgram:
    """A convex quadratic program: minimise 1/2 x' P x + q' x over rows and a box.

    Attributes:
        P: Hessian (n, n), symmetric positive semidefinite.
        q: linear cost (n, 1).
        lower: lower bounds of x (n, 1).
        upper: upper bounds of x (n, 1).
        rows: groups of rows.
        name: name of the QP, for `InverseKinematics.build` and reports.
        closed_form: for a strategy that knows the solution of ordinary steps: x (n, 1), and 1 where it is the solution,
            else 0. P then is not checked to be convex.
        known_convex: whether P is positive semidefinite by construction, such as a Gram matrix, and is not checked.

    Raises:
        ArgumentError: if shapes do not match, or if P is numeric and not positive semidefinite.
    """

    P: Expression
    q: Expression
    lower: Expression
    upper: Expression
    rows: Sequence[Rows] = ()
    name: str = "qp"
    closed_form: tuple[Expression, Expression] | None = None
    known_convex: bool = False

    def __post_init__(self) -> None:
        flag("known_convex", self.known_convex)
        if not isinstance(self.name, str):
            raise ArgumentError("name", self.name, "a text")
        n = self.size
        for what, expected in (("P", (n, n)), ("lower", (n, 1)), ("upper", (n, 1))):
            value = getattr(self, what)
            shape = getattr(value, "shape", None)
            if shape != expected:
                given = value if shape is None else f"shape {shape}"
                raise ArgumentError(f"{self.name}.{what}", given, f"{n} variables, as q")
        for group in self.rows:
            bounds = {group.lower.shape, group.upper.shape}
            if group.matrix.shape[1] != n or bounds != {(group.count, 1)}:
                given = f"matrix {group.matrix.shape}, bounds {' and '.join(map(str, sorted(bounds)))}"
                raise ArgumentError(f"{self.name}, rows {group.name!r}", given, f"(k, {n}) and (k, 1)")
            if group.elastic:
                group.elastic.columns(group.count)
        smallest = smallest_eigenvalue(self.P)
        if smallest is not None and smallest < -ZERO_PIVOT:
            given = f"a matrix that is not convex: its smallest eigenvalue is {smallest:.3g} of its largest entry"
            raise ArgumentError(f"{self.name}.P", given, "a positive semidefinite matrix")

    @property
    def size(self) -> int:
        """Number of variables."""
        return int(self.q.shape[0])

    @cached_property
    def convex(self) -> Expression:
        """1 where P is positive semidefinite, else 0, where a stationary point need not be a minimum."""
        known = self.known_convex or self.closed_form  # a strategy with a closed form guarantees that P is convex
        return 1 if known else is_convex(self.P)

    @cached_property
    def valid(self) -> Expression:
        """1 where numbers are finite, or infinite bounds, and no bounds cross; else 0, and no solver is called."""
        return logic_and(is_finite(self.P), self._bounds_valid)

    @cached_property
    def _bounds_valid(self) -> Expression:
        """The same for all numbers but those of P."""
        _, q, _, *bounds = self.data()
        finite = is_finite(q)
        for group in self.rows:
            finite = logic_and(finite, group.is_finite)
        return logic_and(finite, _in_order(*bounds))

    @property
    def row_count(self) -> int:
        """Number of rows of all groups."""
        return sum(group.count for group in self.rows)

    def rows_of(self, name: str) -> tuple[Rows, slice]:
        """A group of rows, and its slice of all rows.

        Args:
            name: name of the group.

        Raises:
            ArgumentError: if there is no group of that name.
        """
        start = 0
        for group in self.rows:
            if group.name == name:
                return group, slice(start, start + group.count)
            start += group.count
        raise ArgumentError("name", name, f"one of {[group.name for group in self.rows]}")

    @cached_property
    def expansion(self) -> SlackExpansion | None:
        """How slack variables are added for elastic rows; None without elastic rows."""
        elastic, start = list[int](), 0
        for group in self.rows:
            elastic += range(start, start + group.count) if group.elastic else ()
            start += group.count
        if not elastic:
            return None
        _, _, _, low, high, _, _ = self.data()
        return SlackExpansion.of(self.size, self.row_count, elastic, low, high)

    @cached_property
    def penalties(self) -> list[Expression]:
        """Penalty, curvature and largest slack of the elastic rows, (e, 1) each; empty without elastic rows."""
        columns = [group.elastic.columns(group.count) for group in self.rows if group.elastic]
        return [vertcat(*column) for column in zip(*columns, strict=True)]

    def data(self) -> list[Expression]:
        """P, q, C, l, u, lb, ub; the groups of rows are stacked."""
        if self.row_count:
            C, low, high = (vertcat(*[getattr(g, of) for g in self.rows]) for of in ("matrix", "lower", "upper"))
        else:
            C, low, high = zeros(0, self.size), zeros(0), zeros(0)
        return [self.P, self.q, C, low, high, self.lower, self.upper]

    @property
    def has_many_rows(self) -> bool:
        """Whether its rows are so many that what is done with them are loops over numbers."""
        return self.row_count * self.size > rows.LARGEST_UNROLLED

    @property
    def tries_minimiser(self) -> bool:
        """Whether the unconstrained minimiser is computed, before a solver is called."""
        return self.closed_form is None and SX(self.P).nnz() <= LARGEST_UNROLLED

    @property
    def has_fast_path(self) -> bool:
        """Whether it is known without its data whether a solution without a solver is one."""
        return self.closed_form is not None or (self.tries_minimiser and not self.has_many_rows)

    def solution_without_solver(self) -> tuple[Expression, Expression]:
        """The closed-form solution, or else the unconstrained minimiser, and whether it solves the QP.

        Far from limits this solves most QPs without a solver. Where P is singular the unconstrained minimiser is
        not finite, and no solution. Whether it satisfies many rows is not checked here: `is_solution` does.

        Returns:
            x (n, 1), NaN for invalid bounds, rows or linear cost; 1 where no solver has to be called, else 0.
        """
        if self.closed_form is None and not self.tries_minimiser:
            return zeros(self.size), zeros(1)
        if not self.has_fast_path:
            return self._unconstrained_minimiser()
        x, solves = self.closed_form or self._unconstrained_minimiser()
        return if_else(self._bounds_valid, x, math.nan), logic_or(solves, logic_not(self._bounds_valid))

    def with_data(self, data: Sequence[Expression]) -> QuadraticProgram:
        """The same QP for other data: what `data` returns, then the `penalties`.

        Args:
            data: P, q, C, l, u, lb, ub, then penalty, curvature and largest slack of the elastic rows, if there are
                any.
        """
        (P, q, C, low, high, lower, upper), penalties = data[:7], data[7:]
        rows, start, elastic_start = list[Rows](), 0, 0
        for group in self.rows:
            own, elastic = slice(start, start + group.count), group.elastic
            if elastic:
                of = slice(elastic_start, elastic_start + group.count)
                penalty, curvature, max_slack = (column[of] for column in penalties)
                elastic, elastic_start = Elastic(penalty, max_slack, curvature), of.stop
            part = (C, low, high) if len(self.rows) == 1 else (C[own, :], low[own], high[own])
            rows.append(Rows(group.name, *part, elastic, group.exact))
            start = own.stop
        known = (zeros(self.size), zeros(1)) if self.closed_form else None
        return QuadraticProgram(P, q, lower, upper, rows, self.name, known, self.known_convex)

    def _unconstrained_minimiser(self) -> tuple[Expression, Expression]:
        """-P^-1 q, and 1 where it satisfies rows and box, else 0."""
        P, q, C, low, high, lower, upper = self.data()
        factor = LDL.of(P)
        x = -factor.solve(q)
        inside = logic_and(mmax(lower - x) <= 0, mmax(x - upper) <= 0)
        if self.row_count and not self.has_many_rows:
            inside = logic_and(inside, satisfies_rows(C @ x, low, high))
        stationary = norm_inf(P @ x + q) <= ROUNDING * (1 + norm_inf(q))
        return x, logic_and(logic_and(inside, logic_and(stationary, factor.positive_definite)), is_finite(x))


def satisfies_rows(Cx: Expression, low: Expression, high: Expression) -> Expression:
    """1 where the values of rows are within their bounds to rounding, else 0.

    Args:
        Cx: the values of the rows (k, 1).
        low: lower bounds of the rows (k, 1).
        high: upper bounds of the rows (k, 1).
    """
    return logic_and(mmax(low - Cx) <= ROUNDING, mmax(Cx - high) <= ROUNDING)


def is_solution(x: Expression, data: Sequence[Expression]) -> Expression:
    """1 where x, the minimiser without rows and in the box, satisfies the rows, and all numbers of the QP are valid.

    Args:
        x: the minimiser (n, 1).
        data: P, q, C, l, u, lb, ub.
    """
    _, _, C, low, high, lower, upper = data
    Cx = C @ x
    good = logic_and(is_finite(Cx), satisfies_rows(Cx, low, high))  # x is finite, so that C is where C x is
    return logic_and(good, _in_order(low, high, lower, upper))


def bounds_valid(
    q: Expression, C: Expression, low: Expression, high: Expression, lower: Expression, upper: Expression
) -> Expression:
    """1 where linear cost and rows are finite, no bound is NaN, and none exceeds the other one; else 0.

    Args:
        q: linear cost (n, 1).
        C: rows (k, n).
        low: lower bounds of the rows (k, 1).
        high: upper bounds of the rows (k, 1).
        lower: lower bounds of x (n, 1).
        upper: upper bounds of x (n, 1).
    """
    return logic_and(logic_and(is_finite(q), is_finite(C)), _in_order(low, high, lower, upper))


def _in_order(low: Expression, high: Expression, lower: Expression, upper: Expression) -> Expression:
    """1 where no bound is NaN, and none exceeds the other one."""
    in_order = mmin(lower <= upper + CROSSING_TOLERANCE)
    return logic_and(in_order, mmin(low <= high + CROSSING_TOLERANCE)) if low.shape[0] else in_order

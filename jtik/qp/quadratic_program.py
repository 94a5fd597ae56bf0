"""A quadratic program as symbolic data, with named groups of rows, and its solution as a symbol.

    minimise 1/2 x' P x + q' x   subject to   l <= C x <= u (each group of rows),   lb <= x <= ub

A strategy writes its program where it needs the answer and goes on with the answer as an expression; the engine puts
the solver in between. A strategy that needs several, one after the other, just asks again. Rows may be elastic: they
give way where they must, at a price, and the solution says by how much.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from jtik.errors import ArgumentError
from jtik.qp.convexity import FLAT, convex, lowest_eigenvalue
from jtik.qp.elastic import Elastic, Expansion, mispriced
from jtik.symbolic import (
    Expression,
    fmax,
    if_else,
    is_finite,
    logic_and,
    logic_not,
    logic_or,
    mmax,
    norm_inf,
    solve_ldl,
    vertcat,
    zeros,
)

CROSSED = 1e-9
"""A lower bound may be above its upper one by this much: rounding."""

EXACT = 1e-12
"""What an answer in closed form may break of a row, or leave of P x + q relative to 1 + |q|: rounding."""


@dataclass(frozen=True)
class Rows:
    """A named group of rows ``lower <= matrix x <= upper``: (k, n), (k, 1), (k, 1); equal bounds are an equality.

    With ``elastic`` each of them may be broken by as much as that allows, for its price.
    """

    name: str
    matrix: Expression
    lower: Expression
    upper: Expression
    elastic: Elastic | None = None

    @classmethod
    def equal(cls, name: str, matrix: Expression, to: Expression, elastic: Elastic | None = None) -> Rows:
        """matrix x = to."""
        return cls(name, matrix, to, to, elastic)

    @property
    def count(self) -> int:
        """Number of rows."""
        return int(self.matrix.shape[0])


@dataclass(frozen=True)
class QuadraticProgram:
    """P (n, n) symmetric positive semidefinite, q (n, 1), groups of rows, and a box (n, 1) each.

    ``closed_form`` is for a law that knows the answer of ordinary steps: x (n, 1), and 1 where it is one, else 0.
    """

    P: Expression
    q: Expression
    lower: Expression
    upper: Expression
    rows: Sequence[Rows] = ()
    name: str = "program"
    closed_form: tuple[Expression, Expression] | None = None

    def __post_init__(self) -> None:
        n = self.size
        for what, value in (("P", self.P.shape == (n, n)), ("lower", self.lower.shape == (n, 1))):
            if not value:
                raise ArgumentError(f"{self.name}.{what}", f"shape {getattr(self, what).shape}", f"{n} variables, as q")
        for group in self.rows:
            if group.matrix.shape[1] != n or group.lower.shape != (group.count, 1):
                given = f"matrix {group.matrix.shape}, bounds {group.lower.shape}"
                raise ArgumentError(f"{self.name}, rows {group.name!r}", given, f"(k, {n}) and (k, 1)")
            if group.elastic:
                group.elastic.columns(group.count)
        lowest = lowest_eigenvalue(self.P)
        if lowest is not None and lowest < -FLAT:
            given = f"a matrix that is not convex: its lowest eigenvalue is {lowest:.3g} of its largest entry"
            raise ArgumentError(f"{self.name}.P", given, "a positive semidefinite one")

    @property
    def size(self) -> int:
        """Number of variables."""
        return int(self.q.shape[0])

    @cached_property
    def convex(self) -> Expression:
        """1 where P is positive semidefinite: else a stationary point need not be a minimum."""
        return 1 if self.closed_form else convex(self.P)  # a law that knows answers knows its P

    @cached_property
    def sound(self) -> Expression:
        """1 where every number is finite, or an infinite bound, and no bounds cross: else no solver need be asked."""
        P, q, C, low, high, lower, upper = self.data()
        good = logic_and(is_finite(P), logic_and(is_finite(q), is_finite(C)))
        for below, above in ((low, high), (lower, upper)):
            for i in range(below.shape[0]):
                good = logic_and(good, below[i] <= above[i] + CROSSED)
        return good

    @property
    def row_count(self) -> int:
        """Number of rows of all groups."""
        return sum(group.count for group in self.rows)

    def rows_of(self, name: str) -> tuple[Rows, slice]:
        """A group of rows, and where it lies among all. Raises ArgumentError when there is none of the name."""
        start = 0
        for group in self.rows:
            if group.name == name:
                return group, slice(start, start + group.count)
            start += group.count
        raise ArgumentError("name", name, f"one of {[group.name for group in self.rows]}")

    @cached_property
    def expansion(self) -> Expansion | None:
        """How it becomes a plain program; None where no row is elastic and it is one."""
        elastic, start = list[int](), 0
        for group in self.rows:
            elastic += range(start, start + group.count) if group.elastic else ()
            start += group.count
        if not elastic:
            return None
        _, _, _, low, high, _, _ = self.data()
        return Expansion.of(self.size, self.row_count, elastic, low, high)

    @cached_property
    def prices(self) -> list[Expression]:
        """Price, curvature and give of the elastic rows, (e, 1) each; nothing where there are none."""
        columns = [group.elastic.columns(group.count) for group in self.rows if group.elastic]
        return [vertcat(*column) for column in zip(*columns, strict=True)]

    def data(self) -> list[Expression]:
        """P, q, C, l, u, lb, ub, the groups one below the other."""
        if self.row_count:
            C, low, high = (vertcat(*[getattr(g, of) for g in self.rows]) for of in ("matrix", "lower", "upper"))
        else:
            C, low, high = zeros(0, self.size), zeros(0), zeros(0)
        return [self.P, self.q, C, low, high, self.lower, self.upper]

    def shortcut(self) -> tuple[Expression, Expression]:
        """The minimiser without rows and box, (n, 1), and 1 where it keeps to both and so is the answer, or 0.

        Far from limits most programs are solved by it, and no solver need be called. Where P is singular it is not
        finite, and no answer. A program that is not sound has NaN for one: there are solvers that loop on it.
        """
        x, holds = self.closed_form or self._without_limits()
        return if_else(self.sound, x, math.nan), logic_or(holds, logic_not(self.sound))

    def _without_limits(self) -> tuple[Expression, Expression]:
        """-P^-1 q, and whether limits leave it as it is."""
        P, q, C, low, high, lower, upper = self.data()
        x = -solve_ldl(P, q)
        inside = logic_and(mmax(lower - x) <= 0, mmax(x - upper) <= 0)
        if self.row_count:
            Cx = C @ x
            kept = logic_and(mmax(low - Cx) <= EXACT, mmax(Cx - high) <= EXACT)
            inside = logic_and(inside, kept)
        stationary = norm_inf(P @ x + q) <= EXACT * (1 + norm_inf(q))
        return x, logic_and(logic_and(inside, logic_and(stationary, self.convex)), is_finite(x))


@dataclass(frozen=True)
class QPSolution:
    """What the solver will answer, as expressions.

    Attributes: x (n, 1); multipliers of all rows and of the box, positive where an upper bound holds:
    ``P x + q + C' rows + box = 0``; the program.
    """

    x: Expression
    row_multipliers: Expression
    box_multipliers: Expression
    program: QuadraticProgram

    def multipliers(self, name: str) -> Expression:
        """Of one group of rows, (k, 1)."""
        return self.row_multipliers[self.program.rows_of(name)[1]]

    def slack(self, name: str) -> Expression:
        """By how much each row of an elastic group gave way, (k, 1), from 0."""
        group, _ = self.program.rows_of(name)
        if group.elastic is None:
            elastic = [each.name for each in self.program.rows if each.elastic]
            raise ArgumentError("name", name, f"an elastic group of rows, one of {elastic}")
        used = group.matrix @ self.x
        return fmax(fmax(group.lower - used, used - group.upper), 0)

    @cached_property
    def violation(self) -> Expression:
        """The largest amount by which a row, beyond what it may give, or the box is broken."""
        _, _, C, low, high, lower, upper = self.program.data()
        worst = fmax(mmax(lower - self.x), mmax(self.x - upper))
        if self.program.row_count:
            Cx = C @ self.x
            below, above = low - Cx, Cx - high
            if self.program.expansion:
                rows, give = list(self.program.expansion.elastic), self.program.prices[2]
                below[rows] -= give
                above[rows] -= give
            worst = fmax(worst, fmax(mmax(below), mmax(above)))
        return fmax(worst, 0)

    @cached_property
    def stationarity(self) -> Expression:
        """The largest entry of P x + q + C' rows + box."""
        P, q, C = self.program.data()[:3]
        return norm_inf(P @ self.x + q + C.T @ self.row_multipliers + self.box_multipliers)

    def solved(self, accuracy: float) -> Expression:
        """1 where both are within ``accuracy``, relative to q for the second, P is convex and nothing is NaN."""
        size = 1 + norm_inf(self.program.q)
        near = logic_and(self.violation <= accuracy, self.stationarity <= accuracy * size)
        near = logic_and(near, logic_and(self.program.convex, self.program.sound))
        if self.program.expansion:
            groups = [group.name for group in self.program.rows if group.elastic]
            slacks, multipliers = (vertcat(*map(of, groups)) for of in (self.slack, self.multipliers))
            near = logic_and(near, mispriced(slacks, multipliers, self.program.prices, accuracy) <= accuracy)
        # maxima pass over NaN, sums do not
        return logic_and(near, is_finite(vertcat(self.x, self.row_multipliers, self.box_multipliers)))

"""A quadratic program as symbolic data, with named groups of rows, and its solution as a symbol.

    minimise 1/2 x' P x + q' x   subject to   l <= C x <= u (each group of rows),   lb <= x <= ub

A strategy writes its program where it needs the answer and goes on with the answer as an expression; the engine puts
the solver in between. A strategy that needs several, one after the other, just asks again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

from jtik.errors import ArgumentError
from jtik.symbolic import Expression, fmax, is_finite, logic_and, mmax, norm_inf, symbol, vertcat, zeros


@dataclass(frozen=True)
class Rows:
    """A named group of rows ``lower <= matrix x <= upper``: (k, n), (k, 1), (k, 1); equal bounds are an equality."""

    name: str
    matrix: Expression
    lower: Expression
    upper: Expression

    @classmethod
    def equal(cls, name: str, matrix: Expression, to: Expression) -> Rows:
        """matrix x = to."""
        return cls(name, matrix, to, to)

    @property
    def count(self) -> int:
        """Number of rows."""
        return int(self.matrix.shape[0])


@dataclass(frozen=True)
class Program:
    """P (n, n) symmetric positive semidefinite, q (n, 1), groups of rows, and a box (n, 1) each."""

    P: Expression
    q: Expression
    lower: Expression
    upper: Expression
    rows: Sequence[Rows] = ()
    name: str = "program"

    def __post_init__(self) -> None:
        n = self.size
        for what, value in (("P", self.P.shape == (n, n)), ("lower", self.lower.shape == (n, 1))):
            if not value:
                raise ArgumentError(f"{self.name}.{what}", f"shape {getattr(self, what).shape}", f"{n} variables, as q")
        for group in self.rows:
            if group.matrix.shape[1] != n or group.lower.shape != (group.count, 1):
                given = f"matrix {group.matrix.shape}, bounds {group.lower.shape}"
                raise ArgumentError(f"{self.name}, rows {group.name!r}", given, f"(k, {n}) and (k, 1)")

    @property
    def size(self) -> int:
        """Number of variables."""
        return int(self.q.shape[0])

    @property
    def row_count(self) -> int:
        """Number of rows of all groups."""
        return sum(group.count for group in self.rows)

    def data(self) -> list[Expression]:
        """P, q, C, l, u, lb, ub, the groups one below the other."""
        if self.row_count:
            C, low, high = (vertcat(*[getattr(g, of) for g in self.rows]) for of in ("matrix", "lower", "upper"))
        else:
            C, low, high = zeros(0, self.size), zeros(0), zeros(0)
        return [self.P, self.q, C, low, high, self.lower, self.upper]


@dataclass(frozen=True)
class ProgramSolution:
    """What the solver will answer, as expressions.

    Attributes: x (n, 1); multipliers of all rows and of the box, positive where an upper bound holds:
    ``P x + q + C' rows + box = 0``; the program.
    """

    x: Expression
    row_multipliers: Expression
    box_multipliers: Expression
    program: Program

    def multipliers(self, name: str) -> Expression:
        """Of one group of rows, (k, 1)."""
        start = 0
        for group in self.program.rows:
            if group.name == name:
                return self.row_multipliers[start : start + group.count]
            start += group.count
        raise ArgumentError("name", name, f"one of {[group.name for group in self.program.rows]}")

    @cached_property
    def violation(self) -> Expression:
        """The largest amount by which a row or the box is broken."""
        _, _, C, low, high, lower, upper = self.program.data()
        worst = fmax(mmax(lower - self.x), mmax(self.x - upper))
        if self.program.row_count:
            Cx = C @ self.x
            worst = fmax(worst, fmax(mmax(low - Cx), mmax(Cx - high)))
        return fmax(worst, 0)

    @cached_property
    def stationarity(self) -> Expression:
        """The largest entry of P x + q + C' rows + box."""
        P, q, C = self.program.data()[:3]
        return norm_inf(P @ self.x + q + C.T @ self.row_multipliers + self.box_multipliers)

    def solved(self, accuracy: float) -> Expression:
        """1 where both are within ``accuracy``, relative to q for the second, and nothing is NaN."""
        size = 1 + norm_inf(self.program.q)
        near = logic_and(self.violation <= accuracy, self.stationarity <= accuracy * size)
        # maxima pass over NaN, sums do not
        return logic_and(near, is_finite(vertcat(self.x, self.row_multipliers, self.box_multipliers)))


@dataclass(frozen=True)
class Recorded:
    """A program and the symbols that stand for its answer."""

    program: Program
    solution: ProgramSolution


@dataclass
class Recorder:
    """Takes programs in the order in which a strategy asks for answers."""

    accuracy: float
    programs: list[Recorded] = field(default_factory=list)

    def solve(self, program: Program) -> ProgramSolution:
        """The answer, as symbols."""
        k, n, rows = len(self.programs), program.size, program.row_count
        solution = ProgramSolution(symbol(f"x{k}", n), symbol(f"y{k}", rows), symbol(f"z{k}", n), program)
        self.programs.append(Recorded(program, solution))
        return solution

    def solved(self) -> Expression:
        """1 where every program so far was answered rightly."""
        good: Expression = 1
        for recorded in self.programs:
            good = logic_and(good, recorded.solution.solved(self.accuracy))
        return good

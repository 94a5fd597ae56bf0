"""A quadratic program as symbolic data, with named groups of rows, and its solution as a symbol.

    minimise 1/2 x' P x + q' x   subject to   l <= C x <= u (each group of rows),   lb <= x <= ub

A strategy writes its program where it needs the answer and goes on with the answer as an expression; the engine puts
the solver in between. A strategy that needs several, one after the other, just asks again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeAlias

from jtik.errors import ArgumentError, Array
from jtik.symbolic import (
    Expression,
    fmax,
    is_finite,
    logic_and,
    logic_or,
    mmax,
    norm_inf,
    solve_ldl,
    symbol,
    vertcat,
    zeros,
)

Compute: TypeAlias = Callable[[Sequence[Array]], "Sequence[Any] | None"]
"""What Python does in the middle of a step: flat arrays (columns first) to arrays; None where there is no answer."""


EXACT = 1e-12
"""What an answer in closed form may break of a row, or leave of P x + q relative to 1 + |q|: rounding."""


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

    def shortcut(self) -> tuple[Expression, Expression]:
        """The minimiser without rows and box, (n, 1), and 1 where it keeps to both and so is the answer, or 0.

        Far from limits most programs are solved by it, and no solver need be called. Where P is singular it is not
        finite, and no answer.
        """
        if self.closed_form is not None:
            return self.closed_form
        P, q, C, low, high, lower, upper = self.data()
        x = -solve_ldl(P, q)
        inside = logic_and(mmax(lower - x) <= 0, mmax(x - upper) <= 0)
        if self.row_count:
            Cx = C @ x
            kept = logic_and(mmax(low - Cx) <= EXACT, mmax(Cx - high) <= EXACT)
            inside = logic_and(inside, kept)
        steady = norm_inf(P @ x + q) <= EXACT * (1 + norm_inf(q))
        return x, logic_and(logic_and(inside, steady), is_finite(x))


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

    @property
    def name(self) -> str:
        """The program's."""
        return self.program.name

    def data(self) -> list[Expression]:
        """What the solver is given."""
        return self.program.data()

    @property
    def answers(self) -> list[Expression]:
        """What it answers."""
        return [self.solution.x, self.solution.row_multipliers, self.solution.box_multipliers]

    def solved(self, accuracy: float) -> Expression:
        """1 where the answer holds."""
        return self.solution.solved(accuracy)


@dataclass(frozen=True)
class Computation:
    """Something that Python computes from numbers of the step, and the symbols that stand for what comes out."""

    name: str
    compute: Compute
    inputs: list[Expression]
    answers: list[Expression]

    def data(self) -> list[Expression]:
        """What it is given."""
        return self.inputs

    def solved(self, accuracy: float) -> Expression:
        """1 where there is an answer without NaN."""
        good: Expression = 1
        for answer in self.answers:
            for i in range(answer.numel()):
                # every number is on one side of zero, NaN on neither
                good = logic_and(good, logic_or(answer[i] <= 0, answer[i] >= 0))
        return good


@dataclass
class Recorder:
    """Takes programs and computations in the order in which a strategy asks for answers."""

    accuracy: float
    solver: str = "daqp"
    programs: list[Recorded | Computation] = field(default_factory=list)

    def compute(
        self, name: str, compute: Compute, inputs: Sequence[Expression], shapes: Sequence[tuple[int, int]]
    ) -> list[Expression]:
        """What Python will answer, as symbols of these shapes."""
        k = len(self.programs)
        answers = [symbol(f"c{k}_{i}", *shape) for i, shape in enumerate(shapes)]
        self.programs.append(Computation(name, compute, list(inputs), answers))
        return answers

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
            good = logic_and(good, recorded.solved(self.accuracy))
        return good

"""What happens between the functions of a step: a program for a solver, or a computation in Python."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from jtik.qp.backend import CalledBackend, FusedBackend, Numbers
from jtik.qp.elastic import Expansion
from jtik.qp.quadratic_program import QuadraticProgram
from jtik.qp.recorder import Compute
from jtik.symbolic import MX, Expression, Function, either, function
from jtik.symbolic.compile import bind
from jtik.types import Array


@dataclass(frozen=True)
class QPCall:
    """A program of ``n`` variables and ``rows`` rows, for the back end; how its elastic rows become plain ones."""

    name: str
    n: int
    rows: int
    expansion: Expansion | None = None

    @classmethod
    def of(cls, program: QuadraticProgram) -> QPCall:
        """For programs of this size."""
        return cls(program.name, program.size, program.row_count, program.expansion)

    @property
    def sizes(self) -> list[int]:
        """Of x, row multipliers and box multipliers."""
        return [self.n, self.rows, self.n]

    @property
    def plain_size(self) -> int:
        """Number of variables that a solver sees."""
        return self.expansion.size if self.expansion else self.n

    def plain(self, data: Sequence[Array]) -> tuple[list[Array], Callable[[], None] | None]:
        """The plain program's memory, and what fills it from a stage's outputs where that is another."""
        if self.expansion is None:
            return list(data[:7]), None
        expand = self.expansion.function()
        memory = outputs_of(expand)
        return memory, bind(expand, list(data[:10]), memory)

    def plain_numbers(self, data: Sequence[Array]) -> Numbers:
        """A stage's outputs as a plain program."""
        memory, expand = self.plain(data)
        if expand:
            expand()
        return self.numbers(memory)

    def numbers(self, plain: Sequence[Array]) -> Numbers:
        """A plain program's memory, columns first as CasADi has them, as a program."""
        n, (P, q, C, low, high, lower, upper) = self.plain_size, plain
        return Numbers(P.reshape(n, n).T, q, C.reshape(n, self.rows).T, low, high, lower, upper)

    def solved_by(self, backend: FusedBackend) -> Function:
        """(the program's data, the answer of its shortcut and whether that holds) -> answer, by a fused back end.

        The solver is not called where the shortcut holds.
        """
        data = [MX.sym(f"d{i}", *size) for i, size in enumerate(self.data_sizes)]
        *given, x, holds = data
        near = function("near", [*given, x], [x, MX(self.rows, 1), MX(self.n, 1)])
        solver = function("far", [*given, x], self.answered(given, backend))
        return function("solved", data, called(either(near, solver), [holds, *given, x]))

    def answered(self, given: Sequence[Expression], backend: FusedBackend) -> list[Expression]:
        """The answer of a fused back end to a program's data."""
        plain = called(self.expansion.function(), given) if self.expansion else given
        answer = called(backend.function(self.plain_size, self.rows), plain)
        if self.expansion:  # slacks come last, and are known from the rest
            answer = [answer[0][: self.n], answer[1], answer[2][: self.n]]
        return answer

    @property
    def data_sizes(self) -> list[tuple[int, int]]:
        """Of P, q, C, l, u, lb, ub, what elastic rows cost, and of the shortcut's answer and whether it holds."""
        n, k, e = self.n, self.rows, len(self.expansion.elastic) if self.expansion else 0
        prices = [(e, 1)] * 3 if self.expansion else []
        return [(n, n), (n, 1), (k, n), (k, 1), (k, 1), (n, 1), (n, 1), *prices, (n, 1), (1, 1)]


@dataclass(frozen=True)
class PythonCall:
    """A computation in Python whose answers have these sizes."""

    name: str
    compute: Compute
    sizes: list[int]


class Answering:
    """A solver with the memory of its program and of its answer; NaN is the answer where there is none."""

    def __init__(self, backend: CalledBackend, program: Numbers, answer: list[Array]) -> None:
        self._solver = backend.solver(len(program.q), len(program.low))
        self._program, self._answer = program, answer

    def __call__(self) -> None:
        """Answer the program that is in memory."""
        solution = self._solver.solve(self._program) if self._program.sound else None
        if solution is None:
            for memory in self._answer:
                memory[:] = np.nan
            return
        for memory, values in zip(self._answer, solution, strict=True):
            memory[:] = values[: len(memory)]  # slacks come last


class Computing:
    """Python with the memory of its arguments and of its answer; NaN is the answer where there is none."""

    def __init__(self, compute: Compute, data: list[Array], answer: list[Array]) -> None:
        self._compute, self._data, self._answer = compute, data, answer

    def __call__(self) -> None:
        """Compute from the arguments that are in memory."""
        found = self._compute(self._data)
        for i, memory in enumerate(self._answer):
            memory[:] = np.nan if found is None else np.asarray(found[i], dtype=float).ravel(order="F")


def called(inner: Function, arguments: Sequence[Expression]) -> list[Expression]:
    """What a function makes of expressions."""
    answer = inner(*arguments)
    return list(answer) if isinstance(answer, (tuple, list)) else [answer]


def evaluated(of: Function, arguments: list[Array]) -> list[Array]:
    """What it makes of numbers, as columns."""
    results = outputs_of(of)
    bind(of, arguments, results)()
    return results


def outputs_of(of: Function) -> list[Array]:
    """Memory for what it makes."""
    return [np.zeros(of.numel_out(i)) for i in range(of.n_out())]

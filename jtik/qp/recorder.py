"""Recording of the QPs and Python computations that a strategy uses, in order, with the symbols of their results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from jtik.qp.quadratic_program import QuadraticProgram
from jtik.qp.solution import QPSolution
from jtik.result.deprecated import RenamedAttribute
from jtik.symbolic import Expression, Function, logic_and, logic_or, symbol
from jtik.types import Array

Compute: TypeAlias = Callable[[Sequence[Array]], "Sequence[Any] | None"]
"""A Python function inside a step: flat column-major arrays -> arrays, or None if there is no result."""


@dataclass(frozen=True)
class RecordedQP:
    """A QP and the symbols of its solution.

    Attributes:
        qp: the quadratic program.
        solution: its solution, as symbols.
        good: 1 where the solution satisfies the optimality conditions, as a symbol. What solves the QP checks it: a
            solution that is known without a solver only has to be finite.
    """

    qp: QuadraticProgram
    solution: QPSolution
    good: Expression
    program = RenamedAttribute("qp")
    answers = RenamedAttribute("result_symbols")

    @property
    def name(self) -> str:
        """The QP's name."""
        return self.qp.name

    def data(self) -> list[Expression]:
        """The QP's data, as the solver is given them."""
        return self.qp.data()

    @property
    def result_symbols(self) -> list[Expression]:
        """Symbols of x, row multipliers and box multipliers, and of whether they are a solution."""
        return [self.solution.x, self.solution.row_multipliers, self.solution.box_multipliers, self.good]

    def solved(self) -> Expression:
        """1 where the QP is solved, else 0."""
        return self.good


@dataclass(frozen=True)
class RecordedComputation:
    """A computation in Python inside a step, and the symbols of its results.

    Attributes:
        name: name of the computation.
        compute: the Python function.
        inputs: expressions of its arguments.
        result_symbols: symbols of its results.
    """

    name: str
    compute: Compute
    inputs: list[Expression]
    result_symbols: list[Expression]
    answers = RenamedAttribute("result_symbols")

    def data(self) -> list[Expression]:
        """Expressions of the arguments."""
        return self.inputs

    def solved(self) -> Expression:
        """1 where no result is NaN, else 0."""
        good: Expression = 1
        for result in self.result_symbols:
            for i in range(result.numel()):
                # every number is on one side of zero, NaN on neither
                good = logic_and(good, logic_or(result[i] <= 0, result[i] >= 0))
        return good


@dataclass(frozen=True)
class RecordedFunction:
    """A function inside a step that is evaluated only where its result is not known without it.

    Attributes:
        name: name of the function.
        function: (inputs) -> result, a column.
        inputs: expressions of its arguments.
        known: the result where it is known (k, 1), and 1 there, else 0.
        result_symbols: the symbol of the result, and of whether the direct one was taken.
        direct: (inputs) -> what the result mostly is, and 1 where it is; None where no such expression is known.
    """

    name: str
    function: Function
    inputs: list[Expression]
    known: tuple[Expression, Expression]
    result_symbols: list[Expression]
    direct: Function | None = None

    def data(self) -> list[Expression]:
        """Expressions of the arguments."""
        return self.inputs

    def solved(self) -> Expression:
        """1: the function itself answers for its result."""
        return 1


@dataclass(frozen=True)
class Preparation:
    """A QP that is solved before the step, where it is needed.

    Attributes:
        needed: 1 where the QP is needed, else 0.
        solution: the QP's solution, as symbols.
        results: expressions of that solution.
        result_symbols: symbols of the results, as the step uses them.
    """

    needed: Expression
    solution: QPSolution
    results: list[Expression]
    result_symbols: list[Expression]


@dataclass
class QPRecorder:
    """Records QPs and computations in the order in which a strategy uses their results.

    Attributes:
        accuracy: what solutions are checked against.
        solver: name of the back end.
        calls: the QPs and computations so far.
        preparations: the QPs that are solved before the step.
    """

    accuracy: float
    solver: str = "daqp"
    calls: list[RecordedQP | RecordedComputation | RecordedFunction] = field(default_factory=list)
    preparations: list[Preparation] = field(default_factory=list)
    programs = RenamedAttribute("calls")

    def compute(
        self, name: str, compute: Compute, inputs: Sequence[Expression], shapes: Sequence[tuple[int, int]]
    ) -> list[Expression]:
        """Record a computation in Python.

        Args:
            name: name of the computation.
            compute: the Python function; it gets flat, column-major arrays.
            inputs: expressions of its arguments.
            shapes: shapes of its results.

        Returns:
            Symbols of the results.
        """
        k = len(self.calls)
        symbols = [symbol(f"c{k}_{i}", *shape) for i, shape in enumerate(shapes)]
        self.calls.append(RecordedComputation(name, compute, list(inputs), symbols))
        return symbols

    def evaluate(
        self,
        name: str,
        function: Function,
        inputs: Sequence[Expression],
        known: tuple[Expression, Expression],
        direct: Function | None = None,
    ) -> Expression:
        """Record a function that is evaluated only where its result is not known without it.

        Args:
            name: name of the function.
            function: (inputs) -> result, a column.
            inputs: expressions of its arguments.
            known: the result where it is known (k, 1), and 1 there, else 0.
            direct: (inputs) -> what the result mostly is, and 1 where it is: expressions, which are tried first. The
                known result where there is one.

        Returns:
            The symbol of the result.
        """
        k = len(self.calls)
        symbols = [symbol(f"f{k}", function.size1_out(0)), *([symbol(f"direct{k}", 1)] if direct else [])]
        self.calls.append(RecordedFunction(name, function, list(inputs), known, symbols, direct))
        return symbols[0]

    def solve(self, qp: QuadraticProgram) -> QPSolution:
        """Record a QP and return its solution, as symbols.

        Args:
            qp: the quadratic program.
        """
        k = len(self.calls)
        solution = _symbols(qp, str(k))
        self.calls.append(RecordedQP(qp, solution, symbol(f"good{k}", 1)))
        return solution

    def solutions(self) -> list[tuple[QuadraticProgram, QPSolution]]:
        """The QPs so far, with their solutions."""
        return [(each.qp, each.solution) for each in self.calls if isinstance(each, RecordedQP)]

    def prepare(
        self,
        needed: Expression,
        qp: QuadraticProgram,
        results: Callable[[QPSolution], Sequence[Expression]],
    ) -> list[Expression]:
        """Record a QP that is solved before the step, where it is needed.

        The results are not checked: the step must be valid without them. Where the QP is not needed, nothing of it is
        evaluated.

        Args:
            needed: 1 where the QP is needed, else 0.
            qp: the QP; it depends on the local model only.
            results: columns made of the QP's solution.

        Returns:
            Symbols of the results; zeros where the QP is not needed.
        """
        name = f"prepared{len(self.preparations)}"
        solution = _symbols(qp, name)
        made = list(results(solution))
        symbols = [symbol(f"{name}_{i}", each.shape[0]) for i, each in enumerate(made)]
        self.preparations.append(Preparation(needed, solution, made, symbols))
        return symbols

    def symbols(self) -> list[Expression]:
        """The symbols of all results so far."""
        return [result for each in (*self.preparations, *self.calls) for result in each.result_symbols]

    def solved(self) -> Expression:
        """1 where all QPs and computations so far have valid results, else 0."""
        good: Expression = 1
        for recorded in self.calls:
            good = logic_and(good, recorded.solved())
        return good


def _symbols(qp: QuadraticProgram, name: str) -> QPSolution:
    """The solution of a QP as symbols."""
    n, rows = qp.size, qp.row_count
    return QPSolution(symbol(f"x{name}", n), symbol(f"y{name}", rows), symbol(f"z{name}", n), qp)

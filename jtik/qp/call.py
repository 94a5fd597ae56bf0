"""Calls between the functions of a step: a QP for the back end, or a computation in Python."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from jtik.errors import ArgumentError
from jtik.qp.backend import CalledBackend, FusedBackend, NumericQP
from jtik.qp.elastic import SlackExpansion
from jtik.qp.quadratic_program import QuadraticProgram, bounds_valid, is_solution
from jtik.qp.recorder import Compute
from jtik.qp.refinement import refinement
from jtik.qp.solution import QPSolution
from jtik.symbolic import MX, Expression, Function, either, function, is_finite, logic_and, symbol
from jtik.symbolic.compile import bind
from jtik.types import Array


@dataclass(frozen=True)
class QPCall:
    """A QP of fixed size that the back end solves.

    Attributes:
        name: name of the QP.
        n: number of variables, without slacks.
        rows: number of rows.
        expansion: how slack variables are added for elastic rows; None without elastic rows.
        refinement: what corrects solutions so that exact rows hold to rounding; None without exact rows.
        check: (the QP's data, solution) -> whether it is one; None for a QP whose solution is not checked.
        has_many_rows: whether its rows are checked by loops over numbers, and only after its data is evaluated.
        tries_minimiser: whether what is known without solver is its minimiser without rows.
    """

    name: str
    n: int
    rows: int
    expansion: SlackExpansion | None = None
    refinement: Function = None
    check: Function = None
    has_many_rows: bool = False
    tries_minimiser: bool = False

    @classmethod
    def of(cls, qp: QuadraticProgram, accuracy: float | None = None) -> QPCall:
        """The call for QPs of the size of ``qp``, whose solutions are checked to ``accuracy`` if that is given."""
        exact, start = list[int](), 0
        for group in qp.rows:
            exact += range(start, start + group.count) if group.exact else ()
            start += group.count
        refine = refinement(qp.size, qp.row_count, exact) if exact else None
        check = None if accuracy is None else _check(qp, accuracy)
        kind = qp.has_many_rows, qp.tries_minimiser
        return cls(qp.name, qp.size, qp.row_count, qp.expansion, refine, check, *kind)

    @property
    def functions(self) -> list[Function]:
        """Its functions."""
        return [each for each in (self.refinement, self.check) if each]

    def compiled(self, to_c: Callable[[Function], Function]) -> QPCall:
        """The same with generated C."""
        refine, check = (to_c(each) if each else None for each in (self.refinement, self.check))
        return replace(self, refinement=refine, check=check)

    @property
    def solution_sizes(self) -> list[int]:
        """Lengths of x, row multipliers and box multipliers."""
        return [self.n, self.rows, self.n]

    @property
    def sizes(self) -> list[int]:
        """The same, and the length of whether they are a solution."""
        return [*self.solution_sizes, 1]

    @property
    def expanded_size(self) -> int:
        """Number of variables including slacks."""
        return self.expansion.size if self.expansion else self.n

    def expanded_memory(self, data: Sequence[Array]) -> tuple[list[Array], Callable[[], None] | None]:
        """The memory of the QP with slack variables, and the call that fills it from a stage's outputs.

        Without elastic rows the memory is the stage's own, and the call is None.
        """
        if self.expansion is None:
            return list(data[:7]), None
        expand = self.expansion.function()
        memory = output_memory(expand)
        return memory, bind(expand, list(data[:10]), memory)

    def expanded_qp(self, data: Sequence[Array]) -> NumericQP:
        """The numeric QP with slack variables, from a stage's outputs."""
        memory, expand = self.expanded_memory(data)
        if expand:
            expand()
        return self.numeric_qp(memory)

    def numeric_qp(self, memory: Sequence[Array]) -> NumericQP:
        """The numeric QP on the memory of P, q, C, l, u, lb, ub, column-major as CasADi has them."""
        n, (P, q, C, low, high, lower, upper) = self.expanded_size, memory
        return NumericQP(P.reshape(n, n).T, q, C.reshape(n, self.rows).T, low, high, lower, upper)

    def known(self, x: Expression) -> list[Expression]:
        """The results where x (n, 1) is known without a solver."""
        return [x, *[type(x).zeros(size, 1) for size in self.solution_sizes[1:]], is_finite(x)]

    def solver_function(self, backend: FusedBackend, data: Function) -> Function:
        """(whether a solution without solver is valid, that solution, arguments of ``data``) -> results.

        Neither the data is evaluated nor the solver called where the solution without solver is valid.

        Args:
            backend: the back end.
            data: arguments -> the QP's data, its penalties, and whether they are valid.
        """
        x, arguments = MX.sym("x", self.n), _inputs(data)
        # inlined, where it can be: rows that it passes on unchanged are not copied
        given = data.call(arguments, True, False) if data.is_a("MXFunction") else called(data, arguments)
        is_valid = None if self.has_many_rows else given.pop()
        inside = [MX.sym(f"d{i}", *part.shape) for i, part in enumerate(given)]
        solution = self.solution(inside, backend)
        solved = function("valid", inside, [*solution, self.check(*inside, *solution)], cse=False)
        none = [np.nan * MX.ones(size, 1) for size in self.solution_sizes]
        checked = either(solved, function("invalid", inside, [*none, MX(0)]))
        if self.has_many_rows and self.tries_minimiser:
            return self._of_many(checked, given, x, arguments)
        known = function("fast_path", [x, *arguments], self.known(x))
        is_valid = _is_valid(given) if is_valid is None else is_valid
        solver = function("qp_path", [x, *arguments], called(checked, [is_valid, *given]), cse=False)
        return either(known, solver)

    def _of_many(self, checked: Function, given: Sequence[MX], x: MX, arguments: Sequence[MX]) -> Function:
        """The same where x is the minimiser without rows, which are many: whether it satisfies them are loops."""
        inside = [MX.sym(f"d{i}", *part.shape) for i, part in enumerate(given)]
        known = function("known", [x, *inside], self.known(x))
        solver = function("not_known", [x, *inside], called(checked, [_is_valid(inside), *inside]), cse=False)
        solves = MX.sym("solves")
        is_known = logic_and(solves, is_solution(x, given[:7]))
        results = called(either(known, solver), [is_known, x, *given])
        return function("many_rows", [solves, x, *arguments], results, cse=False)

    def solution(self, given: Sequence[Expression], backend: FusedBackend) -> list[Expression]:
        """Expressions of x, row multipliers and box multipliers, by a fused back end, for a QP's data."""
        expanded = called(self.expansion.function(), given) if self.expansion else given
        solution = called(backend.function(self.expanded_size, self.rows), expanded)
        if self.expansion:  # the slacks are the last entries; they follow from x
            solution = [solution[0][: self.n], solution[1], solution[2][: self.n]]
        if self.refinement:
            x, rows, box = solution
            solution = [*called(self.refinement, [*given[2:7], x, box, backend.accuracy]), rows, box]
        return solution

    def bound_solver(self, backend: CalledBackend, data: list[Array], solution: list[Array]) -> Callable[[], None]:
        """A call that solves the QP of a stage's outputs by a called back end.

        Args:
            backend: the back end.
            data: the QP's data, filled in and without slacks.
            solution: memory of x, row multipliers and box multipliers, and of whether they are a solution where that
                is checked.
        """
        memory, expand = self.expanded_memory(data)
        calls: list[Callable[[], None]] = [expand] if expand else []
        x, rows, box = solution[:3]
        found = np.zeros(self.n) if self.refinement else x
        calls.append(BoundSolver(backend, self.numeric_qp(memory), [found, rows, box]))
        if self.refinement:
            calls.append(bind(self.refinement, [*data[2:7], found, box, np.full(1, backend.accuracy)], [x]))
        if self.check:
            calls.append(bind(self.check, [*data[: self.check.n_in() - 3], x, rows, box], [solution[3]]))
        return in_turn(calls)


@dataclass(frozen=True)
class FunctionCall:
    """A function that is evaluated only where its result is not known without it.

    Attributes:
        name: name of the function.
        function: (inputs) -> result, a column.
        direct: (inputs) -> what the result mostly is, and 1 where it is; None without one.
    """

    name: str
    function: Function
    direct: Function | None = None

    @property
    def sizes(self) -> list[int]:
        """The length of the result, and of whether the direct one was taken."""
        return [self.function.numel_out(0), *([1] if self.direct else [])]

    def known(self, x: Expression) -> list[Expression]:
        """The results where the result x (k, 1) is known without an evaluation."""
        return [x, *([type(x)(0)] if self.direct else [])]

    @cached_property
    def complete(self) -> Function:
        """(inputs) -> the direct result where it is the result, else that of the function; whether it is."""
        if self.direct is None:
            return self.function
        given, x = _inputs(self.direct), MX.sym("x", self.function.numel_out(0))
        skip = function("skip", [x, *given], [x])
        evaluate = function("evaluate", [x, *given], called(self.function, given))
        result, found = called(self.direct, given)
        return function(self.name, given, [*called(either(skip, evaluate), [found, result, *given]), found])

    def solver_function(self, data: Function) -> Function:
        """(whether the result is known, the known one, arguments of ``data``) -> results.

        Args:
            data: arguments -> the inputs.
        """
        known, arguments = MX.sym("known", self.function.numel_out(0)), _inputs(data)
        skip = function("skip", [known, *arguments], self.known(known))
        evaluate = function("evaluate", [known, *arguments], called(self.complete, called(data, arguments)))
        return either(skip, evaluate)


@dataclass(frozen=True)
class PythonCall:
    """A computation in Python.

    Attributes:
        name: name of the computation.
        compute: the Python function.
        sizes: lengths of its results.
    """

    name: str
    compute: Compute
    sizes: list[int]


class BoundSolver:
    """A QP solver bound to the memory of its QP and of its solution, which is NaN if there is none."""

    def __init__(self, backend: CalledBackend, qp: NumericQP, solution: list[Array]) -> None:
        self._solver = backend.solver(len(qp.q), len(qp.low))
        self._qp, self._results = qp, solution

    def __call__(self) -> None:
        """Solve the QP that is in memory."""
        solution = self._solver.solve(self._qp) if self._qp.valid else None
        if solution is None:
            for memory in self._results:
                memory[:] = np.nan
            return
        for memory, values in zip(self._results, solution, strict=True):
            memory[:] = values[: len(memory)]  # the slacks are the last entries


class BoundComputation:
    """A Python function bound to the memory of its arguments and of its results, which are NaN if there are none."""

    def __init__(self, compute: Compute, data: list[Array], results: list[Array]) -> None:
        self._compute, self._data, self._results = compute, data, results

    def __call__(self) -> None:
        """Compute from the arguments that are in memory."""
        found = self._compute(self._data)
        if found is not None and len(found) != len(self._results):
            raise ArgumentError("computation", f"{len(found)} results", f"{len(self._results)} results, one a shape")
        for i, memory in enumerate(self._results):
            values = np.nan if found is None else np.asarray(found[i], dtype=float).ravel(order="F")
            if found is not None and np.shape(values) != memory.shape:
                raise ArgumentError(f"result {i} of a computation", f"{np.size(values)} numbers", f"{len(memory)}")
            memory[:] = values


def _is_valid(data: Sequence[MX]) -> MX:
    """Whether the data of a QP is valid, as loops."""
    return logic_and(is_finite(data[0]), bounds_valid(*data[1:7]))


def _inputs(of: Function) -> list[MX]:
    """Symbols of the inputs of a function."""
    return [MX.sym(f"a{i}", *of.size_in(i)) for i in range(of.n_in())]


def _check(qp: QuadraticProgram, accuracy: float) -> Function:
    """(the QP's data, its penalties, x, row multipliers, box multipliers) -> whether they are its solution."""
    made = MX.sym if qp.has_many_rows else symbol
    data = [made(f"d{i}", *part.shape) for i, part in enumerate([*qp.data(), *qp.penalties])]
    x, rows, box = solution = [made(f"s{i}", size) for i, size in enumerate((qp.size, qp.row_count, qp.size))]
    found = QPSolution(x, rows, box, qp.with_data(data))
    return function("jtik_check", [*data, *solution], [found.solved(accuracy)])


def in_turn(calls: Sequence[Callable[[], None]]) -> Callable[[], None]:
    """One call that makes these in turn."""
    if len(calls) == 1:
        return calls[0]

    def all_of_them() -> None:
        for call in calls:
            call()

    return all_of_them


def called(inner: Function, arguments: Sequence[Expression]) -> list[Expression]:
    """The outputs of a function called on expressions, always as a list."""
    outputs = inner(*arguments)
    return list(outputs) if isinstance(outputs, (tuple, list)) else [outputs]


def evaluated(of: Function, arguments: list[Array]) -> list[Array]:
    """The outputs of a function on numbers, flat and column-major."""
    results = output_memory(of)
    bind(of, arguments, results)()
    return results


def output_memory(of: Function) -> list[Array]:
    """Zeros to hold the outputs of a function, flat."""
    return [np.zeros(of.numel_out(i)) for i in range(of.n_out())]

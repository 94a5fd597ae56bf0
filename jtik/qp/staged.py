"""A step with solvers in it: expressions up to a program, its answer, expressions up to the next, to the end.

The expressions are functions of SX, generated and fast; a fused back end joins them with its calls into one function of
MX, any other is called between them from here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from jtik.compile import bind, to_c
from jtik.errors import UnknownNameError
from jtik.qp.backend import Backend, Numbers
from jtik.qp.conic import Conic
from jtik.qp.partition import partitioned
from jtik.qp.program import Computation, Compute, Recorded, Recorder
from jtik.symbolic import MX, Expression, Function, either, function

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ProgramCall:
    """A program of ``n`` variables and ``rows`` rows, for the back end."""

    name: str
    n: int
    rows: int

    @property
    def sizes(self) -> list[int]:
        """Of x, row multipliers and box multipliers."""
        return [self.n, self.rows, self.n]

    def numbers(self, data: Sequence[Array]) -> Numbers:
        """A stage's outputs, columns first as CasADi has them, as a program."""
        P, q, C, low, high, lower, upper = data[:7]
        return Numbers(P.reshape(self.n, self.n).T, q, C.reshape(self.n, self.rows).T, low, high, lower, upper)

    def solved_by(self, backend: Backend) -> Function:
        """(the program's data, the answer of its shortcut and whether that holds) -> answer, by a fused back end.

        The solver is not called where the shortcut holds.
        """
        data = [MX.sym(f"d{i}", *size) for i, size in enumerate(self.data_sizes)]
        x = data[7]
        near = function("near", data[:8], [x, MX(self.rows, 1), MX(self.n, 1)])
        solver = function("far", data[:8], _call(backend.function(self.n, self.rows), data[:7]))
        return function("solved", data, _call(either(near, solver), [data[8], *data[:8]]))

    @property
    def data_sizes(self) -> list[tuple[int, int]]:
        """Of P, q, C, l, u, lb, ub, and of the shortcut's answer and whether it holds."""
        n, k = self.n, self.rows
        return [(n, n), (n, 1), (k, n), (k, 1), (k, 1), (n, 1), (n, 1), (n, 1), (1, 1)]


@dataclass(frozen=True)
class PythonCall:
    """A computation in Python whose answers have these sizes."""

    name: str
    compute: Compute
    sizes: list[int]


Call: TypeAlias = ProgramCall | PythonCall
"""What happens between two stages."""


@dataclass(frozen=True)
class Staged:
    """A step that a solver, or Python, takes part in.

    Attributes: local, inputs -> local model; stages, (inputs, local model, and what each stage before handed on and was
    answered) -> what a call is given, and what is handed on, the last -> the step's outputs; the calls between them;
    what solves programs.
    """

    local: Function
    stages: tuple[Function, ...]
    calls: tuple[Call, ...]
    backend: Backend

    @property
    def fusible(self) -> bool:
        """Whether nothing in it needs Python."""
        return self.backend.fused and all(isinstance(call, ProgramCall) for call in self.calls)

    def compiled(self) -> Staged:
        """The same with every expression as generated C; the solver stays as it is."""
        return replace(self, local=to_c(self.local), stages=tuple(to_c(stage) for stage in self.stages))

    def joined(self) -> Function:
        """One function of MX with the calls of a fused back end inside."""
        inputs = [MX.sym(f"i{k}", *self.local.size_in(k)) for k in range(self.local.n_in())]
        known = [*inputs, *_call(self.local, inputs)]
        for stage, call in zip(self.stages, self.calls, strict=False):
            assert isinstance(call, ProgramCall)
            *data, handed = _call(stage, known)
            known += [handed, *_call(call.solved_by(self.backend), data)]
        return function("jtik_step", inputs, _call(self.stages[-1], known))

    def program(self, name: str | None, arguments: list[Array]) -> Numbers:
        """The numbers of the program called ``name``, or of the first; those before it are solved on the way.

        Raises:
            UnknownNameError: when there is no such program.
        """
        names = [call.name for call in self.calls if isinstance(call, ProgramCall)]
        if not names or (name is not None and name not in names):
            raise UnknownNameError("program", name or "first", names)
        wanted = name or names[0]
        known = [*arguments, *_evaluated(self.local, arguments)]
        for stage, call in zip(self.stages, self.calls, strict=False):
            *data, handed = _evaluated(stage, known)
            if isinstance(call, PythonCall):
                answer = [np.zeros(size) for size in call.sizes]
                _Computing(call.compute, data, answer)()
            elif call.name == wanted:
                return call.numbers(data)
            else:
                answer = _evaluated(call.solved_by(Conic()), data)
            known += [handed, *answer]
        raise AssertionError(wanted)

    def bind(self, arguments: list[Array], results: list[Array]) -> Callable[[], None]:
        """As `jtik.compile.bind`: a call without arguments on memory bound once."""
        local = _outputs(self.local)
        calls: list[Callable[[], None]] = [bind(self.local, arguments, local)]
        known = [*arguments, *local]
        for stage, call in zip(self.stages, self.calls, strict=False):
            *data, handed = outputs = _outputs(stage)
            calls.append(bind(stage, known, outputs))
            answer = [np.zeros(size) for size in call.sizes]
            if isinstance(call, PythonCall):
                calls.append(_Computing(call.compute, data, answer))
            elif self.backend.fused:
                calls.append(bind(call.solved_by(self.backend), data, answer))
            else:
                calls.append(_Answering(self.backend, call.numbers(data), answer))
            known = [*known, handed, *answer]
        calls.append(bind(self.stages[-1], known, results))

        def step() -> None:
            for call in calls:
                call()

        return step


class _Answering:
    """A solver with the memory of its program and of its answer; NaN is the answer where there is none."""

    def __init__(self, backend: Backend, program: Numbers, answer: list[Array]) -> None:
        self._solver = backend.solver(len(program.q), len(program.low))
        self._program, self._answer = program, answer

    def __call__(self) -> None:
        solution = self._solver.solve(self._program)
        if solution is None:
            for memory in self._answer:
                memory[:] = np.nan
            return
        for memory, values in zip(self._answer, solution, strict=True):
            memory[:] = values


class _Computing:
    """Python with the memory of its arguments and of its answer; NaN is the answer where there is none."""

    def __init__(self, compute: Compute, data: list[Array], answer: list[Array]) -> None:
        self._compute, self._data, self._answer = compute, data, answer

    def __call__(self) -> None:
        found = self._compute(self._data)
        for i, memory in enumerate(self._answer):
            memory[:] = np.nan if found is None else np.asarray(found[i], dtype=float).ravel(order="F")


def staged(
    inputs: Sequence[Expression],
    local: Sequence[Expression],
    cut: Sequence[Expression],
    programs: Recorder,
    outputs: Sequence[Expression],
    backend: Backend,
) -> Staged:
    """The step from ``inputs`` to ``outputs``, which are written in ``cut`` for the local model and in the answers."""
    model = function("jtik_local", inputs, local)
    known: list[Sequence[Expression]] = [[*inputs, *cut]]
    calls: list[Call] = []
    for recorded in programs.programs:
        if isinstance(recorded, Computation):
            sizes = [int(answer.numel()) for answer in recorded.answers]
            calls.append(PythonCall(recorded.name, recorded.compute, sizes))
        else:
            calls.append(ProgramCall(recorded.name, recorded.program.size, recorded.program.row_count))
        known.append(recorded.answers)
    names = [*[f"jtik_program{k}" for k in range(len(calls))], "jtik_end"]
    stages = partitioned(names, known, [*[_given(each) for each in programs.programs], outputs])
    return Staged(model, tuple(stages), tuple(calls), backend)


def _given(recorded: Recorded | Computation) -> list[Expression]:
    """What a call is given."""
    if isinstance(recorded, Computation):
        return recorded.data()
    return [*recorded.data(), *recorded.program.shortcut()]


def _call(inner: Function, arguments: Sequence[Expression]) -> list[Expression]:
    answer = inner(*arguments)
    return list(answer) if isinstance(answer, (tuple, list)) else [answer]


def _evaluated(of: Function, arguments: list[Array]) -> list[Array]:
    results = _outputs(of)
    bind(of, arguments, results)()
    return results


def _outputs(of: Function) -> list[Array]:
    return [np.zeros(of.numel_out(i)) for i in range(of.n_out())]

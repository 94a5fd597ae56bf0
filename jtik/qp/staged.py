"""A step with solvers in it: expressions up to a program, its answer, expressions up to the next, to the end.

The expressions are functions of SX, generated and fast; a fused back end joins them with its calls into one function of
MX, any other is called between them from here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jtik.compile import bind
from jtik.errors import UnknownNameError
from jtik.qp.backend import Backend, Numbers
from jtik.qp.conic import Conic
from jtik.qp.program import Recorder
from jtik.symbolic import MX, Expression, Function, function

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Staged:
    """A step that a solver outside CasADi takes part in.

    Attributes: local, inputs -> local model; stages, (inputs, local model, answers so far) -> a program's data, and
    the last -> the step's outputs; sizes (n, rows) and names of the programs; what
    solves them.
    """

    local: Function
    stages: tuple[Function, ...]
    sizes: tuple[tuple[int, int], ...]
    names: tuple[str, ...]
    backend: Backend

    def joined(self) -> Function:
        """One function of MX with the calls of a fused back end inside."""
        inputs = [MX.sym(f"i{k}", *self.local.size_in(k)) for k in range(self.local.n_in())]
        known = [*inputs, *_call(self.local, inputs)]
        for stage, (n, rows) in zip(self.stages, self.sizes, strict=False):
            known += _call(self.backend.function(n, rows), _call(stage, known))
        return function("jtik_step", inputs, _call(self.stages[-1], known))

    def program(self, name: str | None, arguments: list[Array]) -> Numbers:
        """The numbers of the program called ``name``, or of the first; those before it are solved on the way.

        Raises:
            UnknownNameError: when there is no such program.
        """
        if name is not None and name not in self.names:
            raise UnknownNameError("program", name, self.names)
        wanted = 0 if name is None else self.names.index(name)
        known = [*arguments, *_evaluated(self.local, arguments)]
        for stage, (n, rows) in zip(self.stages, self.sizes, strict=False):
            P, q, C, low, high, lower, upper = _evaluated(stage, known)
            numbers = Numbers(P.reshape(n, n).T, q, C.reshape(n, rows).T, low, high, lower, upper)
            if stage is self.stages[wanted]:
                return numbers
            known += _evaluated(Conic().function(n, rows), [P, q, C, low, high, lower, upper])
        raise AssertionError(wanted)

    def bind(self, arguments: list[Array], results: list[Array]) -> Callable[[], None]:
        """As `jtik.compile.bind`: a call without arguments on memory bound once."""
        local = _outputs(self.local)
        calls: list[Callable[[], None]] = [bind(self.local, arguments, local)]
        known = [*arguments, *local]
        for stage, (n, rows) in zip(self.stages, self.sizes, strict=False):
            data = _outputs(stage)
            calls.append(bind(stage, known, data))
            P, q, C, low, high, lower, upper = data
            # columns first, as CasADi has them
            numbers = Numbers(P.reshape(n, n).T, q, C.reshape(n, rows).T, low, high, lower, upper)
            answer = [np.zeros(n), np.zeros(rows), np.zeros(n)]
            calls.append(_Answering(self.backend, numbers, answer))
            known = [*known, *answer]
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
    known = [*inputs, *cut]
    stages, sizes, names = [], [], []
    for k, recorded in enumerate(programs.programs):
        program, solution = recorded.program, recorded.solution
        stages.append(function(f"jtik_program{k}", known, program.data()))
        sizes.append((program.size, program.row_count))
        names.append(program.name)
        known = [*known, solution.x, solution.row_multipliers, solution.box_multipliers]
    stages.append(function("jtik_end", known, outputs))
    return Staged(model, tuple(stages), tuple(sizes), tuple(names), backend)


def _call(inner: Function, arguments: Sequence[Expression]) -> list[Expression]:
    answer = inner(*arguments)
    return list(answer) if isinstance(answer, (tuple, list)) else [answer]


def _evaluated(of: Function, arguments: list[Array]) -> list[Array]:
    results = _outputs(of)
    bind(of, arguments, results)()
    return results


def _outputs(of: Function) -> list[Array]:
    return [np.zeros(of.numel_out(i)) for i in range(of.n_out())]

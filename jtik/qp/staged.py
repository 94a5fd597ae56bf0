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
from jtik.qp.backend import Backend, FusedBackend, Numbers
from jtik.qp.call import Answering, Computing, ProgramCall, PythonCall, called, evaluated, outputs_of
from jtik.qp.conic import Conic
from jtik.qp.partition import partitioned
from jtik.qp.prepared import PreparedCall
from jtik.qp.recorder import Computation, Recorded, Recorder
from jtik.symbolic import MX, Expression, Function, function

Array = NDArray[np.float64]


Call: TypeAlias = ProgramCall | PythonCall
"""What happens between two stages."""


@dataclass(frozen=True)
class Staged:
    """A step that a solver, or Python, takes part in.

    Attributes: local, inputs -> local model; stages, (inputs, local model, what was prepared, and what each stage
    before handed on and was answered) -> what a call is given, and what is handed on, the last -> the step's outputs;
    the calls between them; what solves programs; what is prepared from the local model, where it is needed.
    """

    local: Function
    stages: tuple[Function, ...]
    calls: tuple[Call, ...]
    backend: Backend
    preparations: tuple[PreparedCall, ...] = ()

    @property
    def fusible(self) -> bool:
        """Whether nothing in it needs Python."""
        return isinstance(self.backend, FusedBackend) and all(isinstance(call, ProgramCall) for call in self.calls)

    def compiled(self) -> Staged:
        """The same with every expression as generated C; the solver stays as it is."""
        return replace(
            self,
            local=to_c(self.local),
            stages=tuple(to_c(stage) for stage in self.stages),
            preparations=tuple(each.compiled() for each in self.preparations),
        )

    def joined(self) -> Function:
        """One function of MX with the calls of a fused back end inside."""
        assert isinstance(self.backend, FusedBackend)
        inputs = [MX.sym(f"i{k}", *self.local.size_in(k)) for k in range(self.local.n_in())]
        at = [*inputs, *called(self.local, inputs)]
        known = [*at, *[part for each in self.preparations for part in called(each.solved_by(self.backend), at)]]
        for stage, call in zip(self.stages, self.calls, strict=False):
            assert isinstance(call, ProgramCall)
            *data, handed = called(stage, known)
            known += [handed, *called(call.solved_by(self.backend), data)]
        return function("jtik_step", inputs, called(self.stages[-1], known))

    def program(self, name: str | None, arguments: list[Array]) -> Numbers:
        """The numbers of the program called ``name``, or of the first; those before it are solved on the way.

        Raises:
            UnknownNameError: when there is no such program.
        """
        names = [call.name for call in self.calls if isinstance(call, ProgramCall)]
        names += [each.call.name for each in self.preparations]
        if not names or (name is not None and name not in names):
            raise UnknownNameError("program", name or "first", names)
        wanted = name or names[0]
        at = [*arguments, *evaluated(self.local, arguments)]
        for each in self.preparations:
            if each.call.name == wanted:
                return each.call.plain_numbers(evaluated(each.data, at))
        known = [*at, *[part for each in self.preparations for part in evaluated(each.solved_by(Conic()), at)]]
        for stage, call in zip(self.stages, self.calls, strict=False):
            *data, handed = evaluated(stage, known)
            if isinstance(call, PythonCall):
                answer = [np.zeros(size) for size in call.sizes]
                Computing(call.compute, data, answer)()
            elif call.name == wanted:
                return call.plain_numbers(data)
            else:
                answer = evaluated(call.solved_by(Conic()), data)
            known += [handed, *answer]
        raise AssertionError(wanted)

    def bind(self, arguments: list[Array], results: list[Array]) -> Callable[[], None]:
        """As `jtik.compile.bind`: a call without arguments on memory bound once."""
        local = outputs_of(self.local)
        calls: list[Callable[[], None]] = [bind(self.local, arguments, local)]
        at = known = [*arguments, *local]
        for each in self.preparations:
            answer = [np.zeros(size) for size in each.sizes]
            calls.append(each.bind(self.backend, at, answer))
            known = [*known, *answer]
        for stage, call in zip(self.stages, self.calls, strict=False):
            *data, handed = outputs = outputs_of(stage)
            calls.append(bind(stage, known, outputs))
            answer = [np.zeros(size) for size in call.sizes]
            if isinstance(call, PythonCall):
                calls.append(Computing(call.compute, data, answer))
            elif isinstance(self.backend, FusedBackend):
                calls.append(bind(call.solved_by(self.backend), data, answer))
            else:
                memory, expand = call.plain(data)
                calls += [expand] if expand else []
                calls.append(Answering(self.backend, call.numbers(memory), answer))
            known = [*known, handed, *answer]
        calls.append(bind(self.stages[-1], known, results))

        def step() -> None:
            for call in calls:
                call()

        return step


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
    at = [*inputs, *cut]
    known: list[Sequence[Expression]] = [[*at, *[part for each in programs.preparations for part in each.answers]]]
    calls: list[Call] = []
    for recorded in programs.programs:
        if isinstance(recorded, Computation):
            sizes = [int(answer.numel()) for answer in recorded.answers]
            calls.append(PythonCall(recorded.name, recorded.compute, sizes))
        else:
            calls.append(ProgramCall.of(recorded.program))
        known.append(recorded.answers)
    names = [*[f"jtik_program{k}" for k in range(len(calls))], "jtik_end"]
    stages = partitioned(names, known, [*[_given(each) for each in programs.programs], outputs])
    prepared = tuple(PreparedCall.of(each, at) for each in programs.preparations)
    return Staged(model, tuple(stages), tuple(calls), backend, prepared)


def _given(recorded: Recorded | Computation) -> list[Expression]:
    """What a call is given."""
    if isinstance(recorded, Computation):
        return recorded.data()
    return [*recorded.data(), *recorded.program.prices, *recorded.program.shortcut()]

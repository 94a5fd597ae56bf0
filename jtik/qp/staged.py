"""A step with solvers in it: expressions up to a program, its answer, expressions up to the next, to the end.

The expressions are functions of SX, generated and fast; a fused back end joins them with its calls into one function of
MX, any other is called between them from here. Most steps need no solver, because shortcuts hold: with a fused back end
one function is the whole of such a step, and says whether it was one; the stages go on from there where it was not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from jtik.errors import UnknownNameError
from jtik.qp.backend import Backend, FusedBackend, Numbers
from jtik.qp.call import Answering, Computing, PythonCall, QPCall, called, evaluated, outputs_of
from jtik.qp.conic import Conic
from jtik.qp.partition import partitioned
from jtik.qp.prepared import PreparedCall
from jtik.qp.recorder import Computation, QPRecorder, Recorded
from jtik.symbolic import MX, Expression, Function, either, function, logic_and, symbol, zeros
from jtik.symbolic.compile import bind, to_c
from jtik.types import Array

Call: TypeAlias = QPCall | PythonCall
"""What happens between two stages."""


@dataclass(frozen=True)
class Staged:
    """A step that a solver, or Python, takes part in.

    Attributes: local, inputs -> local model; stages, (inputs, local model, what was prepared, and what each stage
    before handed on and was answered) -> what a call is given, and what is handed on, the last -> the step's outputs;
    the calls between them; what solves programs; what is prepared from the local model, where it is needed; near, of a
    step that a fused back end can join and that prepares nothing, inputs -> the outputs if all shortcuts hold; whether
    they do; the local model; what the first stage gives.
    """

    local: Function
    stages: tuple[Function, ...]
    calls: tuple[Call, ...]
    backend: Backend
    preparations: tuple[PreparedCall, ...] = ()
    near: Function | None = None

    @property
    def fusible(self) -> bool:
        """Whether nothing in it needs Python."""
        return isinstance(self.backend, FusedBackend) and all(isinstance(call, QPCall) for call in self.calls)

    def compiled(self) -> Staged:
        """The same with every expression as generated C; the solver stays as it is."""
        near = [self.near] if self.near else []
        with ThreadPoolExecutor() as compilers:
            local, *rest = compilers.map(to_c, [self.local, *near, *self.stages])
        return replace(
            self,
            local=local,
            stages=tuple(rest[len(near) :]),
            preparations=tuple(each.compiled() for each in self.preparations),
            near=rest[0] if near else None,
        )

    def joined(self) -> Function:
        """One function of MX with the calls of a fused back end inside."""
        inputs, ends = _columns(self.local, self.local.n_in()), self.stages[-1].n_out()
        if self.near is None:
            at = [*inputs, *called(self.local, inputs)]
            return function("jtik_step", inputs, self._through([*at, *self._prepared(at)]))
        parts = called(self.near, inputs)
        arguments = [*parts[:ends], *inputs, *parts[ends + 1 :]]
        inside = [MX.sym(f"a{i}", *part.shape) for i, part in enumerate(arguments)]
        near = function("near", inside, inside[:ends])
        far = function("far", inside, called(self.far(), inside[ends:]))
        return function("jtik_step", inputs, called(either(near, far), [parts[ends], *arguments]))

    def far(self) -> Function:
        """(inputs, the local model, what the first stage gives) -> outputs by way of the solver, after ``near``."""
        first, before = self.stages[0], self.local.n_in() + self.local.n_out()
        at, given = _columns(first, before), [MX.sym(f"g{i}", *first.size_out(i)) for i in range(first.n_out())]
        return function("jtik_far", [*at, *given], self._through(at, given))

    def _prepared(self, at: Sequence[MX]) -> list[MX]:
        """The results of the preparations."""
        assert isinstance(self.backend, FusedBackend)
        return [part for each in self.preparations for part in called(each.solved_by(self.backend), at)]

    def _through(self, known: list[MX], given: Sequence[MX] | None = None) -> list[MX]:
        """The step's outputs by stages and calls, from what is known before them, perhaps with what the first gives."""
        assert isinstance(self.backend, FusedBackend)
        for k, call in enumerate(self.calls):
            assert isinstance(call, QPCall)
            *data, handed = called(self.stages[k], known) if k or given is None else given
            known = [*known, handed, *called(call.solved_by(self.backend), data)]
        return called(self.stages[-1], known)

    def program(self, name: str | None, arguments: list[Array]) -> Numbers:
        """The numbers of the program called ``name``, or of the first; those before it are solved on the way.

        Raises:
            UnknownNameError: when there is no such program.
        """
        names = [call.name for call in self.calls if isinstance(call, QPCall)]
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
        """As `jtik.symbolic.compile.bind`: a call without arguments on memory bound once."""
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
    programs: QPRecorder,
    outputs: Sequence[Expression],
    backend: Backend,
    *,
    crowded: bool = False,
) -> Staged:
    """The step from ``inputs`` to ``outputs``, which are written in ``cut`` for the local model and in the answers.

    In a ``crowded`` step shortcuts seldom hold; like one that prepares something it has no function for the case that
    all do.
    """
    model = function("jtik_local", inputs, local)
    at = [*inputs, *cut]
    known: list[Sequence[Expression]] = [[*at, *[part for each in programs.preparations for part in each.answers]]]
    calls: list[Call] = []
    for recorded in programs.programs:
        if isinstance(recorded, Computation):
            sizes = [int(answer.numel()) for answer in recorded.answers]
            calls.append(PythonCall(recorded.name, recorded.compute, sizes))
        else:
            calls.append(QPCall.of(recorded.program))
        known.append(recorded.answers)
    names = [*[f"jtik_program{k}" for k in range(len(calls))], "jtik_end"]
    stages = partitioned(names, known, [*[_given(each) for each in programs.programs], outputs])
    prepared = tuple(PreparedCall.of(each, at) for each in programs.preparations)
    parts = Staged(model, tuple(stages), tuple(calls), backend, prepared)
    return replace(parts, near=_near(parts)) if parts.fusible and not (crowded or prepared) else parts


def _near(parts: Staged) -> Function:
    """The whole step as if no call needed its solver; see `Staged`."""
    inputs = [symbol(f"i{k}", *parts.local.size_in(k)) for k in range(parts.local.n_in())]
    local = called(parts.local, inputs)
    known: list[Expression] = [*inputs, *local]
    first = given = called(parts.stages[0], known)
    holds: Expression = 1
    for stage, call in zip(parts.stages[1:], parts.calls, strict=True):
        *_, x, shortcut, handed = given
        holds = logic_and(holds, shortcut)
        known += [handed, x, *[zeros(size) for size in call.sizes[1:]]]
        given = called(stage, known)
    return function("jtik_near", inputs, [*given, holds, *local, *first])


def _columns(of: Function, count: int) -> list[MX]:
    """Symbols for its first inputs."""
    return [MX.sym(f"i{k}", *of.size_in(k)) for k in range(count)]


def _given(recorded: Recorded | Computation) -> list[Expression]:
    """What a call is given."""
    if isinstance(recorded, Computation):
        return recorded.data()
    return [*recorded.data(), *recorded.program.prices, *recorded.program.shortcut()]

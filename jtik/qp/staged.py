"""A step that contains QPs or Python computations: functions (stages) with calls in between.

The stages are SX functions, fast and available as generated C. A fused back end joins stages and calls into one MX
function; any other back end is called between the stages. Most steps need no solver, because each QP has a closed-form
solution or an unconstrained minimiser that is feasible. With a fused back end such a step is one function, the fast
path, which also reports whether it was valid; where it was not, the QP path continues from the values of the fast path.
A function in a step may have a direct result, expressions that mostly need no QP. The direct path has them in it: it
costs more than the fast path, and is used while steps need them. The data of a QP, and the check of its solution, are
evaluated only where the solver is called.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np

from jtik.arguments import text
from jtik.errors import UnknownNameError
from jtik.qp.backend import Backend, FusedBackend, NumericQP
from jtik.qp.call import (
    BoundComputation,
    FunctionCall,
    PythonCall,
    QPCall,
    called,
    evaluated,
    in_turn,
    output_memory,
)
from jtik.qp.conic import Conic
from jtik.qp.many_rows import PassedRows
from jtik.qp.partition import partitioned
from jtik.qp.preparation import PreparationCall
from jtik.qp.recorder import QPRecorder, RecordedComputation, RecordedFunction, RecordedQP
from jtik.symbolic import MX, Expression, Function, either, function, if_else, logic_and, logic_or, symbol
from jtik.symbolic.compilation.several_files import Compilation
from jtik.symbolic.compile import bind
from jtik.types import Array

StageCall: TypeAlias = QPCall | PythonCall | FunctionCall
"""A call between two stages."""


class BoundStages(NamedTuple):
    """The stages of a step and the calls between them, on memory bound once.

    Attributes:
        begin: the local model and the first stage.
        rest: the first call and what follows it.
        known: for each call that a back end makes in CasADi, whether its result is known without it, and whether a
            direct result was taken instead; None for a call without one.
    """

    begin: list[Callable[[], None]]
    rest: list[Callable[[], None]]
    known: list[tuple[memoryview, memoryview | None]]


@dataclass(frozen=True)
class Staged:
    """A step that contains QPs or Python computations.

    Attributes:
        local: inputs -> local model.
        stages: (inputs, local model, results of the preparations, then for each earlier stage its intermediate values
            and the results of its call) -> whether a result of the stage's call is known without it, that result, and
            the stage's intermediate values; for a Python computation its arguments and the intermediate values;
            the last one -> outputs of the step.
        data: (what the stage of a call takes, its intermediate values) -> the data of the call, evaluated where no
            result is known; of a QP also whether the data is valid.
        calls: the calls between the stages.
        backend: what solves the QPs.
        preparations: QPs that are solved before the step, where they are needed.
        fast_path: inputs -> outputs if no QP needs a solver, whether that is so, the local model, outputs of the first
            stage; None for a step that a called back end solves, that has preparations or computations, or that
            was built without one.
        direct_path: the same with the direct results of its functions, and at the end 1 where none of them was needed;
            None without any, or without a fast path.
    """

    local: Function
    stages: tuple[Function, ...]
    data: tuple[Function, ...]
    calls: tuple[StageCall, ...]
    backend: Backend
    preparations: tuple[PreparationCall, ...] = ()
    fast_path: Function | None = None
    direct_path: Function | None = None

    @property
    def fusible(self) -> bool:
        """Whether the step can be one function: a fused back end, and no computation in Python."""
        return isinstance(self.backend, FusedBackend) and not any(isinstance(call, PythonCall) for call in self.calls)

    def compiled(self, compilation: Compilation) -> Staged:
        """The same as generated C, all but the solver."""
        qps = [call for call in self.calls if isinstance(call, QPCall)]
        fast = [path for path in (self.fast_path, self.direct_path) if path]
        of_qps = [function for call in qps for function in call.functions]
        of_preparations = [function for each in self.preparations for function in each.functions]
        compilation.begin([self.local, *fast, *self.stages, *self.data, *of_qps, *of_preparations])
        to_c = compilation.to_c
        return replace(
            self,
            local=to_c(self.local),
            stages=tuple(map(to_c, self.stages)),
            data=tuple(map(to_c, self.data)),
            calls=tuple(call.compiled(to_c) if isinstance(call, QPCall) else call for call in self.calls),
            preparations=tuple(each.compiled(to_c) for each in self.preparations),
            fast_path=to_c(self.fast_path) if self.fast_path else None,
            direct_path=to_c(self.direct_path) if self.direct_path else None,
        )

    def joined(self) -> Function:
        """The step as one MX function that contains the calls of a fused back end, each of which occurs once."""
        inputs, ends = _columns(self.local, self.local.n_in()), self.stages[-1].n_out()
        if self.fast_path is None:
            at = [*inputs, *called(self.local, inputs)]
            return function("jtik_step", inputs, self._through([*at, *self._prepared(at)]), cse=False)
        parts = called(self.fast_path, inputs)
        arguments = [*parts[:ends], *inputs, *parts[ends + 1 :]]
        inside = [MX.sym(f"a{i}", *part.shape) for i, part in enumerate(arguments)]
        fast = function("fast_path", inside, inside[:ends])
        qp = function("qp_path", inside, called(self.qp_path, inside[ends:]), cse=False)
        return function("jtik_step", inputs, called(either(fast, qp), [parts[ends], *arguments]), cse=False)

    @cached_property
    def qp_path(self) -> Function:
        """(inputs, local model, outputs of the first stage) -> outputs of the step; called after ``fast_path``."""
        first, before = self.stages[0], self.local.n_in() + self.local.n_out()
        at, given = _columns(first, before), [MX.sym(f"g{i}", *first.size_out(i)) for i in range(first.n_out())]
        return function("jtik_qp_path", [*at, *given], self._through(at, given), cse=False)

    def _prepared(self, at: Sequence[MX]) -> list[MX]:
        """Expressions of the results of the preparations."""
        assert isinstance(self.backend, FusedBackend)
        return [part for each in self.preparations for part in called(each.solver_function(self.backend), at)]

    def _through(self, known: list[MX], given: Sequence[MX] | None = None) -> list[MX]:
        """The step's outputs by stages and calls; ``given`` are the outputs of the first stage, if known."""
        assert isinstance(self.backend, FusedBackend)
        for k, call in enumerate(self.calls):
            assert not isinstance(call, PythonCall)
            *without, intermediate = called(self.stages[k], known) if k or given is None else given
            results = called(self._solver_functions[k], [*without, *known, intermediate])
            known = [*known, intermediate, *results]
        return called(self.stages[-1], known)

    @cached_property
    def _solver_functions(self) -> dict[int, Function]:
        """The solver function of each call that is one, by this back end."""
        fused = isinstance(self.backend, FusedBackend)
        kinds = (FunctionCall, QPCall) if fused else (FunctionCall,)
        return {k: self._solver_function(k) for k, call in enumerate(self.calls) if isinstance(call, kinds)}

    def _solver_function(self, k: int, backend: FusedBackend | None = None) -> Function:
        """(what stage k returns but its intermediate values, arguments of ``data[k]``) -> results of call k."""
        call, solver = self.calls[k], backend or self.backend
        if isinstance(call, FunctionCall):
            return call.solver_function(self.data[k])
        assert isinstance(call, QPCall)
        assert isinstance(solver, FusedBackend)
        return call.solver_function(solver, self.data[k])

    def numeric_qp(self, name: str | None, arguments: list[Array]) -> NumericQP:
        """The numeric QP called ``name``, or the first one; the QPs before it are solved by DAQP.

        Args:
            name: name of the QP; None for the first.
            arguments: the step's inputs.

        Raises:
            UnknownNameError: if there is no such QP.
        """
        if name is not None:
            text("qp", name, "the name of a quadratic program, or None for the first")
        names = [call.name for call in self.calls if isinstance(call, QPCall)]
        names += [each.call.name for each in self.preparations]
        if not names or (name is not None and name not in names):
            raise UnknownNameError("quadratic program", name or "first", names)
        wanted = name or names[0]
        at = [*arguments, *evaluated(self.local, arguments)]
        for each in self.preparations:
            if each.call.name == wanted:
                return each.call.expanded_qp(evaluated(each.data, at))
        known = [*at, *[part for each in self.preparations for part in evaluated(each.solver_function(Conic()), at)]]
        for k, call in enumerate(self.calls):
            *without, intermediate = evaluated(self.stages[k], known)
            if isinstance(call, PythonCall):
                call_results = [np.zeros(size) for size in call.sizes]
                BoundComputation(call.compute, without, call_results)()
            elif isinstance(call, QPCall) and call.name == wanted:
                return call.expanded_qp(evaluated(self.data[k], [*known, intermediate]))
            else:
                call_results = evaluated(self._solver_function(k, Conic()), [*without, *known, intermediate])
            known += [intermediate, *call_results]
        raise AssertionError(wanted)

    def bind(self, arguments: list[Array], results: list[Array]) -> Callable[[], None]:
        """The QP path as a call without arguments on memory bound once, as `jtik.symbolic.compile.bind`.

        Args:
            arguments: memory of the step's inputs.
            results: memory of the step's outputs.
        """
        bound = self.bound_stages(arguments, results, output_memory(self.local), output_memory(self.stages[0]))
        return in_turn([*bound.begin, *bound.rest])

    def bound_stages(
        self, arguments: list[Array], results: list[Array], local: list[Array], first: list[Array]
    ) -> BoundStages:
        """The stages and the calls between them, on memory bound once.

        Args:
            arguments: memory of the step's inputs.
            results: memory of the step's outputs.
            local: memory of the local model.
            first: memory of the outputs of the first stage.
        """
        begin: list[Callable[[], None]] = [bind(self.local, arguments, local)]
        at = known = [*arguments, *local]
        for each in self.preparations:
            call_results = [np.zeros(size) for size in each.sizes]
            begin.append(each.bind(self.backend, at, call_results))
            known = [*known, *call_results]
        rest, known_before = list[Callable[[], None]](), list[tuple[memoryview, memoryview | None]]()
        for k, (stage, call) in enumerate(zip(self.stages, self.calls, strict=False)):
            *without, intermediate = outputs = output_memory(stage) if k else first
            (rest if k else begin).append(bind(stage, known, outputs))
            call_results = [np.zeros(size) for size in call.sizes]
            if isinstance(call, PythonCall):
                rest.append(BoundComputation(call.compute, without, call_results))
            elif isinstance(call, FunctionCall) or isinstance(self.backend, FusedBackend):
                rest.append(bind(self._solver_functions[k], [*without, *known, intermediate], call_results))
                direct = isinstance(call, FunctionCall) and call.direct
                known_before.append((memoryview(without[0].data), memoryview(call_results[1].data) if direct else None))
            else:
                data = output_memory(self.data[k])
                rest.append(bind(self.data[k], [*known, intermediate], data))
                rest.append(call.bound_solver(self.backend, data, call_results))
            known = [*known, intermediate, *call_results]
        rest.append(bind(self.stages[-1], known, results))
        return BoundStages(begin, rest, known_before)


def staged(
    inputs: Sequence[Expression],
    local: Sequence[Expression],
    cut: Sequence[Expression],
    recorder: QPRecorder,
    outputs: Sequence[Expression],
    backend: Backend,
    *,
    fast_path: bool = True,
    apart: tuple[Function, Sequence[Expression]] | None = None,
) -> Staged:
    """Divide a step into stages at its QPs and computations.

    Args:
        inputs: symbols of the step's inputs.
        local: expressions of the local model, in ``inputs``.
        cut: symbols of the local model, in which everything else is written.
        recorder: the QPs and computations.
        outputs: expressions of the step's outputs, in ``inputs``, ``cut`` and the symbols of the results.
        backend: what solves the QPs.
        fast_path: whether to build the fast path. Without it a step is smaller; it is of little use where most steps
            need a solver. A step with preparations has none.
        apart: the last ones of ``cut`` as a function, and what it is given, in ``inputs``; None: ``local`` has all.
    """
    model = function("jtik_local", inputs, [*local, *(apart[1] if apart else ())])
    model = _with_parts(model, apart[0]) if apart else model
    at = [*inputs, *cut]
    prepared_symbols = [part for each in recorder.preparations for part in each.result_symbols]
    known: list[Sequence[Expression]] = [[*at, *prepared_symbols]]
    calls: list[StageCall] = []
    for recorded in recorder.calls:
        if isinstance(recorded, RecordedComputation):
            sizes = [int(result.numel()) for result in recorded.result_symbols]
            calls.append(PythonCall(recorded.name, recorded.compute, sizes))
        elif isinstance(recorded, RecordedFunction):
            calls.append(FunctionCall(recorded.name, recorded.function, recorded.direct))
        else:
            calls.append(QPCall.of(recorded.qp, recorder.accuracy))
        known.append(recorded.result_symbols)
    names = [*[f"jtik_stage{k}" for k in range(len(calls))], "jtik_end"]
    passed = [PassedRows.of(each.qp, known[0]) if isinstance(each, RecordedQP) else None for each in recorder.calls]
    pairs = [_call_data(each, rows) for each, rows in zip(recorder.calls, passed, strict=True)]
    wanted, deferred = zip(*pairs, strict=True) if calls else ((), ())
    stages, data = partitioned(names, known, [*wanted, outputs], deferred)
    data = [rows.whole(made) if rows else made for rows, made in zip(passed, data, strict=True)]
    prepared = tuple(PreparationCall.of(each, at) for each in recorder.preparations)
    parts = Staged(model, tuple(stages), tuple(data), tuple(calls), backend, prepared)
    fast_path = fast_path and all(qp.has_fast_path for qp, _ in recorder.solutions())
    if not fast_path or not parts.fusible or prepared:
        return parts
    direct = any(isinstance(call, FunctionCall) and call.direct for call in calls)
    return replace(parts, fast_path=_fast_path(parts), direct_path=_fast_path(parts, direct=True) if direct else None)


def _with_parts(model: Function, apart: Function) -> Function:
    """The local model with the parts that are a function of their own, of the last outputs of ``model``."""
    inputs, count = _columns(model, model.n_in()), apart.n_in()
    outputs = called(model, inputs)
    outputs[-count:] = apart.call(outputs[-count:], True, False)
    return function("jtik_local_model", inputs, outputs, cse=False)


def _fast_path(parts: Staged, *, direct: bool = False) -> Function:
    """The step without a solver, with or without direct results; see `Staged`."""
    inputs = [symbol(f"i{k}", *parts.local.size_in(k)) for k in range(parts.local.n_in())]
    local = called(parts.local, inputs)
    known: list[Expression] = [*inputs, *local]
    first = given = called(parts.stages[0], known)
    valid = unneeded = type(inputs[0])(1)
    for k, (stage, call) in enumerate(zip(parts.stages[1:], parts.calls, strict=True)):
        valid_here, x, intermediate = given
        unneeded = logic_and(unneeded, valid_here)
        if direct and isinstance(call, FunctionCall) and call.direct:
            result, found = called(call.direct, called(parts.data[k], [*known, intermediate]))
            x, valid_here = if_else(valid_here, x, result), logic_or(valid_here, found)
            first = first if k else [valid_here, x, intermediate]
        valid = logic_and(valid, valid_here)
        known += [intermediate, *([x] if isinstance(call, PythonCall) else call.known(x))]
        given = called(stage, known)
    if not direct:
        return function("jtik_fast_path", inputs, [*given, valid, *local, *first])
    # its expressions were written once: to look for common ones takes long
    return function("jtik_direct_path", inputs, [*given, valid, *local, *first, unneeded], cse=False)


def _columns(of: Function, count: int) -> list[MX]:
    """Symbols of the first ``count`` inputs of a function."""
    return [MX.sym(f"i{k}", *of.size_in(k)) for k in range(count)]


def _call_data(
    recorded: RecordedQP | RecordedComputation | RecordedFunction, passed: PassedRows | None
) -> tuple[list[Expression], list[Expression]]:
    """What a stage returns for a call, and the data of the call, which is evaluated where it is needed."""
    if isinstance(recorded, RecordedFunction):
        return list(reversed(recorded.known)), recorded.data()
    if isinstance(recorded, RecordedComputation):
        return recorded.data(), []
    qp = recorded.qp
    data = passed.left(qp) if passed else [*qp.data(), *qp.penalties, qp.valid]
    return list(reversed(qp.solution_without_solver())), data

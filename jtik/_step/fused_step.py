"""One update as one CasADi function: (q, inputs, state) -> (q', state', outcome, record).

Kinematics, error, Jacobian, criterion, gradient, the strategy's update, joint limits, acceptance and the stop code are
joined here into a single expression graph, so that a step costs one call and the loop around it is simple in any
language.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

import numpy as np

from jtik._step.braking import initial_braking
from jtik._step.checked_update import CheckedUpdate, check_symbols, checked_update, first_state
from jtik._step.exploration import Exploration, initial_exploration, start_of_step
from jtik._step.inputs import Inputs, Settings
from jtik._step.local_model import linearized
from jtik._step.record import figures_of
from jtik._step.relaxation import RelaxationTerms
from jtik._step.solve_progress import UNKNOWN, Progress, initial_progress
from jtik._step.stagnation import initial_stagnation
from jtik._step.stopping import Code, Stop
from jtik._step.symbolic_problem import SymbolicProblem
from jtik._step.vector_layout import VectorLayout
from jtik.constraints.clearance import LONGEST
from jtik.qp import backend_of
from jtik.qp.backend import Backend, FusedBackend
from jtik.qp.fast_path import StepPath, fast_or_qp_path
from jtik.qp.recorder import QPRecorder
from jtik.qp.staged import Staged, staged
from jtik.strategy import LocalModel, Shape, Strategy
from jtik.strategy.checked_call import CheckedCall
from jtik.symbolic import (
    Expression,
    Function,
    function,
    if_else,
    is_finite,
    logic_and,
    logic_not,
    logic_or,
    symbol,
    vertcat,
)
from jtik.symbolic.compilation.archives import Archive
from jtik.symbolic.compilation.several_files import Compilation
from jtik.symbolic.compile import NOTHING, Beside, Library, bind
from jtik.types import Array

Compiled: TypeAlias = Callable[[Function, Beside, Archive | None], Library]
"""(function, what is compiled with it, static library or None) -> shared library."""

STRATEGY_PREFIX = "strategy."
"""Prefix of the names of the strategy's own state within the state of the step."""


@dataclass(frozen=True)
class FusedStep:
    """One update as a function.

    Attributes:
        function: (q, inputs, state) -> (q', state', outcome, record).
        first_state: the state that a solve starts from.
        state: layout of the state.
        record: layout of the record of figures; empty without one.
        parts: the functions between which quadratic programs are solved; None without any.
        library: the shared library of generated C; None if it was not compiled.
        relaxation: what may be relaxed in the step.
        virtual: the function on the virtual machine, where ``function`` is generated C.
    """

    function: Function | Staged
    first_state: Array
    state: VectorLayout
    record: VectorLayout
    parts: Staged | None = None
    library: Library | None = None
    relaxation: RelaxationTerms = field(default_factory=RelaxationTerms)
    virtual: Function | None = None

    @property
    def expressions(self) -> Function | None:
        """The function as expressions; None where quadratic programs are solved in it."""
        if self.parts is not None or isinstance(self.function, Staged):
            return None
        return self.virtual or self.function

    def bind(self, arguments: list[Array], results: list[Array], expected: list[StepPath]) -> Callable[[], None]:
        """A call without arguments on this memory; ``expected`` as in `jtik.qp.fast_path.fast_or_qp_path`."""
        if isinstance(self.function, Staged):
            return self.function.bind(arguments, results)
        if self.parts:
            return fast_or_qp_path(self.function, self.parts, Code.UNSOLVED, arguments, results, expected)
        return bind(self.function, arguments, results)

    @property
    def archive(self) -> Archive | None:
        """The static library of the solver of its quadratic programs, where it can be one function in generated C."""
        backend = self.parts.backend if self.parts and self.parts.fusible else None
        return backend.archive if isinstance(backend, FusedBackend) else None

    @property
    def is_one_function(self) -> bool:
        """Whether it is one function in generated C."""
        return self.parts is None or self.archive is not None

    def compiled(self, compilation: Compilation, beside: Beside = NOTHING) -> FusedStep:
        """The same in generated C: one function, with the QP solver where its back end has a static library.

        A step that calls Python, or another solver, is several functions in C with these calls in between.

        Args:
            compilation: compiles it.
            beside: what is compiled with it, where it is one function.

        Raises:
            CompilerError: without a compiler.
        """
        if self.parts is None or self.is_one_function:
            return self.one_library(compilation.library, beside)
        parts = self.parts.compiled(compilation)
        return replace(self, function=parts.joined() if parts.fusible else parts, parts=parts)

    def one_library(
        self, compiled: Compiled, beside: Beside = NOTHING, using_casadi: AbstractContextManager[Any] | None = None
    ) -> FusedStep:
        """The same as one function in generated C, which it can be.

        Args:
            compiled: makes the library.
            beside: what is compiled with it.
            using_casadi: is entered while CasADi is used here.
        """
        # in C a step whose QPs need no solver costs no more within the whole: there is no separate fast path
        whole = replace(self.parts, fast_path=None) if self.parts else None
        with using_casadi or nullcontext():
            step = whole.joined() if whole else self.function
        built = compiled(step, beside, self.archive)
        return replace(self, function=built.function, parts=whole, library=built, virtual=None if whole else step)


def fused_step(
    problem: SymbolicProblem,
    strategy: Strategy,
    *,
    backend: Backend | None = None,
    recorded: bool = False,
    evaluated: bool = False,
    timed: bool = False,
    explores: bool = False,
    acceleration: Array | None = None,
    replaceable: bool = False,
    rests: bool = True,
) -> FusedStep:
    """Join problem and strategy into one function, or into those between which quadratic programs are solved.

    Args:
        problem: the problem to solve.
        strategy: the strategy that updates q.
        backend: solves the quadratic programs of a strategy that has any.
        recorded: whether its outputs have the figures of a trace.
        evaluated: whether task and criterion are always evaluated where the step ends, so that the outcome has the
            errors there. Otherwise a step of a strategy that accepts every step has the errors of its start.
        timed: whether the step has a duration: it is then fitted into its box, damped where the last step has left an
            error, and takes a share of the null-space displacement.
        explores: whether it explores where V has stopped falling, for a strategy that does; see `can_explore`.
        acceleration: limits of acceleration of a timed step (n,), which then brakes towards its target; None without
            any.
        replaceable: whether a restart replaces an attempt that does not soon reach the target. Then the step has a
            cheaper model, and an attempt ends on the target, without progress, or where V is not finite.
        rests: whether it is damped where a strategy damps stagnation, as `step` without a time asks by its settings.

    Raises:
        StrategyError: when a method of the strategy raises or returns what cannot be used.
    """
    evaluates = CheckedCall(strategy, strategy, "evaluates_candidate").flag(problem.has_criterion)
    evaluated = evaluated or evaluates or bool(problem.clearances) or timed
    evaluated = evaluated or explores
    rests = rests and not (timed or replaceable) and CheckedCall(strategy, strategy, "damps_stagnation").flag()
    first = _first_state(problem, strategy, evaluated=evaluated, timed=timed, explores=explores)
    if acceleration is not None:
        first = VectorLayout.united(first, initial_braking(problem))
    if rests:
        first = VectorLayout.united(first, initial_stagnation())
    layout = VectorLayout.of({name: value.size for name, value in first.items()})
    inputs, q, memory = _input_symbols(problem), symbol("q", problem.robot.nq), symbol("state", layout.size)
    state, settings = layout.split(memory), Settings.of(inputs.settings)
    uses_qp = backend is not None
    if backend is None and timed and problem.bounded and CheckedCall(strategy, strategy, "fits_limits").flag():
        backend = backend_of(None)
    qps = QPRecorder(backend.accuracy, backend.name) if backend else None

    by_level = CheckedCall(strategy, strategy, "respects_priority").flag()
    start = start_of_step(state, q)
    flags = {"uses_qp": uses_qp, "timed": timed, "by_level": by_level, "explores": explores}
    flags |= {"replaceable": replaceable, "rests": rests}
    at = linearized(problem, start, inputs, state, qps, acceleration=acceleration, **flags)
    model, active = at.model, at.active_set
    exploration = Exploration.of(model, state, q) if explores else None
    if exploration:
        model = replace(model, exploring=exploration.active)
    own = {name[len(STRATEGY_PREFIX) :]: v for name, v in state.items() if name.startswith(STRATEGY_PREFIX)}
    update = checked_update(strategy, model, own)
    check_symbols(strategy, update, [q, *inputs, memory, *at.at, *(qps.symbols() if qps else ())], qps)
    restoration = model.restoration if model.clearance and model.clearance.restores else None
    compromise = None if timed else update.compromise_residual  # a timed step follows its target all the same
    residual = update.stationarity_residual
    stop = Stop(
        problem, model, settings, active, residual, restoration, compromise, at.gradient_finite, replaceable=replaceable
    )
    progress = Progress.of(model, state, stop, active)

    finite = is_finite(model.here.V_to_target) if replaceable else _finite(model, q)
    if problem.has_criterion:  # on the target only the criterion is left
        finite = logic_and(finite, logic_or(at.gradient_finite, logic_not(stop.reached_before)))
    stops = logic_or(stop.stationary, progress.slow)
    if stop.compromise is not None:
        stops = logic_or(stops, stop.compromise)
    if not timed:  # a timed step follows its target within the tolerances, too
        stops = logic_or(stops, stop.done_before)
    tried = logic_and(finite, logic_not(stops))
    if qps:
        tried = logic_and(tried, qps.solved())
    accepted = logic_and(tried, update.accepted)
    done, V, errors = stop.done_before, model.here.V_to_target, stop.errors_before
    if evaluated:
        accepted = logic_and(accepted, is_finite(update.candidate.V_to_target + update.candidate.H))
    moved, errors_before = accepted, errors
    if exploration:
        accepted, V = exploration.lands(moved, update.candidate), exploration.V
        errors = errors_before = exploration.errors(errors)
    if evaluated:
        done = logic_or(done, logic_and(accepted, stop.done_after(update.candidate)))
        if timed:  # which is taken on the target, too, and may leave it
            done = logic_and(done, logic_or(logic_not(accepted), stop.reached_after(update.candidate)))
        figures_after = [*stop.errors(update.candidate), update.candidate.V_to_target]
        pairs = zip(figures_after, [*errors, V], strict=True)
        *errors, V = [if_else(accepted, after, before) for after, before in pairs]  # type: ignore[assignment]

    after, stalled = progress.after(model, state, update, accepted, stop, restoration, evaluated=evaluated)
    if replaceable:
        after |= {name: state[name] for name in ("refused", "stagnant")}
        stalled = 0
    after["neighbourhood"] = model.neighbourhood
    if timed:
        after["remaining"] = if_else(accepted, update.candidate.length, model.here.length)
        if acceleration is not None:
            after["left"] = if_else(accepted, update.candidate.to_target, model.here.to_target)
            after["momentum"] = state["momentum"]
        if problem.has_criterion:
            after["null_space_left"] = if_else(accepted, settings.null_space_again, state["null_space_left"])
    if at.stagnation:
        after |= at.stagnation.after(update.candidate, accepted)
    if restoration:
        after |= restoration.after(update.dq, accepted)
    if active and evaluated:
        after["active"] = active.after(model, update.wanted, update.candidate.q, accepted)
    after |= {f"{STRATEGY_PREFIX}{name}": value for name, value in update.state.items()}
    code = progress.code(done, stalled, stop.compromise)
    if qps:
        code = if_else(qps.solved(), code, Code.UNSOLVED)
    code, ends_at = if_else(finite, code, Code.NOT_FINITE), _next_configuration(model, update, accepted)
    if exploration:
        code, ends_at = exploration.code(code, done), exploration.configuration(model, update.candidate, accepted)
        after = exploration.after(
            after, first, moved=moved, landed=accepted, end=update.candidate, errors=errors_before
        )
    outcome = vertcat(code, tried, accepted, *errors, V)

    outputs = [ends_at, layout.join(after), outcome]
    relaxation = RelaxationTerms.of(update, qps, restoration, problem)
    record = VectorLayout.of({})
    if recorded:
        record, figures = figures_of(model, update, accepted, relaxation)
        if exploration:
            figures["V"], figures["actual_decrease"] = exploration.V, exploration.V - update.candidate.V_to_target
        outputs.append(record.join(figures))
    arguments, numbers = [q, *inputs, memory], np.concatenate(list(first.values()))
    if not (qps and backend):
        return FusedStep(function("jtik_step", arguments, outputs), numbers, layout, record, relaxation=relaxation)
    apart = (at.apart.function, at.apart.given) if at.apart else None
    fast_path = not problem.clearances
    parts = staged(arguments, at.parts, at.at, qps, outputs, backend, fast_path=fast_path, apart=apart)
    joined = parts.joined() if parts.fusible else parts
    return FusedStep(joined, numbers, layout, record, parts, relaxation=relaxation)


def can_explore(problem: SymbolicProblem, strategy: Strategy) -> bool:
    """Whether the strategy explores in a solve of the problem: there is no exploration beside clearances."""
    return not problem.clearances and CheckedCall(strategy, strategy, "explores").flag(problem.has_criterion)


def _first_state(
    problem: SymbolicProblem, strategy: Strategy, *, evaluated: bool, timed: bool, explores: bool
) -> dict[str, Array]:
    """The state that a solve starts from: the engine's, then the strategy's."""
    state = initial_progress(evaluated=evaluated) | {"neighbourhood": np.zeros(1)}
    if timed:
        state["remaining"] = np.zeros(1)
        if problem.has_criterion:
            state["null_space_left"] = np.ones(1)
    if problem.clearances and problem.measured.restored.any():
        state |= {"longest": np.full(1, LONGEST), "violation": np.full(1, UNKNOWN)}
    if problem.bounded and evaluated:
        state["active"] = np.zeros(len(problem.bounded))
    robot = problem.robot
    if explores:
        state = VectorLayout.united(state, initial_exploration(robot.nq))
    shape = Shape(robot.n, robot.nq, problem.m, problem.has_criterion, bool(problem.clearances), timed)
    return state | {f"{STRATEGY_PREFIX}{name}": value for name, value in first_state(strategy, shape).items()}


def _input_symbols(problem: SymbolicProblem) -> Inputs[Expression]:
    """Fresh symbols for the inputs."""
    nq = problem.robot.nq
    _, target, parameters = problem.symbols()
    return Inputs(target, parameters, symbol("lower", nq), symbol("upper", nq), symbol("settings", len(Settings())))


def _finite(model: LocalModel, q: Expression) -> Expression:
    """1 where task and criterion are finite, and the derivative of the task is."""
    finite = logic_and(
        is_finite(model.here.V_to_target + model.here.H), is_finite(model.gradient_norm + model.jacobian_norm)
    )
    # clamping to the limits hides a NaN in q
    return logic_and(finite, is_finite(q)) if model.bounded else finite


def _next_configuration(model: LocalModel, update: CheckedUpdate, accepted: Expression) -> Expression:
    """q': where the step ends if it is accepted, else q."""
    q, robot = model.here.q, model.robot
    if model.bounded or robot.nq != robot.n:
        return if_else(accepted, update.candidate.q, q)
    dq = model.coordinates.to_joints(update.dq)
    return q + vertcat(*[if_else(accepted, dq[i], 0) for i in range(robot.n)])

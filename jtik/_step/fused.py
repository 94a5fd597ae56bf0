"""One update as one CasADi function: (q, target, parameters, box, settings, state) -> (q', state', outcome, record).

Kinematics, error, Jacobian, criterion, gradient, the strategy's law, joint limits, acceptance and the stop code are
joined here into a single expression graph, so that a step costs one call and the loop round it is trivial in any
language.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from jtik._step.active_set import ActiveSet, inside
from jtik._step.inputs import Inputs, Settings
from jtik._step.layout import VectorLayout
from jtik._step.relaxation import RelaxationTerms
from jtik._step.stopping import Code, Stop
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.clearance import ClearanceModel, travels
from jtik.qp.backend import Backend
from jtik.qp.recorder import QPRecorder
from jtik.qp.second import near_or_far
from jtik.qp.staged import Staged, staged
from jtik.strategy import LocalModel, Point, Shape, Strategy, Update
from jtik.strategy.feasibility_restoration import LONGEST
from jtik.symbolic import (
    TINY,
    Expression,
    Function,
    function,
    if_else,
    is_finite,
    logic_and,
    logic_not,
    logic_or,
    mmin,
    sqrt,
    substitute,
    symbol,
    vertcat,
)
from jtik.symbolic.compile import Library, bind, library
from jtik.symbolic.factorization import squared_length
from jtik.types import Array

TUBE = 0.02
"""Size of the tube about the target: the error that a motion of so many rad (or m) can make, |J| times this."""

REFUSALS = 40
"""Refused steps in a row after which the solve has stalled: 2^-40 of the first step is below working precision."""

STAGNANT, STAGNATIONS = 1e-10, 20
"""Relative decrease of V that is no progress, and how many such steps in a row are a stall."""


FALL = 0.8
"""An error below this share of the least so far is progress; ``patience`` counts the calls without any."""

NEVER = 1e300
"""Above every V that has been seen, before one has."""


CYCLING = 200
"""Calls without progress after which a law has stalled that looks at nothing, or that clearances hold."""


@dataclass(frozen=True)
class FusedStep:
    """The function, the state it starts from, the layout of its record, its parts where it has programs, its library
    where it was compiled, and what may give way in it."""

    function: Function | Staged
    first_state: Array
    state: VectorLayout
    record: VectorLayout
    parts: Staged | None = None
    library: Library | None = None
    yielding: RelaxationTerms = field(default_factory=RelaxationTerms)

    def bind(self, arguments: list[Array], results: list[Array]) -> Callable[[], None]:
        """A call without arguments on this memory."""
        if isinstance(self.function, Staged):
            return self.function.bind(arguments, results)
        if self.parts:
            return near_or_far(self.function, self.parts, Code.UNSOLVED, arguments, results)
        return bind(self.function, arguments, results)

    def compiled(self, beside: str = "") -> FusedStep:
        """The same in generated C, all but the solver's calls, with more C beside it where there are none.

        Raises:
            CompilerError: without a compiler.
        """
        if self.parts is None:
            built = library(self.function, beside)
            return replace(self, function=built.function, library=built)
        parts = self.parts.compiled()
        return replace(self, function=parts.joined() if parts.fusible else parts, parts=parts)


def fused_step(
    problem: SymbolicProblem,
    strategy: Strategy,
    *,
    backend: Backend | None = None,
    recorded: bool = False,
    arriving: bool = False,
) -> FusedStep:
    """Join problem and strategy into one function, or into those between which a QP solver answers.

    Args:
        problem: what is to be solved.
        strategy: by which law.
        backend: what solves the programs of a strategy that has any.
        recorded: whether its outputs have the figures of a trace.
        arriving: whether the errors it gives are always those where the step arrives. A strategy that accepts without
            looking there saves the kinematics; the errors then are those before a step that was not the last.
    """
    robot, m, bounded = problem.robot, problem.m, problem.bounded
    arriving = arriving or strategy.evaluates_candidate(problem.has_criterion) or bool(problem.clearances)
    first = {name: np.array(value, dtype=float) for name, value in _engine_state(problem, arriving).items()}
    own = strategy.initial_state(Shape(robot.n, robot.nq, m, problem.has_criterion, bool(problem.clearances)))
    first |= {f"strategy.{name}": np.array(value, dtype=float) for name, value in own.items()}
    layout = VectorLayout.of({name: value.size for name, value in first.items()})

    start, target, parameters = problem.symbols()
    lower, upper, column = symbol("lower", robot.nq), symbol("upper", robot.nq), symbol("settings", len(Settings()))
    given = Inputs(target, parameters, lower, upper, column)
    settings = Settings.of(column)
    memory = symbol("state", layout.size)
    state = layout.split(memory)

    inputs = [start, *given, memory]
    local = _local_model(problem, inside(start, lower, upper, bounded), target, parameters)
    cut, programs = local, QPRecorder(backend.accuracy, backend.name) if backend else None
    if programs:  # the stages between the solver's answers share the local model as numbers
        cut = [symbol(f"at{i}", *part.shape) for i, part in enumerate(local)]
    q, residual, J, H, gradient_H = cut[:5]
    here = Point(q, residual, H)
    tube = near = 0
    if problem.has_criterion:
        tube = if_else(state["tube"] > 0, state["tube"], TUBE * sqrt(squared_length(J) + TINY))
        near = here.length <= tube
    working = None
    if bounded:
        working = ActiveSet(problem, state, here, near, J, gradient_H, lower, upper, programs=bool(programs))
    model = LocalModel(
        robot=robot,
        here=here,
        J=working.masked(J) if working else J,
        gradient=working.masked(gradient_H.T).T if working else gradient_H,
        has_criterion=problem.has_criterion,
        near=near,
        tube=tube,
        lower=lower,
        upper=upper,
        bounded=bounded,
        levels=problem.levels,
        residual_function=problem.residual,
        criterion_function=problem.criterion,
        target=target,
        parameters=parameters,
        full_J=J,
        full_gradient=gradient_H,
        programs=programs,
        tasks=problem.tasks,
        clearance=clearance_model(problem, q, cut[5:], parameters, (lower, upper), state)
        if problem.clearances
        else None,
    )

    update = strategy.update(model, {name[9:]: part for name, part in state.items() if name.startswith("strategy.")})
    room = model.recovery if model.clearance and model.clearance.recovers else None
    stop = Stop(problem, model, settings, working, update.stationarity_residual, room)
    finite = logic_and(is_finite(here.V + here.H), is_finite(model.gradient_length + model.jacobian_length))
    if bounded:  # a NaN that was led back into the box is one all the same
        finite = logic_and(finite, is_finite(start))
    falls = FALL**2 * state["best"] > here.V
    idle = if_else(falls, 0, state["idle"] + 1)
    slow = logic_and(idle >= state["patience"], logic_not(stop.reached_before))
    tried = logic_and(finite, logic_not(logic_or(stop.done_before, logic_or(stop.stationary, slow))))
    if programs:
        tried = logic_and(tried, programs.solved())
    accepted = logic_and(tried, update.accepted)

    after = {"patience": state["patience"], "tube": tube, "best": if_else(falls, here.V, state["best"]), "idle": idle}
    if arriving:
        accepted = logic_and(accepted, is_finite(update.point.V + update.point.H))
        crawls = logic_and(accepted, here.V - update.point.V <= STAGNANT * here.V)
        if update.progress is not None:
            crawls = logic_and(accepted, update.progress <= STAGNANT)
        done = logic_or(stop.done_before, logic_and(accepted, stop.done_after(update.point)))
        arrived = [*stop.errors(update.point), update.point.V]
        before = [*stop.errors_before, here.V]
        figures_after = [if_else(accepted, new, old) for new, old in zip(arrived, before, strict=True)]
    else:
        crawls = logic_and(state["V"] > 0, state["V"] - here.V <= STAGNANT * state["V"])
        done = stop.done_before
        figures_after = [*stop.errors_before, here.V]
        crawls = logic_or(crawls, idle >= CYCLING)
        after["V"] = here.V
    refused = if_else(accepted, 0, state["refused"] + 1)
    if problem.clearances:
        crawls = logic_or(crawls, idle >= CYCLING)
    if room:
        crawls = logic_and(crawls, logic_not(room.takes(update.term, update.point.length)))
        after |= room.after(update.term, accepted)
    stagnant = if_else(logic_and(crawls, logic_not(stop.reached_before)), state["stagnant"] + 1, 0)
    stalled = logic_or(stop.stationary, logic_or(refused >= REFUSALS, stagnant >= STAGNATIONS))
    code = if_else(done, Code.DONE, if_else(stalled, Code.STALLED, if_else(slow, Code.SLOW, Code.GO_ON)))
    if programs:
        code = if_else(programs.solved(), code, Code.UNSOLVED)
    after |= {"refused": refused, "stagnant": stagnant}
    if working and arriving:
        after["held"] = working.after(model, update, accepted)
    after |= {f"strategy.{name}": part for name, part in update.state.items()}
    outcome = vertcat(if_else(finite, code, Code.NOT_FINITE), tried, accepted, *figures_after)
    outputs = [_arrived(model, update, accepted), layout.join(after), outcome]
    record, yielding = VectorLayout.of({}), RelaxationTerms.of(update, programs, room, problem)
    if recorded:
        figures = {
            "V": here.V,
            "H": here.H,
            "accepted": accepted,
            "null_residual": model.null_length if problem.has_criterion else 0,
            **update.figures,
            **yielding.figures,
            "term": update.term,
            "null_term": update.null_term,
            "J": vertcat(*[model.J[:, j] for j in range(robot.n)]),
            "felt": J @ update.null_term,
        }
        record = VectorLayout.of({name: _rows(value) for name, value in figures.items()})
        outputs.append(record.join(figures))
    first_state = np.concatenate(list(first.values()))
    if not (programs and backend):
        return FusedStep(function("jtik_step", inputs, outputs), first_state, layout, record, yielding=yielding)
    parts = staged(inputs, local, cut, programs, outputs, backend, crowded=bool(problem.clearances))
    return FusedStep(parts.joined() if parts.fusible else parts, first_state, layout, record, parts, yielding=yielding)


def _local_model(
    problem: SymbolicProblem, q: Expression, target: Expression, parameters: Expression
) -> list[Expression]:
    """q, residual, its Jacobian, H and its gradient; with clearances distances, their Jacobian and their figures."""
    at = symbol("at", problem.robot.nq)
    H = problem.criterion(at, parameters)
    parts = [problem.residual(at, target), problem.residual_jacobian(at, target), H, problem.gradient(H, at)]
    if problem.clearances:
        parts += problem.clearance(at, parameters)
    return [q, *[substitute(part, at, q) for part in parts]]


def clearance_model(
    problem: SymbolicProblem,
    q: Expression,
    measured: Sequence[Expression],
    parameters: Expression,
    limits: tuple[Expression, Expression],
    state: Mapping[str, Expression] | None = None,
) -> ClearanceModel:
    """The clearances at q, from what `SymbolicProblem.clearance` returns: distances, their Jacobian, their figures."""
    state = state or {}
    distance, J, figures = measured
    lower, upper = limits
    rest = symbol("elsewhere", problem.robot.n)
    there = inside(problem.robot.integrate(q, -rest), lower, upper, problem.bounded)
    safe, aim, influence, gain = (figures[:, i] for i in range(4))
    return ClearanceModel(
        distance=distance,
        jacobian=J,
        safe=safe,
        aim=aim,
        influence=influence,
        gain=gain,
        curvature_radius=mmin(figures[:, 4]),
        travel=travels(problem.robot),
        rotational=problem.robot.rotational,
        elsewhere=lambda term: substitute(problem.distances(there, parameters), rest, term),
        recover=problem.recover,
        longest=state.get("longest", 0),
        record=state.get("violation", 0),
    )


def _arrived(model: LocalModel, update: Update, accepted: Expression) -> Expression:
    """q' of an update that may have been refused."""
    q, robot = model.here.q, model.robot
    if model.bounded or robot.nq != robot.n:
        return if_else(accepted, update.point.q, q)
    return q - vertcat(*[if_else(accepted, update.term[i], 0) for i in range(robot.n)])


def _rows(value: Expression) -> int:
    return int(getattr(value, "shape", (1, 1))[0])


def _engine_state(problem: SymbolicProblem, arriving: bool) -> dict[str, Array]:
    state = {name: np.zeros(1) for name in ("tube", "refused", "stagnant", "idle")}
    state["best"] = np.full(1, NEVER)
    state["patience"] = np.full(1, math.inf)
    if not arriving:
        state["V"] = np.zeros(1)
    if problem.clearances and problem.recover.any():
        state |= {"longest": np.full(1, LONGEST), "violation": np.full(1, NEVER)}
    if problem.bounded and arriving:
        state["held"] = np.zeros(len(problem.bounded))
    return state

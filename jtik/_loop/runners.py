"""The runners of a solver: its fused step on memory of its own, in the variants that solve, step and trace need."""

from __future__ import annotations

import math
from contextlib import AbstractContextManager
from functools import cached_property
from typing import Any

import numpy as np

from jtik._loop.native import object_layout, search_source, solve_source, step_source
from jtik._loop.runner import Runner
from jtik._loop.search.full_turns import FullTurns
from jtik._loop.search.restarts import RestartConfigurations
from jtik._loop.search.start_bank import StartBanks
from jtik._step.fused_step import Compiled, FusedStep, can_explore, fused_step
from jtik._step.inputs import SETTING, InputMemory, Inputs, Settings
from jtik._step.relaxation import RelaxationTerms
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.limits import Bounds
from jtik.constraints.step_box import StepBox, box_function
from jtik.qp import Backend
from jtik.qp.call import PythonCall
from jtik.strategy import Strategy
from jtik.strategy.checked_call import CheckedCall
from jtik.symbolic.compilation.several_files import Compilation
from jtik.symbolic.compile import Beside
from jtik.types import Array

SOLVE, EVALUATED, TIMED, EXPLORING = "solve", "evaluated", "timed", "exploring"
"""Names of the steps that can be compiled while they run on the virtual machine."""


class Runners:
    """Makes the runners of a solver, each when it is first needed.

    Args:
        problem: what the solver solves.
        strategy: its strategy.
        backend: what solves the QPs of a strategy that has any.
        bounds: limits of position, velocity and acceleration.
        memory: the inputs of `solve`.
        compilation: compiles the step as generated C; None for the virtual machine.
        null_space_rate: rate of the motion in the null space in timed steps [1/s].

    Attributes:
        memory: the inputs of a solver.
        turns: the joints that can turn all the way round.
        search_inputs: the inputs of `solve`: those of the solver, without the limits of these joints.
        solve: the runner of `InverseKinematics.solve`.
        step_inputs: the inputs of `step`: those of the solver, with settings of their own.
        step_is_built: whether `step` uses the function that `solve` has built.
        explores: whether a solve has needed the runner that explores.
        has_native_step: whether a step in generated C has a native step with it, and a search a native solve.
    """

    def __init__(
        self,
        problem: SymbolicProblem,
        strategy: Strategy,
        backend: Backend | None,
        *,
        bounds: Bounds,
        memory: InputMemory,
        compilation: Compilation | None,
        null_space_rate: float,
    ) -> None:
        self._made = dict[str, list[Runner]]()
        self._in_c = dict[str, FusedStep]()
        self._problem, self._strategy, self._backend = problem, strategy, backend
        self._bounds, self._compilation, self._null_space_rate = bounds, compilation, null_space_rate
        self.memory, self.explores = memory, False
        self.turns = FullTurns(problem, bounds.lower, bounds.upper)
        lower, upper = self.turns.free
        self.search_inputs = memory.inputs._replace(lower=lower, upper=upper)
        self._box_of_step = box = problem.once("box", lambda: box_function(bounds))
        if compilation:
            compilation.begin([box])  # while the step is compiled
        self.has_native_step = problem.robot.nq == problem.robot.n and object_layout.is_known()
        self.solve = self._runner(self._fused(), self.search_inputs, SOLVE)
        if can_explore(problem, strategy):
            self.solve.explorer = lambda: self.exploring
        self.solve.pauses = self._pauses
        self._box_function = problem.once("compiled box", lambda: compilation.to_c(box)) if compilation else box
        self.step_is_built = strategy.evaluates_candidate(problem.has_criterion) or bool(problem.clearances)
        self.step_inputs = memory.inputs._replace(settings=np.array(Settings(rests=1.0)))

    @cached_property
    def respects_priority(self) -> bool:
        """Whether the strategy respects levels of priority."""
        return self._strategy.respects_priority()

    @property
    def _pauses(self) -> bool:
        """Whether a solve is interrupted for levels of priority out of reach."""
        problem = self._problem
        several = len(problem.levels) > 1 and self.respects_priority
        return several and not problem.has_criterion and not problem.clearances

    @property
    def acceleration(self) -> Array:
        """Limits of acceleration (n,), infinite where there is none."""
        return self._bounds.acceleration

    @property
    def _braking(self) -> Array | None:
        """The same; None where there is no such limit."""
        return self.acceleration if (self.acceleration < math.inf).any() else None

    @property
    def relaxation(self) -> RelaxationTerms:
        """What a step may relax."""
        return self.solve.fused.relaxation

    @cached_property
    def banks(self) -> StartBanks | None:
        """The restarts by their distance from a target; None where they depend on where a search begins."""
        problem = self._problem
        if RestartConfigurations(problem.robot).depend_on_start:
            return None
        return problem.once("start banks", lambda: StartBanks(problem))

    @cached_property
    def step(self) -> Runner:
        """The runner of `step`: the errors that it returns are always those after the step."""
        return self._started(self._runner(self._evaluated, self.step_inputs, self.step_name))

    @cached_property
    def timed_step(self) -> tuple[Runner, StepBox]:
        """The runner of ``step(dt=)``, within a box on the step that it owns."""
        inputs, box = self.timed_box
        return self._started(self._runner(self._timed, inputs, TIMED)), box

    @cached_property
    def timed_box(self) -> tuple[Inputs[Array], StepBox]:
        """The inputs of ``step(dt=)``, with limits of their own, and the box that is written there."""
        inputs = self.step_inputs._replace(lower=self._bounds.lower.copy(), upper=self._bounds.upper.copy())
        return inputs, self._box(inputs, self._null_space_rate, brakes=True)

    @cached_property
    def track(self) -> Runner:
        """The runner of `InverseKinematics.track`: timed steps on the inputs of `solve`."""
        return self._runner(self._timed, self.memory.inputs, TIMED)

    @cached_property
    def traced_solve(self) -> Runner:
        """The runner of ``solve(trace=True)``: it gives the figures of a trace."""
        return self._search_runner(self._problem, recorded=True)

    @cached_property
    def limited_solve(self) -> Runner:
        """The runner of ``solve(jump_limit=)``: every revolute and prismatic joint has limits."""
        problem = self._problem
        return self.solve if problem.bounded == problem.scalar else self._search_runner(problem.with_limits())

    @cached_property
    def traced_limited_solve(self) -> Runner:
        """As `limited_solve`, with the figures of a trace."""
        problem = self._problem
        if problem.bounded == problem.scalar:
            return self.traced_solve
        return self._search_runner(problem.with_limits(), recorded=True)

    @cached_property
    def inspection(self) -> Runner:
        """As `traced_solve`, on inputs that are copied into it: for inspecting one step beside a solve."""
        inputs: Inputs[Array] = Inputs(*[np.zeros_like(part) for part in self.memory.inputs])
        return self._runner(self.traced_solve.fused, inputs)

    def tracking_box(self, *, stationary: bool) -> StepBox:
        """The box on each step of a path, written into the inputs of `solve`.

        Args:
            stationary: whether the criterion is to be stationary at each target, at any speed.
        """
        return self._box(self.memory.inputs, math.inf if stationary else self._null_space_rate)

    def _box(self, inputs: Inputs[Array], null_space_rate: float, *, brakes: bool = False) -> StepBox:
        share, time = (inputs.settings[at:][:1] for at in (SETTING.null_space_share, SETTING.braking_time))
        return StepBox(
            self._bounds,
            self._box_function,
            inputs.lower,
            inputs.upper,
            share=share,
            time=time if brakes else None,
            null_space_rate=null_space_rate,
            ahead=not self._problem.clearances,
        )

    @cached_property
    def exploring(self) -> Runner:
        """The runner that takes over where the error of a solve has stopped falling."""
        self.explores = True

        def build() -> FusedStep:
            fused = fused_step(self._problem, self._strategy, backend=self._backend, explores=True)
            return fused.compiled(self._compilation) if self._compilation else fused

        fused = self._problem.once("exploring step", build, keep=_can_be_shared)
        return self._runner(fused, self.search_inputs, EXPLORING)

    def _search_runner(self, problem: SymbolicProblem, *, recorded: bool = False) -> Runner:
        """A runner of a search that explores where the strategy does."""
        explores = can_explore(problem, self._strategy)

        def build() -> FusedStep:
            return fused_step(problem, self._strategy, backend=self._backend, recorded=recorded, explores=explores)

        name = f"search step, {recorded=}, {explores=}"
        runner = self._runner(problem.once(name, build, keep=_can_be_shared), self.search_inputs)
        runner.pauses = self._pauses
        return runner

    def _runner(self, fused: FusedStep, inputs: Inputs[Array], name: str | None = None) -> Runner:
        if name is None:
            return Runner(fused, inputs, self._problem.robot.nq)
        made = Runner(self._in_c.get(name, fused), inputs, self._problem.robot.nq)
        self._made.setdefault(name, []).append(made)
        return made

    @cached_property
    def of_lanes(self) -> FusedStep:
        """The step of `solve` as it runs in lanes: without the damping that only `step` uses."""
        if not CheckedCall(self._strategy, self._strategy, "damps_stagnation").flag():
            return self.solve.fused
        return fused_step(self._problem, self._strategy, backend=self._backend, rests=False)

    @property
    def step_name(self) -> str:
        """The name of the step that `step` uses."""
        return SOLVE if self.step_is_built else EVALUATED

    @property
    def built(self) -> list[str]:
        """Names of the steps that are built and can be compiled."""
        return [name for name, made in self._made.items() if made[0].fused.is_one_function]

    def in_c(self, name: str, compiled: Compiled, using_casadi: AbstractContextManager[Any]) -> FusedStep:
        """The step with this name in generated C. It may be called in any thread.

        Args:
            name: the name.
            compiled: makes a library.
            using_casadi: is entered while CasADi is used otherwise.

        Raises:
            CompilerError: without a compiler.
        """
        fused = self._made[name][0].fused

        def build() -> FusedStep:
            with using_casadi:
                beside = self._beside(fused, timed=name == TIMED)
            return fused.one_library(compiled, beside, using_casadi)

        return self._problem.once(f"{name} in C", build)

    def adopt(self, name: str, fused: FusedStep) -> None:
        """Run the step with this name as this function from now on."""
        self._in_c[name] = fused
        for runner in self._made[name]:
            runner.adopt(fused)

    def _beside(self, fused: FusedStep, *, timed: bool = False) -> Beside:
        """What is compiled with a fused step: the native step, and with one without a duration search and solve."""
        search = "" if timed else search_source.source(fused.state)
        if not self.has_native_step:
            return Beside(search)
        step = step_source.beside(fused, self._problem.tasks, self._box_of_step if timed else None)
        solve = "" if timed else solve_source.source(search_source.RUN)
        return step._replace(source=search + step.source + solve)

    def _started(self, runner: Runner) -> Runner:
        runner.start(self._problem.robot.neutral)
        return runner

    def _fused(self, *, evaluated: bool = False) -> FusedStep:
        def build() -> FusedStep:
            fused = fused_step(self._problem, self._strategy, backend=self._backend, evaluated=evaluated)
            if self._compilation is None:
                return fused
            return fused.compiled(self._compilation, self._beside(fused))

        return self._problem.once(f"step, {evaluated=}", build, keep=_can_be_shared)

    @cached_property
    def _evaluated(self) -> FusedStep:
        """The fused step whose errors are those after the step."""
        return self.solve.fused if self.step_is_built else self._fused(evaluated=True)

    @cached_property
    def _timed(self) -> FusedStep:
        """The fused step of a duration."""

        def build() -> FusedStep:
            fused = fused_step(
                self._problem, self._strategy, backend=self._backend, timed=True, acceleration=self._braking
            )
            if self._compilation is None:
                return fused
            return fused.compiled(self._compilation, self._beside(fused, timed=True))

        return self._problem.once("timed step", build, keep=_can_be_shared)


def _can_be_shared(fused: FusedStep) -> bool:
    """Whether solvers of several threads can use the functions of a step: what runs in Python may keep a state."""
    return fused.parts is None or not any(isinstance(call, PythonCall) for call in fused.parts.calls)

"""The runners of a solver: its fused step on memory of its own, in the variants that solve, step and trace need."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property

import numpy as np

from jtik._loop import native_search
from jtik._loop.runner import Runner
from jtik._step.fused_step import FusedStep, fused_step
from jtik._step.inputs import SETTING, InputMemory, Inputs, Settings
from jtik._step.relaxation import RelaxationTerms
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.limits import Bounds
from jtik.constraints.step_box import StepBox, box_function
from jtik.qp import Backend
from jtik.strategy import Strategy
from jtik.symbolic.compile import to_c
from jtik.types import Array


class Runners:
    """Makes the runners of a solver, each when it is first needed.

    Args:
        problem: what the solver solves.
        strategy: its strategy.
        backend: what solves the QPs of a strategy that has any.
        bounds: limits of position, velocity and acceleration.
        memory: the inputs of `solve`.
        compiled: whether the step runs as generated C.
        null_space_rate: rate of the motion in the null space in timed steps [1/s].

    Attributes:
        memory: the inputs of `solve`.
        solve: the runner of `InverseKinematics.solve`.
        step_inputs: the inputs of `step`: those of `solve`, with settings of their own.
        step_is_built: whether `step` uses the function that `solve` has built.
    """

    def __init__(
        self,
        problem: SymbolicProblem,
        strategy: Strategy,
        backend: Backend | None,
        *,
        bounds: Bounds,
        memory: InputMemory,
        compiled: bool,
        null_space_rate: float,
    ) -> None:
        self._problem, self._strategy, self._backend = problem, strategy, backend
        self._bounds, self._compiled, self._null_space_rate = bounds, compiled, null_space_rate
        self.memory = memory
        box = box_function(bounds)
        with ThreadPoolExecutor(1) as compiler:
            compiled_box = compiler.submit(to_c, box) if compiled else None  # while the step is compiled
            self.solve = self._runner(self._fused(), memory.inputs)
        self._box_function = compiled_box.result() if compiled_box else box
        self.step_is_built = strategy.evaluates_candidate(problem.has_criterion) or bool(problem.clearances)
        self.step_inputs = memory.inputs._replace(settings=np.array(Settings()))

    @cached_property
    def respects_priority(self) -> bool:
        """Whether the strategy respects levels of priority."""
        return self._strategy.respects_priority()

    @property
    def relaxation(self) -> RelaxationTerms:
        """What a step may relax."""
        return self.solve.fused.relaxation

    @cached_property
    def step(self) -> Runner:
        """The runner of `step`: the errors that it returns are always those after the step."""
        return self._started(self._runner(self._evaluated, self.step_inputs))

    @cached_property
    def timed_step(self) -> tuple[Runner, StepBox]:
        """The runner of ``step(dt=)``, within a box on the step that it owns."""
        inputs = self.step_inputs._replace(lower=self._bounds.lower.copy(), upper=self._bounds.upper.copy())
        runner = self._runner(self._timed, inputs)
        return self._started(runner), self._box(inputs, self._null_space_rate)

    @cached_property
    def track(self) -> Runner:
        """The runner of `InverseKinematics.track`: timed steps on the inputs of `solve`."""
        return self._runner(self._timed, self.memory.inputs)

    @cached_property
    def traced_solve(self) -> Runner:
        """The runner of ``solve(trace=True)``: it gives the figures of a trace."""
        fused = fused_step(self._problem, self._strategy, backend=self._backend, recorded=True)
        return self._runner(fused, self.memory.inputs)

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

    def _box(self, inputs: Inputs[Array], null_space_rate: float) -> StepBox:
        share = inputs.settings[SETTING.null_space_share :][:1]
        return StepBox(
            self._bounds,
            self._box_function,
            inputs.lower,
            inputs.upper,
            share=share,
            null_space_rate=null_space_rate,
            ahead=not self._problem.clearances,
        )

    def _runner(self, fused: FusedStep, inputs: Inputs[Array]) -> Runner:
        return Runner(fused, inputs, self._problem.robot.nq)

    def _started(self, runner: Runner) -> Runner:
        runner.start(self._problem.robot.neutral)
        return runner

    def _fused(self, *, evaluated: bool = False) -> FusedStep:
        fused = fused_step(self._problem, self._strategy, backend=self._backend, evaluated=evaluated)
        return fused.compiled(native_search.source(fused.state)) if self._compiled else fused

    @cached_property
    def _evaluated(self) -> FusedStep:
        """The fused step whose errors are those after the step."""
        return self.solve.fused if self.step_is_built else self._fused(evaluated=True)

    @cached_property
    def _timed(self) -> FusedStep:
        """The fused step of a duration."""
        fused = fused_step(self._problem, self._strategy, backend=self._backend, timed=True)
        return fused.compiled() if self._compiled else fused

"""Stepping: what `InverseKinematics.step` runs."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from jtik._loop.arguments import ConfigurationReader
from jtik._loop.compile_ahead import CompileAhead
from jtik._loop.criterion_escape import StepEscape
from jtik._loop.exclusive_use import ExclusiveUse, in_use
from jtik._loop.inspection import Inspector
from jtik._loop.runner import Runner
from jtik._loop.runners import TIMED, Runners
from jtik._loop.saddle_escape import SaddleEscape
from jtik._loop.target_memory import TargetMemory
from jtik._step.solve_progress import UNKNOWN
from jtik._step.stopping import Code
from jtik.constraints.step_box import StepBox
from jtik.criterion import CriterionTerms
from jtik.result.step import Step
from jtik.robot import Robot
from jtik.task import TaskStack
from jtik.types import Array

_FLOAT = np.dtype(np.float64)
_new_tuple = tuple.__new__


class Stepping:
    """One update per call; the state of the strategy is kept from call to call.

    Attributes:
        call: `step`, or what compiles its step meanwhile.
    """

    def __init__(
        self,
        robot: Robot,
        tasks: TaskStack,
        targets: TargetMemory,
        runners: Runners,
        configurations: ConfigurationReader,
        *,
        escape: SaddleEscape,
        criterion_escape: StepEscape,
        inspector: Inspector,
        exclusive: ExclusiveUse,
        terms: CriterionTerms,
        ahead: CompileAhead,
    ) -> None:
        self._ahead = ahead
        self.call = self._step_ahead if ahead.compiles else self.step
        self._robot, self._tasks, self._runners = robot, tasks, runners
        self._read, self._vector = configurations.read, configurations.vector
        self._escape, self._inspector = escape, inspector
        self._criterion_escape = criterion_escape if criterion_escape.possible else None
        self._exclusive = exclusive
        self._numeric = terms if terms.numeric else None
        self._targets = targets  # vectors are copied without a check; they are checked after a step that is not finite
        self._untimed: Runner | None = None
        self._timed: tuple[Runner, StepBox] | None = None
        self._momentum: list[Array] = []  # with limits of acceleration, in the two memories of the state
        if runners.step_is_built:
            self._first()

    def warm_up(self) -> None:
        """Build what a step runs."""
        self._first()
        self._first_timed()

    def _step_ahead(self, q: Any, target: Any, dt: float | None) -> Step:
        """`step`, on the virtual machine until its step in generated C is ready."""
        ahead, name = self._ahead, self._runners.step_name if dt is None else TIMED
        if ahead.waiting and not self._exclusive.busy:
            ahead.adopt()
        if ahead.settled(name):
            self.call = self.step
        begin = time.perf_counter()
        stepped = self.step(q, target, dt)
        ahead.spend(name, time.perf_counter() - begin)
        return stepped

    def step(self, q: Any, target: Any, dt: float | None) -> Step:
        """One update, as `InverseKinematics.step` describes it."""
        exclusive = self._exclusive
        if exclusive.busy:
            raise in_use()
        try:
            exclusive.busy = True
            if dt is None:
                runner, box = self._untimed or self._first(), None
            else:
                runner, box = self._timed or self._first_timed()
            self._targets.copy(target)
            at = runner.at
            memory = runner.q[at]
            if self._vector and type(q) is np.ndarray and q.dtype == _FLOAT and q.shape == memory.shape:
                memory[:] = q
            else:
                memory[:] = self._read("q", q)
            started = memory.tobytes() if self._criterion_escape else b""
            if box is not None and dt is not None:
                box.narrow(memory, dt)
                if box.ahead:
                    memory[:] = start = box.start()
                    self._momentum[at][:] = box.displacement(start)
            if runner.violation is not None:  # obstacles, or the robot itself, may have moved between the calls
                runner.state[at][runner.violation] = UNKNOWN
            runner.calls[at]()
            if self._numeric is not None:
                self._numeric.raise_interruption()
            after = runner.q[1 - at]
            position: float
            orientation: float
            code, tried, accepted, position, orientation, _ = runner.view
            if tried:
                runner.at = 1 - at
            elif code == Code.NOT_FINITE:  # perhaps because of an argument that was copied without a check
                self._read("q", q)
                self._tasks.read_target(target)
            moved, done, escaped = accepted == 1.0, code == 1.0, False
            if code == Code.STALLED:
                escaped = self._escape.escape(after, runner.inputs)
                runner.restart(after)
                moved = False
                position, orientation = self._inspector.errors(after, runner.inputs)
            if self._criterion_escape:
                if not done:
                    self._criterion_escape.moves()
                elif self._criterion_escape.escape(started, after, runner.inputs):
                    runner.restart(after)
                    moved, done, escaped = False, False, True
                    position, orientation = self._inspector.errors(after, runner.inputs)
            if box is not None and not (moved or done or escaped):
                after[:] = box.braked()
                position, orientation = self._inspector.errors(after, runner.inputs)
            if box is not None:
                allowed = box.slowed(after)
                if allowed is not after:
                    after, done = allowed, False
                    position, orientation = self._inspector.errors(allowed, runner.inputs)
                box.moved(after)
            return _new_tuple(Step, (after.copy(), position, orientation, moved, done, escaped))
        finally:
            exclusive.busy = False

    def reset(self) -> None:
        """Forget the state of the strategy and the last step."""
        exclusive = self._exclusive
        if exclusive.busy:
            raise in_use()
        try:
            exclusive.busy = True
            if self._untimed is not None:
                self._untimed.start(self._robot.neutral)
            if self._timed is not None:
                runner, box = self._timed
                runner.start(self._robot.neutral)
                box.rest()
        finally:
            exclusive.busy = False

    def moves(self, velocity: Array) -> None:
        """Take a velocity (n,) [rad/s] as that of the last step with a time."""
        self._runners.timed_box[1].moves(velocity)

    def _first(self) -> Runner:
        self._untimed = self._runners.step
        self._watch()
        return self._untimed

    def _first_timed(self) -> tuple[Runner, StepBox]:
        runner, box = self._timed = self._runners.timed_step
        if box.ahead:
            self._momentum = [state[runner.fused.state.slices["momentum"]] for state in runner.state]
        self._watch()
        return self._timed

    def _watch(self) -> None:
        """Let a step that is built now be compiled, too, also where the other one has settled."""
        if self._ahead.compiles:
            self.call = self._step_ahead

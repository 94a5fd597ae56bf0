"""Stepping: what `InverseKinematics.step` runs."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from jtik._loop.arguments import ConfigurationReader
from jtik._loop.escapes.criterion import StepEscape
from jtik._loop.escapes.saddle import SaddleEscape
from jtik._loop.exclusive_use import ExclusiveUse, in_use
from jtik._loop.inspection import Inspector
from jtik._loop.native.compile_ahead import CompileAhead
from jtik._loop.native.step import Call, NativeStep
from jtik._loop.native.step_source import AGAIN, UNREAD
from jtik._loop.runner import Runner
from jtik._loop.runners import TIMED, Runners
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


Way = tuple[Runner, StepBox | None, NativeStep | None]
"""How a step runs: its runner; the box of a step with a duration; the step in C, None on the virtual machine."""


class Stepping:
    """One update per call; the state of the strategy is kept from call to call.

    Attributes:
        call: the step in C, which leaves what is not usual to `step`; or `step`, or what compiles its step meanwhile.
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
        self.call: Call = self._step_ahead if ahead.compiles else self.step
        self._robot, self._tasks, self._runners = robot, tasks, runners
        self._read, self._shape = configurations.read, (robot.nq,) if configurations.vector else None
        self._escape, self._inspector = escape, inspector
        self._criterion_escape = criterion_escape
        self._exclusive = exclusive
        self._numeric = terms if terms.numeric else None
        self._targets = targets  # vectors are copied without a check; they are checked after a step that is not finite
        self._untimed: Way | None = None
        self._timed: Way | None = None
        self._momentum = slice(0)  # where the state has it, with limits of acceleration
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
            self.call = self._in_c()
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
            way = (self._untimed or self._first()) if dt is None else (self._timed or self._first_timed())
            runner, box, native = way
            if native is not None:
                left = native.left()
                if left == UNREAD:
                    if box is not None and dt is not None and dt is not box.dt:
                        box.lasts(dt)
                    stepped = native.update(q, target)
                    if stepped is None and (left := native.left()) == UNREAD:
                        self._targets.copy(target)
                        stepped = native.update(self._read("q", q), native.target)
                        left = native.left()
                    if stepped is not None:
                        return stepped
                if left != UNREAD:
                    if left == AGAIN:
                        runner.calls[0]()
                    return self._ended(way, q, target, (box.q if box else runner.q[0]).tobytes())
            self._targets.copy(target)
            at = runner.at
            memory = runner.q[at]
            if type(q) is np.ndarray and q.dtype == _FLOAT and q.shape == self._shape:
                memory[:] = q
            else:
                memory[:] = self._read("q", q)
            started = memory.tobytes() if self._criterion_escape.possible else b""
            if box is not None and dt is not None:
                box.narrow(memory, dt)
                if box.ahead:
                    memory[:] = start = box.start()
                    runner.state[at][self._momentum] = box.displacement(start)
            if runner.violation is not None:  # obstacles, or the robot itself, may have moved between the calls
                runner.state[at][runner.violation] = UNKNOWN
            runner.calls[at]()
            return self._ended(way, q, target, started)
        finally:
            exclusive.busy = False

    def _ended(self, way: Way, q: Any, target: Any, started: bytes) -> Step:
        """The update of a call that has ended, from the bytes of the configuration with which it was made."""
        runner, box, native = way
        if self._numeric is not None:
            self._numeric.raise_interruption()
        at = runner.at
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
        if not done:
            self._criterion_escape.resting[0] = 0
        elif self._criterion_escape.possible and self._criterion_escape.escape(started, after, runner.inputs):
            runner.restart(after)
            moved, done, escaped = False, False, True
            position, orientation = self._inspector.errors(after, runner.inputs)
        if box is not None:
            if not (moved or done or escaped):
                after[:] = box.braked()
                position, orientation = self._inspector.errors(after, runner.inputs)
            allowed = box.slowed(after)
            if allowed is not after:
                after, done = allowed, False
                position, orientation = self._inspector.errors(allowed, runner.inputs)
            box.moved(after)
        if native is not None:
            runner.settle()
        return _new_tuple(Step, (after.copy(), position, orientation, moved, done, escaped))

    def reset(self) -> None:
        """Forget the state of the strategy and the last step."""
        exclusive = self._exclusive
        if exclusive.busy:
            raise in_use()
        try:
            exclusive.busy = True
            for way in (self._untimed, self._timed):
                if way is not None:
                    way[0].start(self._robot.neutral)
                    if way[1] is not None:
                        way[1].rest()
        finally:
            exclusive.busy = False

    def moves(self, velocity: Array) -> None:
        """Take a velocity (n,) [rad/s] as that of the last step with a time."""
        self._runners.timed_box[1].moves(velocity)

    def adopted(self) -> None:
        """Step in C what runs in generated C from now on."""
        self._untimed, self._timed = (way and self._way(*way[:2]) for way in (self._untimed, self._timed))
        if self.call != self._step_ahead:
            self.call = self._in_c()

    def _in_c(self) -> Call:
        """`step` behind what there is in C."""
        call: Call = self.step
        for way in (self._untimed, self._timed):
            if way is not None and way[2] is not None:
                call = way[2].before(call)
        return call

    def _first(self) -> Way:
        self._untimed = self._way(self._runners.step, None)
        self._watch()
        return self._untimed

    def _first_timed(self) -> Way:
        runner, box = self._runners.timed_step
        if box.ahead:
            self._momentum = runner.fused.state.slices["momentum"]
        self._timed = self._way(runner, box)
        self._watch()
        return self._timed

    def _way(self, runner: Runner, box: StepBox | None) -> Way:
        """How a step runs: in C where its function is in generated C."""
        library = runner.fused.library
        if library is None or not self._runners.has_native_step:
            return runner, box, None
        runner.settle()
        native = NativeStep(library, runner, box, escape=self._criterion_escape, exclusive=self._exclusive)
        return runner, box, native

    def _watch(self) -> None:
        """Let a step that is built now be compiled, too, also where the other one has settled."""
        self.call = self._step_ahead if self._ahead.compiles else self._in_c()

"""InverseKinematics: one robot, its tasks, its criteria and a strategy, compiled once; then step, solve and track."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jtik.compile import to_c
from jtik.criterion import Criterion, CriterionSum, CriterionTerms, Parameters
from jtik.diagnosis import Diagnosis
from jtik.errors import ArgumentError, finite_array
from jtik.fused import OUTCOME, Code, fused_step
from jtik.problem import Problem
from jtik.recorder import Recorder
from jtik.registry import strategy_of
from jtik.rescue import Rescue
from jtik.robot import Robot
from jtik.runner import Runner
from jtik.solution import Solution, Status, Step, Trajectory
from jtik.strategy import Strategy
from jtik.task import Task, TaskStack

Array = NDArray[np.float64]
Until = Literal["steady", "reached"]
DEFAULTS = (1e-6, 1e-6, 1e-6, 1.0)
"""Tolerances of position, orientation and optimality, and 1 to wait until the criterion is steady."""

MOST_ESCAPES = 20
"""Second-order steps a solve may take out of singular stalls."""


class InverseKinematics:
    """Joint positions for what the tip must do and what the freedom left over should do.

    Building one compiles the step; afterwards targets, parameters and tolerances are numbers that cost nothing to
    change. An object works on memory of its own and belongs to one thread.

    Args:
        robot: the robot.
        task: a Task, or several, each with a name of its own.
        criteria: what to minimise with the freedom left: a Criterion or a weighted sum of them.
        strategy: name of a registered strategy, or a Strategy object.
        limits: whether the robot's joint limits hold.
        compiled: run the step as generated C, for which a C compiler must be there: about a second more to build,
        once, and three
            to five times faster steps.

    Attributes:
        parameters: live parameters of the criteria by name: ``ik.parameters["joint_centering.weight"] = 2.0``.
    """

    def __init__(
        self,
        robot: Robot,
        task: Task | Iterable[Task],
        *,
        criteria: Criterion | CriterionSum | None = None,
        strategy: str | Strategy = "hybrid",
        limits: bool = True,
        compiled: bool = False,
    ) -> None:
        if not isinstance(robot, Robot):
            raise ArgumentError("robot", robot, "a jtik.Robot")
        self.robot = robot
        self.tasks = TaskStack.of(robot, task)
        self.strategy = strategy_of(strategy)
        terms = CriterionTerms.of(robot, criteria)
        self.parameters: Parameters = terms.parameters
        self._names = [name for name, _, _ in terms.named]
        self._lower = robot.lower.copy() if limits else np.full(robot.nq, -np.inf)
        self._upper = robot.upper.copy() if limits else np.full(robot.nq, np.inf)
        bounded = tuple(
            (int(i), int(j))
            for i, j in zip(robot.scalar_q, robot.scalar_v, strict=True)
            if self._lower[i] > -np.inf or self._upper[i] < np.inf or robot.velocity_limit[j] < np.inf
        )
        self._problem = Problem(robot, self.tasks, terms, bounded)
        self._target = np.zeros(self.tasks.target_size)
        # targets that are their own numbers skip the reading in `step`
        self._plain_target = self._target.shape if self.tasks.plain else None
        self._plain_q = robot.nq == robot.n
        self._settings = np.array(DEFAULTS)
        self._inputs = [self._target, self.parameters.memory, self._lower, self._upper, self._settings]
        self._step_inputs = [*self._inputs[:-1], np.array(DEFAULTS)]
        fused = fused_step(self._problem, self.strategy)
        if compiled:
            fused = replace(fused, function=to_c(fused.function))
        self._runner = Runner(fused, self._inputs, robot.nq)
        self._recorder: Runner | None = None
        self._stepper: Runner | None = None
        self._rescue = Rescue(self._problem)
        self._diagnosis = Diagnosis(self._problem, self._rescue)

    def __repr__(self) -> str:
        names = " + ".join(self._names) or "no criterion"
        return f"InverseKinematics({self.robot!r}, {list(self.tasks.tasks)}, {names}, {self.strategy!r})"

    def solve(
        self,
        target: Any,
        *,
        q0: ArrayLike | None = None,
        max_iterations: int = 1000,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
        optimality_tolerance: float = 1e-6,
        until: Until = "steady",
        trace: bool = False,
    ) -> Solution:
        """Iterate to the target; always returns a Solution, which says why it stopped.

        Args:
            target: what the task reads as one, such as (x, y); with several tasks a dict of targets by name.
            q0: where to start, (nq,); the robot's neutral configuration by default. Outside the limits it is led back.
            max_iterations: most steps to try.
            position_tolerance: norm of the position error to reach [m].
            orientation_tolerance: norm of the orientation error to reach [rad].
            optimality_tolerance: norm of (I - J+ J) dH/dv to reach, relative to max(1, |dH/dv|).
            until: "steady" goes on until the criterion cannot fall further, "reached" stops on arrival.
            trace: keep every iteration in ``solution.trace``.

        Raises:
            ArgumentError: for an argument of wrong shape, NaN or infinity, naming it.
        """
        begin = time.perf_counter()
        self._target[:] = self.tasks.read_target(target)
        start = self._configuration("q0", q0)
        self._settings[:] = (
            _positive("position_tolerance", position_tolerance),
            _positive("orientation_tolerance", orientation_tolerance),
            _positive("optimality_tolerance", optimality_tolerance),
            _steady(until),
        )
        if not isinstance(max_iterations, (int, np.integer)) or max_iterations < 0:
            raise ArgumentError("max_iterations", max_iterations, "an integer from 0")
        runner = self._recording() if trace else self._runner
        runner.start(self._led_back(start))
        recorder = Recorder(runner) if trace else None
        q, code, iterations, escapes = self._iterate(runner, int(max_iterations), recorder)
        report = self._diagnosis.report(q, self._inputs)
        status = self._diagnosis.status(q, code, report, self._inputs)
        return Solution(
            q=q,
            status=status,
            converged=status is Status.CONVERGED or (status is Status.REACHED and until == "reached"),
            iterations=iterations,
            escapes=escapes,
            seconds=time.perf_counter() - begin,
            report=report,
            trace=recorder.trace(q, lambda at: self._diagnosis.error(at, self._inputs)) if recorder else None,
        )

    def step(self, q: ArrayLike, target: Any) -> Step:
        """One update from ``q``, for controllers; what the strategy remembers goes on from the last call.

        A refused step leaves q where it is and the next call tries a smaller one. ``reset()`` forgets the past. A step
        is done at the default tolerances of ``solve``, with the criterion steady.

        Args:
            q: configuration, (nq,). Outside the limits it is led back.
            target: what the task reads as one.

        Raises:
            ArgumentError: for an argument of wrong shape, NaN or infinity, naming it.
        """
        runner = self._stepper
        if runner is None:
            runner = self._stepper = Runner(self._runner.fused, self._step_inputs, self.robot.nq)
            runner.start(self.robot.neutral)
        if type(target) is np.ndarray and target.shape == self._plain_target:
            self._target[:] = target
        else:
            self._target[:] = self.tasks.read_target(target)
        at = runner.at
        memory = runner.q[at]
        if self._plain_q and type(q) is np.ndarray and q.shape == memory.shape:
            memory[:] = q
        else:
            memory[:] = self._configuration("q", q)
        runner.calls[at]()
        after = runner.q[1 - at]
        code, tried, accepted, position, orientation, _ = runner.view
        if tried:
            runner.at = 1 - at
        elif code == Code.NOT_FINITE:  # whose fault? the arrays above were taken unread
            self._configuration("q", q)
            self.tasks.read_target(target)
        escaped = False
        if code == Code.STALLED:
            escaped = self._rescue.escape(after, self._step_inputs)
            runner.start(after)
            report = self._diagnosis.report(after, self._step_inputs)
            return Step(after.copy(), report.position_error, report.orientation_error, False, False, escaped)
        return Step(after.copy(), position, orientation, accepted == 1.0, code == 1.0, escaped)

    def reset(self) -> None:
        """Forget what ``step`` remembers of earlier calls, as after a jump of the target."""
        if self._stepper is not None:
            self._stepper.start(self.robot.neutral)

    def track(
        self,
        targets: Iterable[Any],
        *,
        q0: ArrayLike | None = None,
        dt: float = 0.02,
        max_iterations: int = 100,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
        optimality_tolerance: float = 1e-6,
        until: Until = "reached",
    ) -> Trajectory:
        """Follow a path of targets, ``dt`` [s] apart, each solve starting where the last one ended.

        The robot's velocity limits hold from one target to the next; a target that they keep out of reach is
        followed as far as they allow. Options are those of ``solve``; ``until="steady"`` also lets the criterion
        settle at each target.

        Raises:
            ArgumentError: for an argument of wrong shape, NaN or infinity, naming it.
        """
        dt = _positive("dt", dt)
        wanted = list(targets)
        if not wanted:
            raise ArgumentError("targets", "none", "at least one target")
        q = self._configuration("q0", q0)
        reach = np.full(self.robot.nq, np.inf)
        reach[self.robot.scalar_q] = self.robot.velocity_limit[self.robot.scalar_v] * dt
        lower, upper = self._lower.copy(), self._upper.copy()
        solutions = []
        try:
            for target in wanted:
                down, up = q - reach, q + reach
                # outside the position limits the box is what the velocity limits allow on the way back
                self._lower[:] = np.minimum(np.maximum(lower, down), up)
                self._upper[:] = np.maximum(np.minimum(upper, up), down)
                solution = self.solve(
                    target,
                    q0=q,
                    max_iterations=max_iterations,
                    position_tolerance=position_tolerance,
                    orientation_tolerance=orientation_tolerance,
                    optimality_tolerance=optimality_tolerance,
                    until=until,
                )
                if self.robot.nq != self.robot.n:
                    solution = self._slowed(q, solution, dt)
                solutions.append(solution)
                q = solution.q
        finally:
            self._lower[:], self._upper[:] = lower, upper
        return Trajectory(
            times=dt * np.arange(1, len(wanted) + 1, dtype=np.float64),
            q=np.array([solution.q for solution in solutions]),
            errors=np.array([np.linalg.norm(solution.error) for solution in solutions]),
            statuses=tuple(solution.status for solution in solutions),
            iterations=np.array([solution.iterations for solution in solutions], dtype=np.int64),
            seconds=np.array([solution.seconds for solution in solutions]),
        )

    def _slowed(self, start: Array, solution: Solution, dt: float) -> Solution:
        """The solution, or how far the way to it leads in dt if a ball or free joint is too fast for the rest."""
        way = self.robot.difference(start, solution.q)
        allowed = self.robot.velocity_limit * dt
        share = float(np.min(np.divide(allowed, np.abs(way), out=np.ones(len(way)), where=np.abs(way) > allowed)))
        if share >= 1:
            return solution
        q = self.robot.integrate(start, share * way)
        report = self._diagnosis.report(q, self._inputs)
        status = self._diagnosis.status(q, Code.GO_ON, report, self._inputs)
        return replace(solution, q=q, status=status, report=report, converged=False)

    def _configuration(self, argument: str, q: ArrayLike | None) -> Array:
        """The configuration given, checked; raises ArgumentError for a wrong shape, NaN or a zero quaternion."""
        if q is None:
            return self.robot.neutral
        return (
            finite_array(argument, q, (self.robot.nq,))
            if self._plain_q
            else self.robot.configuration(q, argument=argument)
        )

    def _led_back(self, q: Array) -> Array:
        """The configuration inside the limits."""
        scalar = self.robot.scalar_q
        q = q.copy()
        q[scalar] = np.clip(q[scalar], self._lower[scalar], self._upper[scalar])
        return q

    def _recording(self) -> Runner:
        if self._recorder is None:
            fused = fused_step(self._problem, self.strategy, recorded=True)
            self._recorder = Runner(fused, self._inputs, self.robot.nq)
        return self._recorder

    def _iterate(self, runner: Runner, limit: int, recorder: Recorder | None) -> tuple[Array, Code, int, int]:
        """The loop, written once for every strategy: call until the code says otherwise."""
        calls, view = runner.calls, runner.view
        code, escapes, k, at = Code.GO_ON, 0, 0, 0
        while k < limit:
            if recorder is not None:
                recorder.before(runner.q[at])
            calls[at]()
            at = 1 - at
            k += 1
            if recorder is not None:
                recorder.after()
            if view[0] == 0.0:
                continue
            code = Code(int(view[0]))
            if code is Code.STALLED and escapes < MOST_ESCAPES and self._rescue.escape(runner.q[at], self._inputs):
                escapes += 1
                if recorder is not None:
                    recorder.escaped()
                runner.start(runner.q[at].copy())
                code, at = Code.GO_ON, 0
                continue
            if not view[OUTCOME.tried]:  # it stopped before it tried anything: no iteration
                k -= 1
                if recorder is not None:
                    recorder.forget()
            break
        return runner.q[at].copy(), code, k, escapes


def _positive(argument: str, value: float) -> float:
    """The value as a float. Raises ArgumentError unless it is finite and positive."""
    if type(value) is float and 0.0 < value < math.inf:
        return value
    number = float(finite_array(argument, value, ()))
    if not number > 0:
        raise ArgumentError(argument, value, "a positive number")
    return number


def _steady(until: str) -> float:
    if until not in ("steady", "reached"):
        raise ArgumentError("until", until, "'steady' or 'reached'")
    return 1.0 if until == "steady" else 0.0

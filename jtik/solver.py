"""InverseKinematics: one robot, its tasks, its criteria and a strategy, compiled once; then step, solve and track."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from jtik._loop import native
from jtik._loop.batch import Entry, SolutionBatch, collect, read_targets
from jtik._loop.diagnosis import Diagnosis
from jtik._loop.native import NativeSearch
from jtik._loop.options import Until, positive, read_request, read_settings
from jtik._loop.recording import TraceRecorder
from jtik._loop.runner import Runner
from jtik._loop.saddle_escape import SaddleEscape
from jtik._loop.search import Found, Request, Search
from jtik._loop.tracking import follow
from jtik._step.fused import FusedStep, fused_step
from jtik._step.inputs import InputMemory, Inputs, Settings
from jtik._step.relaxation import Relaxation
from jtik._step.stopping import Code
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.clearance import Clearance, clearances_of
from jtik.constraints.limits import Limits, limits_of
from jtik.constraints.step_box import StepBox, box_function
from jtik.criterion import Criteria, CriterionTerms, Parameters
from jtik.errors import ArgumentError, finite_array
from jtik.progress import Progress, watched
from jtik.qp import Backend, as_problem, backend_of
from jtik.registry import strategy_of, supporting_clearances
from jtik.result.report import Report
from jtik.result.solution import Solution, Status, Step, is_success
from jtik.result.trajectory import Trajectory
from jtik.robot import Robot
from jtik.strategy import Strategy
from jtik.symbolic import Function
from jtik.symbolic.compile import to_c
from jtik.task import Task
from jtik.task.reduction import reduced
from jtik.types import Array

if TYPE_CHECKING:
    import qpsolvers


class InverseKinematics:
    """Joint positions for what the tip must do and what the freedom left over should do.

    Building one compiles the step; afterwards targets, parameters and tolerances are numbers that cost nothing to
    change. An object works on memory of its own and belongs to one thread.

    Args:
        robot: the robot.
        task: a Task, or several, each with a name of its own.
        criteria: what to minimise with the freedom left: a criterion, a weighted sum such as ``A - 0.3 * B``, the name
            of a registered criterion, a list of these, or None.
        strategy: name of a registered strategy, perhaps with a secondary term as in "newton+qp", or a Strategy object.
        solver: what solves the programs of a strategy that has any: a name of `jtik.qp.available`, or a
            `jtik.qp.Backend`; DAQP by default.
        limits: which limits hold, a `Limits`: position limits always, limits of velocity and acceleration where there
            is a time, in `track` and ``step(dt=)``. True for the robot's own positions and velocities; False leaves
            its position limits out.
        clearances: distances no accepted step may bring below their safe values, for strategies whose programs have
            rows for them: "weighted_qp", "lexicographic_qp", and task steps with "+qp", such as "hybrid+qp".
        joints: names of the joints to move, or "all"; by default those that move what the tasks are about, so that
            the fingers of a hand are no part of an arm's solution.
        at: configuration of the robot at which the other joints are locked, its neutral one by default.
        compiled: run the step as generated C, for which a C compiler must be there: about a second more to build,
        once, and three
            to five times faster steps.

    Attributes:
        robot: the robot with only those joints free, which ``q`` everywhere belongs to; `whole` adds the others.
        limits: the `Limits` that hold.
        parameters: live parameters of the criteria by name: ``ik.parameters["joint_centering.weight"] = 2.0``.
    """

    def __init__(
        self,
        robot: Robot,
        task: Task | Iterable[Task],
        *,
        criteria: Criteria = None,
        strategy: str | Strategy = "hybrid",
        solver: str | Backend | None = None,
        limits: bool | Limits = True,
        clearances: Clearance | Iterable[Clearance] | None = None,
        joints: str | Iterable[str] | None = None,
        at: ArrayLike | None = None,
        compiled: bool = False,
    ) -> None:
        if not isinstance(robot, Robot):
            raise ArgumentError("robot", robot, "a jtik.Robot")
        self.limits = limits_of(limits)
        self._given = robot
        self._locked = robot.neutral if at is None else robot.configuration(at, argument="at")
        robot, self.tasks = reduced(robot, task, joints, self._locked)
        self.robot = robot
        self.strategy = strategy_of(strategy)
        kept_clear = clearances_of(clearances)
        terms = CriterionTerms.of(robot, criteria, kept_clear)
        self.parameters: Parameters = terms.parameters
        self._names = [name for name, _, _ in terms.named]
        self._bounds = self.limits.of(robot)
        self._lower, self._upper, bounded = self._bounds.lower, self._bounds.upper, self._bounds.bounded
        self._problem = SymbolicProblem(robot, self.tasks, terms, bounded, kept_clear)
        self._backend: Backend | None = None
        if kept_clear and not self.strategy.supports_clearances():
            raise ArgumentError("clearances", f"{clearances!r} with strategy={strategy!r}", supporting_clearances())
        if self.strategy.uses_qp(self._problem.has_criterion or bool(kept_clear)):
            self._backend = backend_of(solver)
        elif solver is not None:
            raise ArgumentError("solver", solver, f"none: {self.strategy!r} solves no program here")
        self._memory = InputMemory(self.tasks.target_size, self.parameters, self._lower, self._upper)
        self._inputs = self._memory.inputs
        self._target, self._lower, self._upper = self._inputs.target, self._inputs.lower, self._inputs.upper
        # targets that are their own numbers skip the reading in `step`
        self._plain_target = self._target.shape if self.tasks.plain else None
        self._plain_q = robot.nq == robot.n
        self._step_inputs = self._inputs._replace(settings=np.array(Settings()))
        self._options: tuple[Any, ...] = ()
        self._prepared: tuple[Any, ...] = ()
        self._request = Request(0, 0, 0)
        self._compiled = compiled
        self._runner = Runner(self._fused(), self._inputs, robot.nq)
        self._recorder: Runner | None = None
        self._witness: Runner | None = None
        self._stepper: Runner | None = None
        self._timed: tuple[Runner, StepBox] | None = None
        self._rescue = SaddleEscape(self._problem)
        yields = bool(self._runner.fused.yielding.entries)
        self._diagnosis = Diagnosis(self._problem, self._rescue, self._yielded if yields else None)
        self._search = Search(robot, self._rescue, self._inputs)
        if self._runner.fused.library:
            self._search.native = NativeSearch(self._runner.fused.library, self._runner, self._inputs)

    def __repr__(self) -> str:
        names = " + ".join(self._names) or "no criterion"
        return f"InverseKinematics({self.robot!r}, {list(self.tasks.tasks)}, {names}, {self.strategy!r})"

    def full_configuration(self, q: ArrayLike) -> Array:
        """The configuration of the robot this solver was given, with its locked joints, for a ``q`` of `robot`."""
        q, whole = self._configuration("q", q), self._locked.copy()
        for joint in self.robot.joint_names:
            whole[self._given.q_slice(joint)] = q[self.robot.q_slice(joint)]
        return whole

    def solve(
        self,
        target: Any,
        *,
        q0: ArrayLike | None = None,
        restarts: int = 0,
        seed: int | None = None,
        max_iterations: int = 1000,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
        optimality_tolerance: float = 1e-6,
        until: Until = "stationary",
        trace: bool = False,
    ) -> Solution:
        """Iterate to the target; always returns a Solution, which says why it stopped.

        Args:
            target: what the task reads as one, such as (x, y); with several tasks a dict of targets by name.
            q0: where to start, (nq,); the robot's neutral configuration by default. Outside the limits it is led back.
            restarts: how many other starts to try, drawn within the limits, when q0 does not lead to the target. An
                attempt that does not get nearer is then given up early; if none arrives, the nearest one is the answer.
            seed: which other starts; the same seed gives the same answer. None is 0.
            max_iterations: most steps to try in an attempt.
            position_tolerance: norm of the position error to reach [m].
            orientation_tolerance: norm of the orientation error to reach [rad].
            optimality_tolerance: norm of (I - J+ J) dH/dv to reach, relative to max(1, |dH/dv|).
            until: "stationary" goes on until the criterion cannot fall further, "reached" stops on arrival.
            trace: keep every iteration in ``solution.trace``.

        Raises:
            ArgumentError: for an argument of wrong shape, NaN or infinity, naming it.
        """
        begin = time.perf_counter()
        self._target[:] = self.tasks.read_target(target)
        tolerances = position_tolerance, orientation_tolerance, optimality_tolerance
        options = (restarts, seed, max_iterations, *tolerances, until)
        if options == self._prepared and not trace:
            solution = self._at_once(q0, begin)
            if solution is not None:
                return solution
        start = self._configuration("q0", q0)
        request = self._requested(*options)
        recorder = TraceRecorder(self._recording()) if trace else None
        found, status, look = self._found(start, request, recorder)
        return Solution.of(
            q=found.q,
            status=status,
            converged=status is Status.CONVERGED or is_success(status, until),
            iterations=found.iterations,
            escapes=found.escapes,
            restarts=found.restarts,
            seconds=time.perf_counter() - begin,
            look=look,
            trace=recorder.trace(found.q, lambda at: self._diagnosis.error(at, self._inputs)) if recorder else None,
        )

    def solve_batch(
        self,
        targets: Iterable[Any],
        *,
        q0: ArrayLike | None = None,
        restarts: int = 0,
        seed: int | None = None,
        max_iterations: int = 1000,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
        optimality_tolerance: float = 1e-6,
        until: Until = "stationary",
        progress: Progress = False,
    ) -> SolutionBatch:
        """Solve for many targets, each by itself; the figures of all Solutions as arrays.

        Args:
            targets: what the task reads as one, each; an array (k, 4, 4) is k poses.
            q0: where to start, one configuration (nq,) for all or one each, (k, nq).
            restarts, seed, max_iterations, position_tolerance, orientation_tolerance, optimality_tolerance, until: of
                each, as in `solve`.
            progress: True for a bar on the terminal, or a function called with (done, total).

        Raises:
            ArgumentError: for an argument of wrong shape, NaN or infinity, naming it, such as ``targets[3]``.
            MissingExtraError: for a bar without rich.
        """
        numbers = read_targets(self.tasks, targets)
        if q0 is None or np.ndim(q0) <= 1:
            starts = [self._configuration("q0", q0)]
        else:
            table = finite_array("q0", q0, (len(numbers), self.robot.nq))
            starts = [self._configuration(f"q0[{i}]", q) for i, q in enumerate(table)]
        tolerances = position_tolerance, orientation_tolerance, optimality_tolerance
        request = self._requested(restarts, seed, max_iterations, *tolerances, until)

        table = np.array(numbers).reshape(len(numbers), len(self._target))
        done = self._search.find_all(table, np.array(starts), request) if progress is False else None

        def solve(i: int) -> Entry:
            begin = time.perf_counter()
            self._target[:] = numbers[i]
            found, seconds = done[i] if done else (None, 0.0)
            if found is None:
                found, status, _ = self._found(starts[i % len(starts)], request)
            else:
                status = self._status(found)
            seconds += time.perf_counter() - begin
            errors = found.errors or self._diagnosis.errors(found.q, self._inputs)
            return Entry(found, status, is_success(status, until), errors, seconds)

        inputs = self._memory.views(self._memory.numbers.copy())
        return collect(
            [solve(i) for i in watched(range(len(numbers)), progress, "targets")],
            targets=numbers,
            nq=self.robot.nq,
            look=lambda q, target: self._diagnosis.report(q, inputs._replace(target=target)),
        )

    def _requested(self, *options: Any) -> Request:
        """What a solve may spend, and its tolerances where the step reads them; read anew only when they change."""
        if self._options != options:
            self._options = self._prepared = ()
            self._request = read_request(*options[:3])
            self._inputs.settings[:] = read_settings(*options[3:])
            self._options = options
            if not self._problem.has_criterion and self._search.prepare(self._request):
                self._prepared = options
        return self._request

    def _at_once(self, q0: ArrayLike | None, begin: float) -> Solution | None:
        """The usual solve of a compiled solver without a criterion, in as little Python as there can be.

        None where anything is not usual: q0, or how the search in C ended.
        """
        start = self.robot.neutral if q0 is None else q0
        native = self._search.native
        if native is None or type(start) is not np.ndarray or start.shape != native.q0.shape:
            return None
        native.q0[:] = start
        if native.again() != Code.DONE:
            return None
        iterations, restarts, at = native.tally.tolist()
        q = native.runner.q[at].copy()
        return Solution.of(
            q=q,
            status=Status.CONVERGED,
            converged=True,
            iterations=iterations,
            escapes=0,
            restarts=restarts,
            seconds=time.perf_counter() - begin,
            look=partial(self._reported, q, self._memory.numbers.copy()),
            trace=None,
        )

    def _found(
        self, start: Array, request: Request, recorder: TraceRecorder | None = None
    ) -> tuple[Found, Status, Callable[[], Report]]:
        """Search for the target that is in memory; where it ended, why, and how to look at it."""
        if recorder or request.limit == 0:
            start = self._led_back(start)  # else the step does it
        found = self._search.find(recorder.runner if recorder else self._runner, start, request, recorder)
        look = self._later(found.q)
        return found, self._diagnosis.status(found.q, found.code, look, self._inputs), look

    def _status(self, found: Found) -> Status:
        """Why a search for the target that is in memory ended."""
        look = partial(self._diagnosis.report, found.q, self._inputs)
        return self._diagnosis.status(found.q, found.code, look, self._inputs)

    def _later(self, q: Array) -> Callable[[], Report]:
        """The report of ``q`` for the target and parameters as they are now, evaluated once and when called."""
        return partial(self._reported, q, self._memory.numbers.copy())

    def _reported(self, q: Array, memory: Array) -> Report:
        return self._diagnosis.report(q, self._memory.views(memory))

    def step(self, q: ArrayLike, target: Any, *, dt: float | None = None) -> Step:
        """One update from ``q``, for controllers; what the strategy remembers goes on from the last call.

        A refused step leaves q where it is and the next call tries a smaller one. ``reset()`` forgets the past. A step
        is done at the default tolerances of ``solve``, with the criterion stationary.

        With ``dt`` the limits of velocity and acceleration hold, too, from ``q`` to the answer and from the last step
        with a ``dt`` to this one, and a joint is never so fast that it could not stop before its position limits. A
        joint that moves cannot stop at once: a refused step then is the nearest to stopping. Steps with and without a
        ``dt`` do not know of each other.

        Args:
            q: configuration, (nq,). Outside the limits it is led back, with ``dt`` as fast as they allow.
            target: what the task reads as one.
            dt: how long the step takes [s]; None for as long as it needs.

        Raises:
            ArgumentError: for an argument of wrong shape, NaN or infinity, naming it, or a time that is not positive.
        """
        if dt is None:
            runner, box = self._stepper or self._stepping(), None
        else:
            runner, box = self._timed or self._timing()
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
        if box is not None and dt is not None:
            box.narrow(memory, dt)
        runner.calls[at]()
        after = runner.q[1 - at]
        code, tried, accepted, position, orientation, _ = runner.view
        if tried:
            runner.at = 1 - at
        elif code == Code.NOT_FINITE:  # whose fault? the arrays above were taken unread
            self._configuration("q", q)
            self.tasks.read_target(target)
        errors: tuple[float, float] = position, orientation
        moved, done, escaped = accepted == 1.0, code == 1.0, False
        if code == Code.STALLED:
            escaped = self._rescue.escape(after, runner.inputs)
            runner.start(after)
            moved, errors = False, self._diagnosis.errors(after, runner.inputs)
        if box is not None:
            allowed = box.slowed(after)
            if allowed is not after:
                after, done, errors = allowed, False, self._diagnosis.errors(allowed, runner.inputs)
            box.moved(after)
        return Step(after.copy(), *errors, moved, done, escaped)

    def build(self, q: ArrayLike, target: Any, *, program: str | None = None) -> qpsolvers.Problem:
        """The quadratic program of a first step from ``q``, to look at or to solve elsewhere.

        Args:
            q: configuration, (nq,).
            target: what the task reads as one.
            program: which one, of a strategy that has several; the first by default.

        Raises:
            ArgumentError: for an argument of wrong shape, NaN or infinity, or a strategy without a program.
            UnknownNameError: when there is no such program.
        """
        parts = self._runner.fused.parts
        if parts is None:
            raise ArgumentError(
                "strategy", self.strategy, "one that solves programs, such as 'newton+qp' with a criterion"
            )
        self._target[:] = self.tasks.read_target(target)
        start = self._led_back(self._configuration("q", q))
        numbers = parts.program(program, [start, *self._step_inputs, self._runner.first_state])
        problem: qpsolvers.Problem = as_problem(numbers)[0]
        return problem

    def reset(self) -> None:
        """Forget what ``step`` remembers of earlier calls, as after a jump of the target; the robot stands still."""
        if self._stepper is not None:
            self._stepper.start(self.robot.neutral)
        if self._timed is not None:
            self._timed[0].start(self.robot.neutral)
            self._timed[1].rest()

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

        Limits of velocity and acceleration hold from one target to the next, from rest at q0; a target that they keep
        out of reach is followed as far as they allow. They look ahead to the position limits, not to targets to come:
        where acceleration is limited, a path that stops at once is overshot. Options are those of ``solve``;
        ``until="stationary"`` also lets the criterion settle at each target.

        Raises:
            ArgumentError: for an argument of wrong shape, NaN or infinity, naming it.
        """
        wanted = list(targets)
        if not wanted:
            raise ArgumentError("targets", "none", "at least one target")
        read_targets(self.tasks, wanted)

        def solve(target: Any, start: Array) -> Solution:
            return self.solve(
                target,
                q0=start,
                max_iterations=max_iterations,
                position_tolerance=position_tolerance,
                orientation_tolerance=orientation_tolerance,
                optimality_tolerance=optimality_tolerance,
                until=until,
            )

        start, dt = self._configuration("q0", q0), positive("dt", dt)
        box = StepBox(self._bounds, self._box_function, self._lower, self._upper)
        return follow(self.robot, wanted, start, dt, box, solve, self._told_of)

    def _told_of(self, solution: Solution, q: Array) -> Solution:
        """The solution, told of another configuration for the same target."""
        look = self._later(q)
        return replace(solution, q=q, look=look, status=self._diagnosis.status(q, Code.GO_ON, look, self._inputs))

    def _configuration(self, argument: str, q: ArrayLike | None) -> Array:
        """The configuration given, checked; raises ArgumentError for a wrong shape, NaN or a zero quaternion."""
        if q is None:
            return self.robot.neutral
        if self._plain_q and type(q) is np.ndarray and q.shape == (self.robot.nq,) and q.dtype == np.float64:
            usual: Array = q
            if math.isfinite(usual.sum()):
                return usual
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

    def _fused(self, *, arriving: bool = False) -> FusedStep:
        fused = fused_step(self._problem, self.strategy, backend=self._backend, arriving=arriving)
        return fused.compiled(native.source(fused.state)) if self._compiled else fused

    def _stepping(self) -> Runner:
        """What ``step`` runs: it reports the errors where it arrives, whether or not the strategy looks at them."""
        self._stepper = Runner(self._arriving, self._step_inputs, self.robot.nq)
        self._stepper.start(self.robot.neutral)
        return self._stepper

    def _timing(self) -> tuple[Runner, StepBox]:
        """What ``step`` runs in a given time: the same on a box of its own."""
        lower, upper = self._lower.copy(), self._upper.copy()
        runner = Runner(self._arriving, self._step_inputs._replace(lower=lower, upper=upper), self.robot.nq)
        runner.start(self.robot.neutral)
        self._timed = runner, StepBox(self._bounds, self._box_function, lower, upper)
        return self._timed

    @cached_property
    def _arriving(self) -> FusedStep:
        """The fused step whose errors are those where it arrives."""
        judged = self.strategy.evaluates_candidate(self._problem.has_criterion)
        return self._runner.fused if judged else self._fused(arriving=True)

    @cached_property
    def _box_function(self) -> Function:
        box = box_function(self._bounds)
        return to_c(box) if self._compiled else box

    def _yielded(self, q: Array, inputs: Inputs[Array]) -> tuple[Relaxation, ...]:
        """What a first step from q cannot have."""
        if self._witness is None:
            fused = self._recording().fused
            self._witness = Runner(fused, Inputs(*[np.zeros_like(part) for part in inputs]), self.robot.nq)
        for memory, part in zip(self._witness.inputs, inputs, strict=True):
            memory[:] = part
        self._witness.start(q)
        self._witness.calls[0]()
        fused = self._witness.fused
        if self._witness.view[0] == Code.UNSOLVED:
            return ()
        return fused.yielding.told(self._witness.record[fused.record.slices["relaxed"]])

    def _recording(self) -> Runner:
        if self._recorder is None:
            fused = fused_step(self._problem, self.strategy, backend=self._backend, recorded=True)
            self._recorder = Runner(fused, self._inputs, self.robot.nq)
        return self._recorder

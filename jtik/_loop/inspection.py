"""The inspection of a configuration: its report, its status and its relaxations, each computed when it is read."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cached_property, partial
from typing import Any

import numpy as np

from jtik._loop.escapes.saddle import FLAT, NEGATIVE, SaddleEscape
from jtik._loop.minimum_certificate import MinimumCertificate
from jtik._loop.runners import Runners
from jtik._loop.task_alone import TaskAlone
from jtik._step.distant_target import is_distant
from jtik._step.inputs import Inputs, Settings
from jtik._step.stopping import Code
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.limits import AT_LIMIT
from jtik.result.length import length
from jtik.result.levels import Levels
from jtik.result.relaxation import Relaxation
from jtik.result.report import Report
from jtik.result.status import Status
from jtik.symbolic.compile import CompiledFunction
from jtik.symbolic.factorization import RANK_THRESHOLD
from jtik.types import Array

FALLS = 1e-2
"""|J' r| / (|J| |r|) above which the error would fall without the criterion: no minimum of the error is near."""

NEARLY_FLAT = 1e-3
"""|J' r| / (|J| |r|) below which a distant target counts as approached as far as it can be, and others may."""

APPROACH = 1e-5
"""Possible decrease of V relative to |J| |r| [rad] below which it is no approach: a motion of so many rad makes it."""

BESIDE_LOWER_LEVELS = 5e-4
"""The same of the highest level of priority beside lower ones, whose steps keep it from coming nearer [rad]."""

SHARE = 1e-3
"""Possible decrease of V relative to V below which it may be none: more of an error as small as `APPROACH`."""

LARGER = 3.0
"""How much larger the gradient has to be with the joints at limits than without them to be that of the limits."""


class Inspector:
    """Evaluates a problem at a configuration, for given inputs.

    A report may be read in a thread other than the one that solves: the two evaluations then run one after the other.
    """

    def __init__(
        self, problem: SymbolicProblem, escape: SaddleEscape, certificate: MinimumCertificate, runners: Runners
    ) -> None:
        self._problem, self._runners = problem, runners
        self._escape, self._certificate = escape, certificate
        self._evaluate = CompiledFunction(problem.once("report", problem.report))
        self._error = CompiledFunction(problem.error)
        self._task_alone = TaskAlone(problem, self._error_for)
        self._linear = np.array(problem.linear, dtype=bool)
        self._q_index = np.array([i for i, _ in problem.scalar], dtype=int)
        self._v_index = np.array([j for _, j in problem.scalar], dtype=int)
        self._criteria = [name for name, _, _ in problem.terms.named]
        robot = problem.robot
        self._joints = {robot.v_slice(name).start: name for name in robot.joint_names}
        self._lock = threading.RLock()

    @cached_property
    def _clearance(self) -> CompiledFunction:
        return CompiledFunction(self._problem.measured.clearance)

    @cached_property
    def _hessian(self) -> CompiledFunction:
        return CompiledFunction(self._problem.once("hessian", self._problem.hessian))

    def warm_up(self) -> None:
        """Build the functions that a `status` needs."""
        if self._problem.clearances:
            _ = self._clearance
        if self._criteria:
            self._certificate.warm_up()
            _ = self._hessian

    def snapshot(self, q: Array, target: Any, box: tuple[Array, Array] | None = None) -> Inspection:
        """The inspection of ``q`` for the target and parameters as they are now, whatever is solved or changed next.

        Args:
            q: configuration, (nq,).
            target: the target as it was given.
            box: limits (nq,) and (nq,) in force instead of those in memory.
        """
        numbers = self._runners.memory.numbers.copy()
        if box is not None:
            inputs = self._runners.memory.views(numbers)
            inputs.lower[:], inputs.upper[:] = box
        return Inspection(self, q.copy(), numbers, target)

    def current(self, q: Array) -> Inspection:
        """The inspection of ``q``, to be used before the inputs change."""
        return Inspection(self, q, self._runners.memory.numbers, None)

    def report(self, q: Array, numbers: Array, target: Any) -> Report:
        """The report of ``q``.

        Args:
            q: configuration, (nq,).
            numbers: the inputs, one after the other, as in `InputMemory`.
            target: the target as it was given, for the report's ``unused``; None to leave that out.
        """
        return self.evaluated(q, self._runners.memory.views(numbers), target)

    def saddle(self, q: Array, inputs: Inputs[Array], report: Callable[[], Report] | None = None) -> Report | None:
        """The report of q where H is stationary, but not minimal, on the self-motion; None elsewhere.

        Args:
            q: configuration, (nq,), where H is stationary.
            inputs: target, parameters, limits and settings.
            report: what computes its report, which is read only where the certificate does not decide.
        """
        with self._lock:
            if self._certificate(q, inputs):
                return None
        found = report() if report else self.evaluated(q, inputs)
        return found if found.second_order == "saddle" else None

    def evaluated(self, q: Array, inputs: Inputs[Array], target: Any = None) -> Report:
        """The report of ``q`` for these inputs; ``target`` as in `report`."""
        with self._lock:
            evaluated = self._evaluate(q, inputs.target, inputs.parameters)
        error, jacobian, values, gradient, residual, weighted = evaluated
        at_upper: tuple[int, ...] = ()
        at_lower: tuple[int, ...] = ()
        if self._q_index.size:
            own = q[self._q_index]
            at_upper = tuple(self._v_index[own >= inputs.upper[self._q_index] - AT_LIMIT].tolist())
            at_lower = tuple(self._v_index[own <= inputs.lower[self._q_index] + AT_LIMIT].tolist())
        settings = Settings(*inputs.settings.tolist())
        relaxes = bool(self._runners.relaxation.entries)
        levels = None
        if self._runners.respects_priority and len(self._problem.levels) > 1:
            levels = Levels(
                rows=self._problem.levels,
                tasks=self._problem.tasks.row_indices,
                error=error[:, 0],
                linear=self._linear,
                residual=residual[:, 0],
                weighted=weighted,
                limits=(at_upper, at_lower),
                tolerances=(settings.position_tolerance, settings.orientation_tolerance),
                rank_threshold=RANK_THRESHOLD,
            )
        return Report(
            error=error[:, 0],
            jacobian=jacobian,
            linear=self._linear,
            residual=residual[:, 0],
            weighted=weighted,
            values=dict(zip(self._criteria, values[:, 0].tolist(), strict=True)),
            gradient=gradient[:, 0],
            at_upper=at_upper,
            at_lower=at_lower,
            active_limits=tuple(self._joints[j] for j in sorted({*at_upper, *at_lower})),
            tolerances=(settings.position_tolerance, settings.orientation_tolerance, settings.optimality_tolerance),
            rank_threshold=RANK_THRESHOLD,
            unused_part=None if target is None else partial(self._problem.tasks.unused, target),
            curvature=partial(self._curvature, q, inputs) if self._criteria else None,
            relaxations=partial(self._relaxations, q, inputs) if relaxes else None,
            close_pairs=partial(self._close_pairs, q, inputs) if self._problem.clearances else None,
            levels=levels,
        )

    def errors(self, q: Array, inputs: Inputs[Array]) -> tuple[float, float]:
        """Norms of the position rows [m] and of the orientation rows [rad] at q."""
        error = self.error(q, inputs)
        return length(error[self._linear]), length(error[~self._linear])

    def error(self, q: Array, inputs: Inputs[Array]) -> Array:
        """The task error at q, (m,)."""
        return self._error_for(q, inputs.target)

    def _error_for(self, q: Array, target: Array) -> Array:
        with self._lock:
            return self._error(q, target)[0][:, 0]

    def status(self, q: Array, code: Code, numbers: Array, report: Callable[[], Report]) -> Status:
        """Why a solve ended at ``q`` with the last code of its steps: the first of the statuses below that applies."""
        if code is Code.DONE and not self._criteria:
            return Status.CONVERGED  # the step has checked this
        found = report()
        if code is Code.NOT_FINITE or not found.finite:
            return Status.NOT_FINITE
        if code is Code.UNSOLVED and not found.reached:
            return Status.UNSOLVED
        if found.reached:
            # the report does not consider clearances, which may prevent the criterion from falling; the step does
            stationary = code is Code.DONE if self._problem.clearances else found.stationary
            if self._criteria and not stationary:
                return Status.REACHED
            saddle = self._criteria and self.saddle(q, self._runners.memory.views(numbers), report)
            return Status.SADDLE if saddle else Status.CONVERGED
        at_limit, inputs = code is Code.CONTINUE, self._runners.memory.views(numbers)
        of_all, of_free = found.relative_gradient
        if code is Code.COMPROMISE and self._task_alone_reaches(found, q, inputs):
            return Status.COMPROMISE
        if found.active_clearances:
            return Status.ITERATION_LIMIT if at_limit else Status.BLOCKED
        if found.prioritized:
            return Status.PRIORITIES
        if code is Code.COMPROMISE and of_free > FALLS:
            return Status.COMPROMISE
        # of task and criterion, but that is not what keeps the task from its target
        if code is Code.COMPROMISE and self._task_alone.reaches(found, q, inputs.target) is not None:
            return Status.LIMITS
        nearly = is_distant(self._problem, found.residual) or (of_free > FLAT and self._is_as_near(found, q, inputs))
        flat = NEARLY_FLAT if nearly else FLAT
        if code is not Code.COMPROMISE:
            if of_free > flat:
                of_highest = self._of_highest_level(found, q, inputs)
                return of_highest or (Status.ITERATION_LIMIT if at_limit else Status.STALLED)
            if of_all > (max(FLAT, LARGER * of_free) if nearly else FLAT):
                return Status.LIMITS
        lowest = self._escape.lowest_curvature(q, inputs, flat)[0]
        # close to a minimum, an eigenvalue that is zero at the minimum can be as negative as the relative gradient
        if lowest > -max(NEGATIVE, of_all, flat if nearly else 0):
            return Status.LOCAL_MINIMUM
        return Status.ITERATION_LIMIT if at_limit else Status.SINGULAR

    def _is_as_near(self, found: Report, q: Array, inputs: Inputs[Array]) -> bool:
        """Whether q is as near as it can be but for what is no approach, where the gradient nearly vanishes."""
        if found.levels or found.relative_gradient[1] > NEARLY_FLAT:
            return False
        r, J = length(found.residual), length(found.weighted)
        return self._escape.possible_decrease(q, inputs) <= min(APPROACH * J * r, SHARE * r**2 / 2)

    def _of_highest_level(self, found: Report, q: Array, inputs: Inputs[Array]) -> Status | None:
        """LOCAL_MINIMUM or LIMITS where the highest level is off its target and nearly as near as it can be; else None.

        The lower levels then have a freedom beside it to first order only, and a solve may go on for ever.
        """
        if not found.levels or found.levels.reached:
            return None
        rows = list(found.levels.rows[0])
        J, residual = found.weighted[rows], found.residual[rows]
        r = length(residual)
        most = min(BESIDE_LOWER_LEVELS * length(J) * r, SHARE * r**2 / 2)
        if self._escape.possible_decrease(q, inputs, highest_level=True) > most:
            return None
        gradient = J.T @ residual
        pushed = [j for j in found.at_upper if gradient[j] < 0] + [j for j in found.at_lower if gradient[j] > 0]
        of_limits = length(gradient[pushed])
        return Status.LIMITS if of_limits > FLAT * length(J) * r else Status.LOCAL_MINIMUM

    def _task_alone_reaches(self, found: Report, q: Array, inputs: Inputs[Array]) -> bool:
        """Whether a step of the task alone that keeps limits and clearances removes most of the error at q."""
        end = self._task_alone.reaches(found, q, inputs.target, (inputs.lower, inputs.upper))
        if end is None or not self._problem.clearances:
            return end is not None
        with self._lock:
            before, after = (self._clearance(at, inputs.parameters) for at in (q, end))
        return bool((after[0] >= np.minimum(before[0], before[2][:, :1])).all())

    def _curvature(self, q: Array, inputs: Inputs[Array], multipliers: Array) -> Array:
        """The Hessian of the Lagrangian, (n, n)."""
        with self._lock:
            return self._hessian(q, inputs.target, inputs.parameters, multipliers)[0]

    def _close_pairs(self, q: Array, inputs: Inputs[Array]) -> tuple[str, ...]:
        """Names of the distances that are about as small as their constraints allow."""
        with self._lock:
            distance, _, figures = self._clearance(q, inputs.parameters)
        margin = figures[:, 1] - figures[:, 0]
        close = distance[:, 0] < figures[:, 1] + margin
        return tuple(name for name, is_close in zip(self._problem.measured.pairs, close, strict=True) if is_close)

    def _relaxations(self, q: Array, inputs: Inputs[Array]) -> tuple[Relaxation, ...]:
        """What the strategy's first step from q relaxes."""
        with self._lock:
            runner = self._runners.inspection
            for memory, part in zip(runner.inputs, inputs, strict=True):
                memory[:] = part
            runner.start(q)
            runner.calls[0]()
            if runner.view[0] == Code.UNSOLVED:
                return ()
            return self._runners.relaxation.relaxed(runner.record[runner.fused.record.slices["relaxed"]])


class Inspection:
    """The report and the status of one configuration, computed when needed. Calling it returns its `report`.

    Attributes:
        q: the configuration, (nq,).
    """

    def __init__(self, inspector: Inspector, q: Array, numbers: Array, target: Any) -> None:
        self._inspector, self.q, self._numbers, self._target = inspector, q, numbers, target

    @cached_property
    def report(self) -> Report:
        """Task and criteria at the configuration, as numbers."""
        return self._inspector.report(self.q, self._numbers, self._target)

    def __call__(self) -> Report:
        """The `report`."""
        return self.report

    def status(self, code: Code) -> Status:
        """Why a solve whose last code was ``code`` ended at the configuration."""
        return self._inspector.status(self.q, code, self._numbers, self)

"""When a solve ends: tests of the error and of stationarity, and the code that the fused function returns."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from jtik._step.active_set import ActiveSet
from jtik._step.inputs import Settings
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.strategy import Evaluation, FeasibilityRestoration, LocalModel
from jtik.symbolic import Expression, fmax, if_else, logic_and, logic_not, logic_or, norm, vertcat

STATIONARY = 1e-9
"""The task is stationary where |J' r| is below this fraction of |J| |r|."""

FLAT = 1e-5
"""The same fraction up to which a status calls the task stationary."""


class Code(IntEnum):
    """What the loop does after a call of the fused function.

    Attributes:
        CONTINUE: call it again.
        DONE: the target is reached, and the criterion is stationary if that is required.
        STALLED: the task is stationary off the target, or steps are refused or without progress.
        NOT_FINITE: task, criterion or a derivative is not finite.
        SLOW: the patience of the attempt is used up.
        UNSOLVED: a quadratic program or a computation has no valid result.
        COMPROMISE: a weighted sum of V and H is stationary off the target.
    """

    CONTINUE = 0
    DONE = 1
    STALLED = 2
    NOT_FINITE = 3
    SLOW = 4
    UNSOLVED = 5
    COMPROMISE = 6


class StepOutcome(NamedTuple):
    """What the fused function returns besides q and state.

    Attributes:
        code: a `Code`.
        tried: 1 if a step was tried, 0 if there was nothing to do.
        accepted: 1 if the step was taken.
        position_error: norm of the position rows of the error [m].
        orientation_error: norm of the orientation rows of the error [rad].
        V: the Lyapunov function of the task.
    """

    code: Any
    tried: Any
    accepted: Any
    position_error: Any
    orientation_error: Any
    V: Any


OUTCOME = StepOutcome(*range(len(StepOutcome._fields)))
"""Position of each number within the fused function's ``outcome``, by name."""


class Stop:
    """The tests of the error and of stationarity.

    Args:
        problem: the problem.
        model: its local model.
        settings: tolerances, as expressions.
        active: the active set; None without limits.
        stationarity_residual: the strategy's stationarity residual of H; None for that of the model.
        restoration: the feasibility restoration; None if nothing is restored.
        compromise_residual: the stationarity residual of the strategy's weighted sum of V and H; None without one.
        gradient_finite: 1 where the gradient of the criterion is finite; where not, the criterion is not stationary.
        replaceable: whether a restart replaces the attempt, which then need not know that the task is stationary.

    Attributes:
        errors_before: norms of the position rows [m] and of the orientation rows [rad] before the step.
        reached_before: 1 if they are within the tolerances.
        done_before: 1 if the solve ends without a step.
        stationary: 1 if the task is stationary off the target.
        compromise: 1 if the weighted sum is stationary off the target; None without one.
        flat: 1 if it is as far as a status can tell: a solve may end there without progress.
    """

    def __init__(
        self,
        problem: SymbolicProblem,
        model: LocalModel,
        settings: Settings,
        active: ActiveSet | None,
        stationarity_residual: Expression | None,
        restoration: FeasibilityRestoration | None = None,
        compromise_residual: Expression | None = None,
        gradient_finite: Expression = 1,
        *,
        replaceable: bool = False,
    ) -> None:
        self._restoration = restoration
        self._problem, self._settings = problem, settings
        self._unweight = np.linalg.inv(problem.factor.T)
        self.errors_before = self.errors(model.here)
        self.reached_before = self._reached(self.errors_before)
        self.done_before = self.reached_before
        gradient_norm = active.task_gradient_norm if active else model.task_gradient_norm
        scale = model.jacobian_norm * norm(model.here.residual)
        vanishes, self.flat = gradient_norm <= STATIONARY * scale, gradient_norm <= FLAT * scale
        self.stationary = 0 if replaceable else logic_and(vanishes, logic_not(self.reached_before))
        self.compromise: Expression | None = None
        if problem.has_criterion:
            residual = stationarity_residual
            if residual is None:
                residual = active.stationarity_residual(model) if active else model.stationarity_residual
                asked = logic_and(self.reached_before, settings.until_stationary != 0)
                residual = if_else(asked, residual, math.inf)
            size = model.joint_gradient_norm(model.gradient_free, model.gradient_norm)
            largest = settings.optimality_tolerance * fmax(1, size)
            small = logic_and(gradient_finite, residual <= largest)
            if compromise_residual is not None:
                balanced = logic_and(gradient_finite, compromise_residual <= largest)
                self.compromise = logic_and(balanced, logic_not(self.reached_before))
                small = logic_or(small, balanced)
            self.done_before = logic_and(self.reached_before, logic_or(small, settings.until_stationary == 0))
        if restoration:
            restored = logic_or(logic_not(restoration.pending), settings.until_stationary == 0)
            self.done_before = logic_and(self.done_before, restored)
            self.stationary = logic_and(self.stationary, logic_not(restoration.pending))
            if self.compromise is not None:
                self.compromise = logic_and(self.compromise, logic_not(restoration.pending))

    def errors(self, point: Evaluation) -> tuple[Expression, Expression]:
        """Norm of the position rows [m] and of the orientation rows [rad] of the error."""
        error = self._unweight @ point.to_target
        rows = range(self._problem.m)
        linear = [error[i] for i in rows if self._problem.linear[i]]
        angular = [error[i] for i in rows if not self._problem.linear[i]]
        return norm(vertcat(*linear)) if linear else 0, norm(vertcat(*angular)) if angular else 0

    def _reached(self, errors: tuple[Expression, Expression]) -> Expression:
        position, orientation = errors
        settings = self._settings
        return logic_and(position <= settings.position_tolerance, orientation <= settings.orientation_tolerance)

    def reached_after(self, point: Evaluation) -> Expression:
        """Whether the errors at ``point`` are within the tolerances."""
        return self._reached(self.errors(point))

    def done_after(self, point: Evaluation) -> Expression:
        """Whether the solve ends at ``point`` without another test of the criterion."""
        reached = self.reached_after(point)
        waits = self._problem.has_criterion or self._restoration
        return logic_and(reached, self._settings.until_stationary == 0) if waits else reached

"""When a solve ends: the tolerances that the fused function reads, its tests of arrival, and the code it answers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from jtik._step.active_set import ActiveSet
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.strategy import LocalModel, Point
from jtik.strategy.feasibility_restoration import Recovery
from jtik.symbolic import Expression, fmax, logic_and, logic_not, logic_or, norm, vertcat

STATIONARY = 1e-9
"""The task is stationary where |J' r| is below this fraction of |J| |r|."""


class Code(IntEnum):
    """What the fused function says of the next call."""

    GO_ON = 0
    DONE = 1
    STALLED = 2
    NOT_FINITE = 3
    SLOW = 4
    UNSOLVED = 5


class Settings(NamedTuple):
    """The numbers of a solve that may change from one to the next, as the fused function reads them.

    Attributes: tolerances of position [m], orientation [rad] and optimality; 1 to wait until the criterion is
    stationary; how many calls without progress are too many.
    """

    position: float = 1e-6
    orientation: float = 1e-6
    optimality: float = 1e-6
    stationary: float = 1.0
    patience: float = math.inf


@dataclass(frozen=True)
class Outcome:
    """Positions within the fused function's ``outcome`` output."""

    code: int = 0
    tried: int = 1
    accepted: int = 2
    position_error: int = 3
    orientation_error: int = 4
    V: int = 5
    size: int = 6


OUTCOME = Outcome()


class Stop:
    """The tests of arrival, stationarity and stationarity.

    ``settings`` are a column of `Settings`.
    """

    def __init__(
        self,
        problem: SymbolicProblem,
        model: LocalModel,
        settings: Expression,
        working: ActiveSet | None,
        stationarity_residual: Expression | None,
        room: Recovery | None = None,
    ) -> None:
        self._room = room
        self._problem, self._settings = problem, settings
        self._unweight = np.linalg.inv(problem.factor.T)
        self.errors_before = self.errors(model.here)
        self.reached_before = self._reached(self.errors_before)
        self.done_before = self.reached_before
        slope = working.task_slope if working else model.task_slope
        flat = slope <= STATIONARY * model.jacobian_length * model.here.length
        self.stationary = logic_and(flat, logic_not(self.reached_before))
        if problem.has_criterion:
            if stationarity_residual is not None:
                residual = stationarity_residual
            else:
                residual = fmax(model.null_length, working.wrong(model)) if working else model.null_length
            still = residual <= settings[2] * fmax(1, model.gradient_length)
            self.done_before = logic_and(self.reached_before, logic_or(still, settings[3] == 0))
        if room:
            over = logic_or(logic_not(room.pending), settings[3] == 0)
            self.done_before = logic_and(self.done_before, over)
            self.stationary = logic_and(self.stationary, logic_not(room.pending))

    def errors(self, point: Point) -> tuple[Expression, Expression]:
        """Norm of the position rows [m] and of the orientation rows [rad] of the error."""
        error = self._unweight @ point.residual
        rows = range(self._problem.m)
        linear = [error[i] for i in rows if self._problem.linear[i]]
        angular = [error[i] for i in rows if not self._problem.linear[i]]
        return norm(vertcat(*linear)) if linear else 0, norm(vertcat(*angular)) if angular else 0

    def _reached(self, errors: tuple[Expression, Expression]) -> Expression:
        return logic_and(errors[0] <= self._settings[0], errors[1] <= self._settings[1])

    def done_after(self, point: Point) -> Expression:
        """Whether arriving there ends the solve without another look at the criterion."""
        reached = self._reached(self.errors(point))
        waits = self._problem.has_criterion or self._room
        return logic_and(reached, self._settings[3] == 0) if waits else reached

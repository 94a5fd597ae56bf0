"""Loop over libraries that make one step at a time: attempts, their stopping rules, and the best attempt."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Any

import numpy as np

from jtik.result.solution import Trace
from jtik.study.contender import Answer, PreparedContender
from jtik.study.peers.base import Goal
from jtik.types import Array

SETTLED = 1e-9
"""Length of a step below which an attempt is stationary [rad, m]."""

PATIENCE = 200
"""Maximum steps of an attempt that is not on target.

On two arms, no attempt of mink succeeded after more than 50 steps, and none of placo after more than 200.
"""

METRE = 4.0
"""Radians that count as much as a metre when failed attempts are compared."""


class StepLoop(PreparedContender):
    """A solve as attempts, each a loop of steps; a subclass makes a step with its library.

    Args:
        goal: the goal.
        restarted: maximum steps of an attempt that may not continue, if restarts are allowed; `PATIENCE` otherwise.

    Attributes:
        success_status: status of a successful attempt.
    """

    success_status = "REACHED"

    def __init__(self, goal: Goal, *, restarted: int) -> None:
        self.goal = goal
        self._max_steps = goal.setting.max_iterations
        self._patience = restarted if goal.setting.restarts else PATIENCE
        self._recorded: list[tuple[int, Array, float]] | None = None

    @abstractmethod
    def set_target(self, target: Any) -> None:
        """Set a converted target."""

    @abstractmethod
    def set_configuration(self, q: Array) -> None:
        """Set the library's configuration from (nq,)."""

    @abstractmethod
    def q(self) -> Array:
        """The current configuration (nq,)."""

    @abstractmethod
    def error(self) -> tuple[float, float]:
        """Norms of position and orientation error [m], [rad]; 0 for a part that the task does not have."""

    @abstractmethod
    def step(self) -> float | None:
        """Make one step and return its length; None if the library finds no step."""

    def is_stationary(self) -> bool:
        """Whether an attempt that is on target is complete."""
        return True

    def may_continue(self, position: float, orientation: float) -> bool:
        """Whether an attempt with these errors [m], [rad] may exceed the usual number of steps."""
        return self.goal.is_reached(position, orientation)

    def solve(self, target: Any, q0: Array) -> Answer:
        """Run attempts until one succeeds; otherwise return the attempt with the smallest error."""
        goal, taken = self.goal, 0
        self.set_target(target)
        best, smallest, status = np.asarray(q0), math.inf, "ITERATION_LIMIT"
        for number, start in enumerate(goal.starts(q0)):
            self.set_configuration(start)
            outcome, steps, errors = self._attempt(number)
            taken += steps
            if outcome == self.success_status:
                return Answer(goal.clamped_rounding(self.q()), outcome, True, taken)
            distance = METRE * errors[0] + errors[1]
            if distance < smallest:
                best, smallest, status = goal.clamped_rounding(self.q()), distance, outcome
        return Answer(best, status, False, taken)

    def _attempt(self, number: int) -> tuple[str, int, tuple[float, float]]:
        """Status, number of steps, and final errors of an attempt."""
        length = math.inf
        for steps in range(self._max_steps + 1):
            errors = self.error()
            if self._recorded is not None:
                self._recorded.append((number, self.q(), math.hypot(*errors)))
            reached = self.goal.is_reached(*errors)
            if reached and self.is_stationary():
                return self.success_status, steps, errors
            if length <= SETTLED:
                return "STALLED", steps, errors
            if steps == self._max_steps or (steps >= self._patience and not self.may_continue(*errors)):
                return "ITERATION_LIMIT", steps, errors
            found = self.step()
            if found is None:
                return "UNSOLVED", steps, errors
            length = found
        raise AssertionError("the last step returns")

    def traced(self, target: Any, q0: Array) -> tuple[Answer, Trace]:
        """Solve with a trace of configurations, error norms and attempt numbers."""
        self._recorded = []
        try:
            answer = self.solve(target, q0)
            attempts, q, error = zip(*self._recorded, strict=True)
        finally:
            self._recorded = None
        return answer, Trace(
            q=np.array(q), error=np.array(error), figures={"attempt": np.array(attempts[:-1], dtype=float)}
        )

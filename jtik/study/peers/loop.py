"""The loop round libraries that make one step at a time: attempts, their end, and the nearest of them."""

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
"""Length of a step [rad, m] with which an attempt has come to rest."""

PATIENCE = 200
"""Steps after which an attempt that is not on target is given up: on two arms none of mink's arrived after 50, and none
of placo's after 200, however long they went on."""

METRE = 4.0
"""How many radians count as much as a metre where attempts that failed are compared."""


class StepLoop(PreparedContender):
    """A solve as attempts of steps; a subclass says how its library makes one.

    Args:
        goal: what is asked.
        restarted: most steps of an attempt that is not may_continue where restarts are allowed; `PATIENCE` where not.
    """

    arrival = "REACHED"
    """The status of an attempt that has done what was asked."""

    def __init__(self, goal: Goal, *, restarted: int) -> None:
        self.goal = goal
        self._most = goal.setting.max_iterations
        self._patience = restarted if goal.setting.restarts else PATIENCE
        self._seen: list[tuple[int, Array, float]] | None = None

    @abstractmethod
    def set_target(self, target: Any) -> None:
        """Take a converted target."""

    @abstractmethod
    def set_configuration(self, q: Array) -> None:
        """Go to a configuration (nq,)."""

    @abstractmethod
    def q(self) -> Array:
        """Where the library is, (nq,)."""

    @abstractmethod
    def error(self) -> tuple[float, float]:
        """Norms of the errors there [m], [rad]; of what does not matter, 0."""

    @abstractmethod
    def step(self) -> float | None:
        """Make one step; its length, or None when the library finds none."""

    def is_stationary(self) -> bool:
        """Whether an attempt that is on target has done what was asked."""
        return True

    def may_continue(self, position: float, orientation: float) -> bool:
        """Whether an attempt with these errors [m], [rad] may go on beyond the usual number of steps."""
        return self.goal.is_reached(position, orientation)

    def solve(self, target: Any, q0: Array) -> Answer:
        """CaseRun after attempt until one arrives; else the nearest."""
        goal, taken = self.goal, 0
        self.set_target(target)
        nearest, least, status = np.asarray(q0), math.inf, "ITERATION_LIMIT"
        for number, start in enumerate(goal.starts(q0)):
            self.set_configuration(start)
            outcome, steps, errors = self._attempt(number)
            taken += steps
            if outcome == self.arrival:
                return Answer(goal.clamped_rounding(self.q()), outcome, True, taken)
            distance = METRE * errors[0] + errors[1]
            if distance < least:
                nearest, least, status = goal.clamped_rounding(self.q()), distance, outcome
        return Answer(nearest, status, False, taken)

    def _attempt(self, number: int) -> tuple[str, int, tuple[float, float]]:
        """Why it ended, its steps, and the errors then."""
        length = math.inf
        for steps in range(self._most + 1):
            errors = self.error()
            if self._seen is not None:
                self._seen.append((number, self.q(), math.hypot(*errors)))
            arrived = self.goal.is_reached(*errors)
            if arrived and self.is_stationary():
                return self.arrival, steps, errors
            if length <= SETTLED:
                return "STALLED", steps, errors
            if steps == self._most or (steps >= self._patience and not self.may_continue(*errors)):
                return "ITERATION_LIMIT", steps, errors
            found = self.step()
            if found is None:
                return "UNSOLVED", steps, errors
            length = found
        raise AssertionError("the last step returns")

    def traced(self, target: Any, q0: Array) -> tuple[Answer, Trace]:
        """The same, with every configuration and the norm of its error; of the figures only which attempt it was."""
        self._seen = []
        try:
            answer = self.solve(target, q0)
            attempts, q, error = zip(*self._seen, strict=True)
        finally:
            self._seen = None
        return answer, Trace(
            q=np.array(q), error=np.array(error), figures={"attempt": np.array(attempts[:-1], dtype=float)}
        )

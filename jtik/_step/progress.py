"""Progress of a solve: iterations without any, steps refused in a row, stagnation, and the code that follows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jtik._step.stopping import Code, Stop
from jtik._step.update import CheckedUpdate
from jtik.strategy import FeasibilityRestoration, LocalModel
from jtik.symbolic import Expression, if_else, logic_and, logic_not, logic_or
from jtik.types import Array

REFUSALS = 40
"""Refused steps in a row after which the solve has stalled: 2^-40 of the first step is below working precision."""

STAGNANT = 1e-10
"""Relative decrease of V below which a step brings no progress."""

STAGNATIONS = 20
"""Steps in a row without progress after which the solve has stalled."""

FALL = 0.8
"""An error below this share of the smallest so far is progress; ``patience`` counts the calls without any."""

NEVER = 1e300
"""Above every V that has been seen, before one has."""

CYCLING = 200
"""Calls without progress after which a strategy that accepts every step, or one with clearances, has stalled."""


def initial_progress(*, arriving: bool) -> dict[str, Array]:
    """The state of progress that a solve starts from."""
    state = {name: np.zeros(1) for name in ("refused", "stagnant", "idle")}
    state["best"] = np.full(1, NEVER)
    state["patience"] = np.full(1, math.inf)
    if not arriving:
        state["V"] = np.zeros(1)
    return state


@dataclass(frozen=True)
class Progress:
    """Progress up to the configuration of the step.

    Attributes:
        falls: 1 if V has fallen to a share of the smallest so far.
        idle: number of calls without such a fall.
        slow: 1 if there have been too many.
    """

    falls: Expression
    idle: Expression
    slow: Expression

    @classmethod
    def of(cls, model: LocalModel, state: Mapping[str, Expression], stop: Stop) -> Progress:
        """Before the step is tried."""
        falls = FALL**2 * state["best"] > model.here.V
        idle = if_else(falls, 0, state["idle"] + 1)
        return cls(falls, idle, logic_and(idle >= state["patience"], logic_not(stop.reached_before)))

    def after(
        self,
        model: LocalModel,
        state: Mapping[str, Expression],
        update: CheckedUpdate,
        accepted: Expression,
        stop: Stop,
        restoration: FeasibilityRestoration | None,
        *,
        arriving: bool,
    ) -> tuple[dict[str, Expression], Expression]:
        """The state of progress after the step, and whether the solve has stalled."""
        V = model.here.V
        after = {"best": if_else(self.falls, V, state["best"]), "idle": self.idle, "patience": state["patience"]}
        if arriving:
            stagnates = logic_and(accepted, V - update.candidate.V <= STAGNANT * V)
            if update.progress is not None:
                stagnates = logic_and(accepted, update.progress <= STAGNANT)
        else:
            stagnates = logic_and(state["V"] > 0, state["V"] - V <= STAGNANT * state["V"])
            stagnates = logic_or(stagnates, self.idle >= CYCLING)
            after["V"] = V
        if model.clearance:
            stagnates = logic_or(stagnates, self.idle >= CYCLING)
        if restoration:
            restores = restoration.accepts(update.dq, update.candidate.length)
            stagnates = logic_and(stagnates, logic_not(restores))
        refused = if_else(accepted, 0, state["refused"] + 1)
        stagnant = if_else(logic_and(stagnates, logic_not(stop.reached_before)), state["stagnant"] + 1, 0)
        stalled = logic_or(stop.stationary, logic_or(refused >= REFUSALS, stagnant >= STAGNATIONS))
        return after | {"refused": refused, "stagnant": stagnant}, stalled

    def code(self, done: Expression, stalled: Expression) -> Expression:
        """The code of a step whose numbers are finite."""
        slow = if_else(self.slow, Code.SLOW, Code.GO_ON)
        return if_else(done, Code.DONE, if_else(stalled, Code.STALLED, slow))

"""Progress of a solve: iterations without progress, refused steps in a row, stagnation, and the code of the step."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jtik._step.active_set import ActiveSet
from jtik._step.checked_update import CheckedUpdate
from jtik._step.stopping import Code, Stop
from jtik.strategy import FeasibilityRestoration, LocalModel
from jtik.symbolic import Expression, fabs, if_else, logic_and, logic_not, logic_or
from jtik.types import Array

REFUSALS = 40
"""Refused steps in a row after which the solve has stalled: 2^-40 of the first step is below working precision."""

STAGNANT = 1e-10
"""Relative decrease of V, and near the target also of H, below which a step brings no progress."""

STEEP = 1e-3
"""Share of `STAGNANT` where the task is not stationary: a slow descent goes on until it is."""

STAGNATIONS = 20
"""Steps in a row without progress after which the solve has stalled."""

FALL = 0.8
"""An error below this share of the smallest so far is progress; ``patience`` limits the calls without progress."""

FREE_FALL = 0.97
"""The same in an attempt that a restart can replace, while the task pushes no joint outward at a limit."""

STUCK = 10
"""Calls without progress after which exploring begins: more than the patience of an attempt that a restart replaces."""

UNKNOWN = 1e300
"""Smallest V before the first call: larger than any V."""

CYCLING = 200
"""Calls without progress after which a strategy that accepts every step, or one with clearances, has stalled."""


def initial_progress(*, evaluated: bool) -> dict[str, Array]:
    """The state of progress that a solve starts from."""
    state = {name: np.zeros(1) for name in ("refused", "stagnant", "without_progress")}
    state["best"] = np.full(1, UNKNOWN)
    state["patience"] = np.full(1, math.inf)
    if not evaluated:
        state["V"] = np.zeros(1)
    return state


@dataclass(frozen=True)
class Progress:
    """Progress up to the configuration of the step.

    Attributes:
        falls: 1 if V has fallen below `FALL` squared, or `FREE_FALL` squared, times the smallest V so far.
        without_progress: number of calls in a row in which it has not.
        slow: 1 if this number has reached the patience of the attempt.
    """

    falls: Expression
    without_progress: Expression
    slow: Expression

    @classmethod
    def of(
        cls, model: LocalModel, state: Mapping[str, Expression], stop: Stop, active: ActiveSet | None = None
    ) -> Progress:
        """The progress up to here, before the step is tried."""
        share: Expression = FALL**2
        if not model.timed:
            free = state["patience"] < STUCK
            if active:
                free = logic_and(free, logic_not(active.limits_task))
            share += free * (FREE_FALL**2 - FALL**2)
        falls = share * state["best"] > model.here.V_to_target
        without_progress = if_else(falls, 0, state["without_progress"] + 1)
        return cls(
            falls, without_progress, logic_and(without_progress >= state["patience"], logic_not(stop.reached_before))
        )

    def after(
        self,
        model: LocalModel,
        state: Mapping[str, Expression],
        update: CheckedUpdate,
        accepted: Expression,
        stop: Stop,
        restoration: FeasibilityRestoration | None,
        *,
        evaluated: bool,
    ) -> tuple[dict[str, Expression], Expression]:
        """The state of progress after the step, and whether the solve has stalled."""
        V = model.here.V_to_target
        after = {
            "best": if_else(self.falls, V, state["best"]),
            "without_progress": self.without_progress,
            "patience": state["patience"],
        }
        if evaluated:
            least = STAGNANT * if_else(stop.flat, 1, STEEP) * model.here.V
            stagnates = logic_and(accepted, model.here.decrease(update.candidate) <= least)
            if update.progress is not None:
                stagnates = logic_and(accepted, update.progress <= STAGNANT)
            if model.has_criterion:  # near the target the error may rise while a step lowers H
                decrease = model.here.H - update.candidate.H
                lowers = logic_and(model.near_target, decrease > STAGNANT * fabs(model.here.H))
                stagnates = logic_and(stagnates, logic_not(lowers))
        else:
            stagnates = logic_and(state["V"] > 0, state["V"] - V <= STAGNANT * state["V"])
            stagnates = logic_or(stagnates, self.without_progress >= CYCLING)
            after["V"] = V
        if model.clearance:
            stagnates = logic_or(stagnates, self.without_progress >= CYCLING)
        if restoration:
            restores = restoration.accepts(update.dq, update.candidate.length)
            stagnates = logic_and(stagnates, logic_not(restores))
        refused = if_else(accepted, 0, state["refused"] + 1)
        stagnant = if_else(logic_and(stagnates, logic_not(stop.reached_before)), state["stagnant"] + 1, 0)
        stalled = logic_or(stop.stationary, logic_or(refused >= REFUSALS, stagnant >= STAGNATIONS))
        return after | {"refused": refused, "stagnant": stagnant}, stalled

    def code(self, done: Expression, stalled: Expression, compromise: Expression | None = None) -> Expression:
        """The code of a step whose numbers are finite."""
        code = if_else(self.slow, Code.SLOW, Code.CONTINUE)
        if compromise is not None:
            code = if_else(compromise, Code.COMPROMISE, code)
        return if_else(done, Code.DONE, if_else(stalled, Code.STALLED, code))

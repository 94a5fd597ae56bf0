"""Strict priorities: a quadratic program a level, and none can spoil those above (formulations/lexicographic_qp.md)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from jtik import register_strategy
from jtik.errors import ArgumentError
from jtik.strategy import Acceptance, LocalModel, NullMove, Outcome, Shape, State, Strategy, Update
from jtik.symbolic import (
    Expression,
    diag,
    fmax,
    if_else,
    is_finite,
    logic_and,
    logic_not,
    logic_or,
    norm,
    zeros,
)
from jtik.types import Array
from jtik_formulations.strategies._parts.level_merit import LevelMerit
from jtik_formulations.strategies._parts.levels import descend
from jtik_formulations.strategies.qp_secondary import QPSecondary
from jtik_formulations.strategies.weighted_qp import capped

HARDER, SOFTER = 4.0, 0.25
"""What a refusal and an acceptance make of the damping that the law adds by itself."""

FIRST_BRAKE = 1e-4
"""Damping a first refusal adds, relative to |J|^2."""


@register_strategy("lexicographic_qp")
@dataclass(frozen=True, kw_only=True)
class LexicographicQP(Strategy):
    """Level by level, the best that the levels above leave possible within the limits; the criterion comes last.

    Level k minimises |r_k + J_k dq| over the box of the joint limits without a change of J_i dq of the levels i above
    it. Levels are the tasks' ``priority``, 0 the highest. Prefer it for several tasks that cannot all be met, and where
    a joint limit shall cost the lowest task first. Without limits and damping it is the recursive pseudo-inverse.

    Attributes:
        damping: of each level's step by its own error: lambda / (1/2 |error|^2), [1 / rad^2]; 0 for none.
        q_limit: most that each rotational joint moves for the tasks in a step [rad]; math.inf for no limit.
        backtracking: damp more until the penalty function falls. Without it every step is taken.
        secondary: the criterion's program.

    Source: Kanoun, Lamiraux and Wieber (2011); Escande, Mansard and Wieber (2014); Siciliano and Slotine (1991).
    """

    damping: float = 0.1
    q_limit: float = 0.5
    backtracking: bool = True
    secondary: QPSecondary = field(default_factory=QPSecondary)

    summary = "a QP for each level of priority, limits in all of them, the criterion below the last"
    source = "Kanoun, Lamiraux and Wieber 2011; Escande, Mansard and Wieber 2014"

    def __post_init__(self) -> None:
        if not 0 <= self.damping < math.inf:
            raise ArgumentError("damping", self.damping, "a finite number from 0")
        if not self.q_limit > 0:
            raise ArgumentError("q_limit", self.q_limit, "a positive angle [rad], math.inf for none")
        if not isinstance(self.secondary, QPSecondary):
            raise ArgumentError("secondary", self.secondary, "a QPSecondary: the other terms know nothing of limits")

    def acceptance(self) -> Acceptance:
        """``"merit"``: the penalty function falls, which for one level is V; ``"always"`` without backtracking."""
        return "merit" if self.backtracking else "always"

    def evaluates_candidate(self, has_criterion: bool) -> bool:
        """With backtracking, or for the criterion's own step length."""
        return self.backtracking or has_criterion

    def uses_qp(self, has_criterion: bool) -> bool:
        """One a level, and one for a criterion."""
        return True

    def supports_clearances(self) -> bool:
        """Its programs have the rows."""
        return True

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """Damping that refusals have added, weights of the levels, penalty, and what the secondary term remembers."""
        state = {"brake": np.zeros(1), "weights": np.zeros(shape.m), "penalty": np.zeros(1)}
        if shape.has_criterion or shape.has_clearance:
            state |= self.secondary.initial_state(shape)
        return state

    def update(self, model: LocalModel, state: State) -> Update:
        """All levels, the criterion, the verdict."""
        box = capped(model, self.q_limit)
        room = model.recovery.within(*box) if model.clearance else None
        found = descend(
            model.full_J,
            model.here.residual,
            model.levels,
            box,
            model,
            damping=self.damping,
            brake=state["brake"],
            rows=room.rows if room else None,
            start=room.step if room else None,
        )
        step = found.step
        null = NullMove(zeros(model.robot.n), 0, 0, 0)
        if model.has_criterion or model.clearance:
            if room:  # what makes room is no share of the task's
                step = step - model.recovery.step
            null = self.secondary.propose(_below(model, found.free), state, -step)
            step = null.task_scale * step
        term = model.within_limits(null.term - step)
        point = model.moved(term)
        verdict = LevelMerit(model, model.levels).judge(state["weights"], state["penalty"], step, null, point)
        watched = point.V + point.H if self.evaluates_candidate(model.has_criterion) else term
        accepted = verdict.accepted if self.backtracking else 1
        if model.clearance:
            accepted = logic_or(accepted, model.recovery.takes(term, point.length))
        accepted = logic_and(accepted, is_finite(watched))
        clear = model.clearance.keeps(term) if model.clearance else 1
        accepted = logic_and(accepted, clear)
        null_blamed = null.length > norm(step) if model.has_criterion else 0
        blamed = [logic_or(part, logic_not(clear)) for part in (logic_not(null_blamed), null_blamed)]
        outcome = Outcome(accepted, verdict.ratio, null, *blamed)
        least = FIRST_BRAKE * model.full_rows.squared_length
        harder = if_else(outcome.task_blamed, fmax(HARDER * state["brake"], least), state["brake"])
        after = {
            "brake": if_else(accepted, SOFTER * state["brake"], harder),
            "weights": _padded(verdict.weights, state["weights"].shape[0]),
            "penalty": verdict.penalty,
        }
        if model.has_criterion or model.clearance:
            after |= self.secondary.adapt(model, state, null, outcome)
        figures = {
            "alpha": math.nan,
            "beta": null.beta,
            "V2": null.length**2 / 2,
            "predicted_decrease": model.predicted_decrease(-(model.full_J @ step)),
            "actual_decrease": model.here.V - point.V,
            **null.figures,
        }
        missed = {(f"level {k}", "of its residual"): left for k, left in enumerate(found.missed)}
        return Update(
            point=point,
            accepted=accepted,
            state=after,
            term=term,
            wanted=term,
            null_term=null.term,
            figures=figures,
            stationarity_residual=null.stationarity_residual,
            progress=verdict.progress,
            relaxed={**null.relaxed, **missed},
        )


def _below(model: LocalModel, free: Expression) -> LocalModel:
    """The model as it is below all tasks: without the joints whose limits the tasks need."""
    if model.clearance or not model.bounded:
        return model
    return replace(model, full_J=model.full_J @ diag(free), full_gradient=free * model.full_gradient)


def _padded(column: Expression, rows: int) -> Expression:
    """The column with zeros below."""
    padded = zeros(rows)
    padded[: column.shape[0]] = column
    return padded

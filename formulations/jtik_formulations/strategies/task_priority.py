"""Levels of priority: a lower task moves in the null space of those above (formulations/task_priority.md)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from typing import Literal

import numpy as np

from jtik import register_strategy
from jtik.errors import ArgumentError
from jtik.strategy import Acceptance, LocalModel, NullMove, Outcome, SecondaryTerm, Shape, State, Strategy, Update
from jtik.symbolic import (
    Expression,
    fmax,
    fmin,
    if_else,
    is_finite,
    logic_and,
    logic_not,
    norm,
    ratio,
    sumsqr,
    vertcat,
    zeros,
)
from jtik.symbolic.factorization import RowSpace, damped_multipliers, squared_length
from jtik.types import Array
from jtik_formulations.strategies._parts.level_merit import LevelMerit
from jtik_formulations.strategies.projected_gradient import ProjectedGradient

Rule = Literal["recursive", "robust"]


class Levels:
    """What each level adds to the step that is subtracted from q, one after the other, the highest first."""

    def __init__(self, J: Expression, r: Expression, rule: Rule, damping: float) -> None:
        self._J, self._r, self._rule, self._damping = J, r, rule, damping
        self._above: list[RowSpace] = []

    def add(self, rows: Sequence[int], total: Expression) -> Expression:
        """The part (n, 1) of the level with these rows, beside the ``total`` of those above it.

        With N the projector to the null space of all levels above: (J_k N)^+ (r_k - J_k total), or N J_k^+ r_k by the
        rule "robust". Below the highest level the inverses are damped.
        """
        own, residual = self._J[list(rows), :], self._r[list(rows)]
        free = vertcat(*[_projected(own[i, :].T, self._above).T for i in range(len(rows))])
        space = RowSpace(free, squared_scale=squared_length(own))
        if self._rule == "robust":
            part = _projected(self._inverse(own, RowSpace(own), residual), self._above)
        else:
            part = self._inverse(free, space, residual - own @ total)
        self._above.append(space)
        return part

    def _inverse(self, J: Expression, space: RowSpace, r: Expression) -> Expression:
        """J^+ r, below the highest level J' (J J' + lambda I)^-1 r."""
        if self._above and self._damping:
            return J.T @ damped_multipliers(J, self._damping * sumsqr(r) / 2, r)
        return space.least_squares(r).vector


def _projected(vector: Expression, above: Sequence[RowSpace]) -> Expression:
    """N vector: the row spaces of the levels above are orthogonal to each other, so one after the other will do."""
    for space in above:
        vector = space.split(vector).null
    return vector


@register_strategy("task_priority")
@dataclass(frozen=True, kw_only=True)
class TaskPriority(Strategy):
    """dq = -sum (J_k N_k)^+ (r_k - J_k p_k) - beta N grad H, over the levels k of the tasks' ``priority``, 0 first.

    A lower level does what the levels above it leave free, and no more; the criterion does what all of them leave.
    For tasks that may not all be possible. With one level it is Newton's law. Limits are those of the engine, which
    stops joints without regard to levels; where they matter, prefer ``"lexicographic_qp"``.

    Attributes:
        rule: "recursive": exact where the levels are compatible. "robust": never worse conditioned than the single
            tasks, at the price that a lower task comes more slowly even where it is compatible.
        damping: lambda / V_k in the inverses below the highest level, [1 / rad^2]; 0 for the undamped laws of the
            papers, whose lower levels blow up, within q_limit, where they are about to conflict with higher ones.
        q_limit: limit of Q, the length of the rotational part of a step [rad], shared out from the highest level down;
            math.inf for none.
        backtracking: halve the step until the levels' penalty function falls. Without it every step is taken.
        secondary: the null-space term.

    Source: Siciliano and Slotine (1991) for "recursive"; Chiaverini (1997), (34), for "robust".
    """

    rule: Rule = "recursive"
    damping: float = 1.0
    q_limit: float = 0.5
    backtracking: bool = True
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    summary = "levels of priority, each in the null space of those above"
    source = "Siciliano and Slotine 1991; Chiaverini 1997"

    def __post_init__(self) -> None:
        if self.rule not in ("recursive", "robust"):
            raise ArgumentError("rule", self.rule, "'recursive' or 'robust'")
        if not 0 <= self.damping < math.inf:
            raise ArgumentError("damping", self.damping, "a finite number from 0")
        if not self.q_limit > 0:
            raise ArgumentError("q_limit", self.q_limit, "a positive angle [rad], math.inf for none")
        if self.secondary.uses_qp():
            raise ArgumentError(
                "secondary", self.secondary, "a term without a program; 'lexicographic_qp' has programs"
            )

    def acceptance(self) -> Acceptance:
        """``"merit"``: the penalty function falls, which for one level is V; ``"always"`` without backtracking."""
        return "merit" if self.backtracking else "always"

    def evaluates_candidate(self, has_criterion: bool) -> bool:
        """With backtracking, or for the criterion's own step length."""
        return self.backtracking or has_criterion

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """Fraction of each level's part, weights of the levels, penalty, and what the secondary term remembers."""
        state = {"fractions": np.ones(shape.m), "weights": np.zeros(shape.m), "penalty": np.zeros(1)}
        if shape.has_criterion:
            state |= self.secondary.initial_state(shape)
        return state

    def update(self, model: LocalModel, state: State) -> Update:
        """All levels, the criterion, the verdict."""
        wanted, lengths = self._limited(model, state["fractions"])
        task_term = model.within_limits(wanted)
        null = NullMove(zeros(model.robot.n), 0, 0, 0)
        if model.has_criterion:
            null = self.secondary.propose(model, state, task_term)
        term = model.within_limits(task_term + null.term)
        point = model.moved(term)
        verdict = LevelMerit(model, model.levels).judge(state["weights"], state["penalty"], -task_term, null, point)
        watched = point.V + point.H if self.evaluates_candidate(model.has_criterion) else term
        accepted = logic_and(verdict.accepted if self.backtracking else 1, is_finite(watched))
        longest = reduce(fmax, lengths)
        null_blamed = null.length > longest if model.has_criterion else 0
        outcome = Outcome(accepted, verdict.ratio, null, logic_not(null_blamed), null_blamed)
        fractions = [
            if_else(accepted, fmin(1, 2 * f), if_else(logic_and(outcome.task_blamed, length >= longest), f / 2, f))
            for f, length in zip(_entries(state["fractions"], len(lengths)), lengths, strict=True)
        ]
        after = {
            "fractions": _filled(vertcat(*fractions), state["fractions"]),
            "weights": _filled(verdict.weights, state["weights"]),
            "penalty": verdict.penalty,
        }
        if model.has_criterion:
            after |= self.secondary.adapt(model, state, null, outcome)
        figures = {
            "alpha": math.nan,
            "beta": null.beta,
            "V2": null.length**2 / 2,
            "predicted_decrease": model.predicted_decrease(model.J @ task_term),
            "actual_decrease": model.here.V - point.V,
        }
        return Update(
            point=point,
            accepted=accepted,
            state=after,
            term=term,
            wanted=wanted + null.term,
            null_term=null.term,
            figures=figures,
            stationarity_residual=null.stationarity_residual,
            progress=verdict.progress,
        )

    def _limited(self, model: LocalModel, fractions: Expression) -> tuple[Expression, list[Expression]]:
        """The sum of all levels' parts, each shortened to what those above have left of the Q limit; their lengths."""
        levels, total, lengths = Levels(model.J, model.here.residual, self.rule, self.damping), zeros(model.robot.n), []
        for fraction, rows in zip(_entries(fractions, len(model.levels)), model.levels, strict=True):
            part = levels.add(rows, total)
            scale = fraction if self.backtracking else 1
            if math.isfinite(self.q_limit):
                room = fmax(self.q_limit - model.rotation_size(total), 0)
                scale = scale * fmin(1, ratio(room, model.rotation_size(part)))
            total = total + scale * part
            lengths.append(norm(scale * part))
        return total, lengths


def _entries(column: Expression, count: int) -> list[Expression]:
    return [column[i] for i in range(count)]


def _filled(column: Expression, like: Expression) -> Expression:
    """The column at the head of another: the number of levels is not known where a state begins."""
    return vertcat(column, like[column.shape[0] :]) if column.shape[0] < like.shape[0] else column

"""PriorityLevels of priority: a lower task moves in the null space of those above (formulations/task_priority.md)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from typing import Literal

import numpy as np

from jtik import register_strategy
from jtik.errors import ArgumentError
from jtik.strategy import (
    Acceptance,
    LevelMerit,
    LocalModel,
    NonNegative,
    Outcome,
    Programmed,
    Proposal,
    SecondaryTerm,
    Shape,
    State,
    StepLimit,
    adapted_fraction,
)
from jtik.symbolic import Expression, fmax, fmin, is_symbolic, logic_and, norm, ratio, sumsqr, vertcat, zeros
from jtik.symbolic.factorization import RowSpace, damped_multipliers, squared_length
from jtik.types import Array
from jtik_formulations.bibliography import ANTONELLI_2009, CHIAVERINI_1997, SICILIANO_SLOTINE_1991
from jtik_formulations.strategies._parts.damped_least_squares import damped_where_stagnant
from jtik_formulations.strategies.projected_gradient import ProjectedGradient

Rule = Literal["recursive", "robust"]


class PriorityLevels:
    """The displacement of each level, the highest first.

    Args:
        J: Jacobian of all levels (m, n).
        r: residual (m, 1).
        rule: rule of `TaskPriority`.
        damping: damping below the highest level.
        model: the local model, whose damping is that of all levels.
    """

    def __init__(self, J: Expression, r: Expression, rule: Rule, damping: float, model: LocalModel) -> None:
        self._J, self._r, self._rule, self._damping, self._model = J, r, rule, damping, model
        self._above: list[RowSpace] = []

    def add(self, rows: Sequence[int], total: Expression) -> Expression:
        """The displacement (n, 1) of the level with these rows, beside the ``total`` of those above it.

        With N the projector to the null space of all levels above: -(J_k N)^+ (r_k + J_k total), or -N J_k^+ r_k by the
        rule "robust". Below the highest level the inverses are damped.
        """
        own, residual = self._J[list(rows), :], self._r[list(rows)]
        free = vertcat(*[_projected(own[i, :].T, self._above).T for i in range(len(rows))])
        space = RowSpace(free, squared_scale=squared_length(own))
        if self._rule == "robust":
            part = _projected(self._solved(own, RowSpace(own), residual), self._above)
        else:
            part = self._solved(free, space, residual + own @ total)
        self._above.append(space)
        return part

    def _solved(self, J: Expression, space: RowSpace, r: Expression) -> Expression:
        """-J^+ r, below the highest level -J' (J J' + mu I)^-1 r."""
        model = self._model
        damping = self._damping * sumsqr(r) / 2 if self._above and self._damping else 0
        if is_symbolic(damping) or is_symbolic(model.curvature):
            return J.T @ damped_multipliers(J, damping + model.curvature + model.stagnation_damping, -r)
        return damped_where_stagnant(model, J, -r, space.least_squares(-r))[0]


def _projected(vector: Expression, above: Sequence[RowSpace]) -> Expression:
    """N vector, by one projection after the other: the row spaces of the levels above are orthogonal to each other."""
    for space in above:
        vector = space.split(vector).null
    return vector


@register_strategy("task_priority")
@dataclass(frozen=True, kw_only=True)
class TaskPriority(Programmed):
    """dq = -sum (J_k N_k)^+ (r_k + J_k p_k) - beta N grad H, over the levels k of the tasks' ``priority``, 0 first.

    A lower level moves only in the null space of the levels above it, the criterion only in that of all levels. Prefer
    it for tasks that may conflict. With one level it is Newton's method. Limits are those of the engine, which
    stops joints without regard to levels; where they matter, prefer ``"lexicographic_qp"``. A highest level out of
    reach does not end at its closest posture, but up to a third of the reach away from it (a planar arm, 30 of 30
    solves), because its step is not damped, as that of ``"newton"``; ``"lexicographic_qp"`` ends there.

    Attributes:
        rule: "recursive": exact where the levels are compatible. "robust": never worse conditioned than the single
            tasks, at the cost that a lower task converges more slowly even where it is compatible.
        damping: mu / V_k in the inverses below the highest level, [1 / rad^2]; 0 for the undamped inverses of the
            papers, whose lower levels make very long steps, within q_limit, close to a conflict with higher ones.
        q_limit: limit of Q, the norm of the rotational part of a step [rad], shared by the levels, the highest first;
            math.inf for none.
        backtracking: halve the step until the penalty function of the levels falls. Without it every step is taken.
        secondary: the null-space term.

    Source: Siciliano and Slotine (1991) for "recursive"; Chiaverini (1997), (34), for "robust" with two levels,
        Antonelli (2009) with more.
    """

    rule: Rule = "recursive"
    damping: NonNegative = 1.0
    q_limit: StepLimit = 0.5
    backtracking: bool = True
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    summary = "levels of priority, each in the null space of those above"
    source = "Siciliano and Slotine 1991; Chiaverini 1997; Antonelli 2009"
    bibtex = "\n".join((SICILIANO_SLOTINE_1991, CHIAVERINI_1997, ANTONELLI_2009))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.secondary.uses_qp():
            raise ArgumentError("secondary", self.secondary, "a term without a QP; 'lexicographic_qp' has QPs")

    def respects_priority(self) -> bool:
        """Always."""
        return True

    def damps_stagnation(self) -> bool:
        """With backtracking."""
        return self.backtracking

    def merit(self) -> LevelMerit:
        """The penalty function of the levels; with one level it is |r|."""
        return LevelMerit()

    def acceptance(self) -> Acceptance:
        """By merit, or always without backtracking."""
        return "merit" if self.backtracking else "always"

    def secondary_term(self) -> SecondaryTerm:
        """As given."""
        return self.secondary

    def uses_qp(self, has_criterion: bool) -> bool:
        """Never."""
        return False

    def fits_limits(self) -> bool:
        """Always."""
        return True

    def own_state(self, shape: Shape) -> Mapping[str, Array]:
        """The fraction of each level's displacement; as many as rows, since the number of levels is not known here."""
        return {"fractions": np.ones(shape.m)}

    def propose(self, model: LocalModel, state: State) -> Proposal:
        """All levels, the highest first, then the criterion."""
        unlimited, lengths = self._levels(model, state["fractions"])
        task = model.fitted(unlimited - model.weak_motion)
        null = self.secondary.propose(model, state, task).completed(model) if model.has_criterion else None
        if null and model.accelerated:
            null = null.beside(model, task)
        longest = reduce(fmax, lengths)
        return Proposal(
            dq=model.within_limits(task + null.dq if null else task),
            task=task,
            null_space=null,
            null_space_longer=null.length > longest if null else 0,
            wanted=unlimited + null.dq if null else unlimited,
            state={"lengths": vertcat(*lengths)},
        )

    def adapt(self, model: LocalModel, state: State, proposal: Proposal, outcome: Outcome) -> State:
        """Half the fraction of the longest part after a refusal, twice all fractions after an acceptance."""
        lengths, fractions = proposal.state["lengths"], state["fractions"]
        count = lengths.shape[0]
        longest = reduce(fmax, [lengths[k] for k in range(count)])
        adapted = [
            adapted_fraction(fractions[k], outcome.accepted, logic_and(outcome.shorten_task, lengths[k] >= longest))
            for k in range(count)
        ]
        rest = [fractions[k] for k in range(count, fractions.shape[0])]
        return {"fractions": vertcat(*adapted, *rest)}

    def _levels(self, model: LocalModel, fractions: Expression) -> tuple[Expression, list[Expression]]:
        """The sum of all levels' displacements, each within what remains of the Q limit; their norms."""
        levels = PriorityLevels(model.J_free, model.here.residual, self.rule, self.damping, model)
        total, lengths = zeros(model.robot.n), []
        for k, rows in enumerate(model.levels):
            part = levels.add(rows, total)
            scale = fractions[k] if self.backtracking else 1
            if math.isfinite(self.q_limit):
                remaining = fmax(self.q_limit - model.rotation_norm(total), 0)
                scale = scale * fmin(1, ratio(remaining, model.rotation_norm(part)))
            total = total + scale * part
            lengths.append(norm(scale * part))
        return total, lengths

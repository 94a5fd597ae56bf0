"""Strict priorities: a quadratic program for each level, the highest first (formulations/lexicographic_qp.md)."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from jtik import register_strategy
from jtik.errors import ArgumentError
from jtik.strategy import (
    Acceptance,
    AdaptiveDamping,
    LevelMerit,
    LocalModel,
    NonNegative,
    Programmed,
    Proposal,
    SecondaryTerm,
    State,
    StepLimit,
    limited_box,
)
from jtik.symbolic import Expression, diag
from jtik_formulations.bibliography import ESCANDE_2014, KANOUN_2011
from jtik_formulations.strategies._parts.levels import descend
from jtik_formulations.strategies.qp_secondary import QPSecondary

DAMPING = AdaptiveDamping(increase=4.0, decrease=0.25)
"""Damping that refusals add."""


@register_strategy("lexicographic_qp")
@dataclass(frozen=True, kw_only=True)
class LexicographicQP(Programmed):
    """Level by level, the best that the levels above leave possible within the limits; the criterion comes last.

    Level k minimises |r_k + J_k dq| in the box of the joint limits without a change of J_i dq of the levels i above
    it. Levels are the tasks' ``priority``, 0 the highest. Prefer it for several tasks that cannot all be met, and where
    a joint limit is to affect the lowest task first. Without limits and damping it is the recursive pseudo-inverse.

    Attributes:
        damping: of each level's step by its own error: mu / (1/2 |error|^2), [1 / rad^2]; 0 for none.
        q_limit: largest motion of each rotational joint for the tasks in a step [rad]; math.inf for no limit.
        backtracking: damp more until the penalty function falls. Without it every step is taken.
        secondary: the quadratic program of the criterion.

    Source: Kanoun, Lamiraux and Wieber (2011); Escande, Mansard and Wieber (2014); Siciliano and Slotine (1991).
    """

    damping: NonNegative = 0.1
    q_limit: StepLimit = 0.5
    backtracking: bool = True
    secondary: QPSecondary = field(default_factory=QPSecondary)

    summary = "a QP for each level of priority, limits in all of them, the criterion below the last"
    source = "Kanoun, Lamiraux and Wieber 2011; Escande, Mansard and Wieber 2014"
    bibtex = "\n".join((KANOUN_2011, ESCANDE_2014))

    def __post_init__(self) -> None:
        super().__post_init__()
        if not isinstance(self.secondary, QPSecondary):
            raise ArgumentError("secondary", self.secondary, "a QPSecondary: the other terms ignore limits")

    def propose(self, model: LocalModel, state: State) -> Proposal:
        """All levels, then the criterion."""
        box = limited_box(model, self.q_limit)
        restoration = model.restoration.within(*box) if model.clearance else None
        found = descend(
            model.J,
            model.here.residual,
            model.levels,
            box,
            model.solve,
            damping=self.damping,
            added_damping=state[DAMPING.name] + model.curvature,
            rows=restoration.rows if restoration else None,
            start=restoration.dq if restoration else None,
            weak_motion=model.weak_motion,
        )
        task, null = found.dq, None
        if model.has_criterion:  # the levels keep limits and clearances
            null = self.secondary.beside(_below(model, found.free), state, task)
        missed = {(f"level {k}", "of its residual"): left for k, left in enumerate(found.missed)}
        return Proposal(
            dq=model.within_limits(task + null.dq if null else task), task=task, null_space=null, relaxed=missed
        )

    def respects_priority(self) -> bool:
        """Always."""
        return True

    def merit(self) -> LevelMerit:
        """The penalty function of the levels; with one level it is |r|."""
        return LevelMerit()

    def acceptance(self) -> Acceptance:
        """By merit, or always without backtracking."""
        return "merit" if self.backtracking else "always"

    def shortening(self) -> AdaptiveDamping:
        """Damping."""
        return DAMPING

    def secondary_term(self) -> SecondaryTerm:
        """The quadratic program of the criterion."""
        return self.secondary

    def supports_clearances(self) -> bool:
        """Always."""
        return True


def _below(model: LocalModel, free: Expression) -> LocalModel:
    """The model as it is below all tasks: without the joints whose limits the tasks need."""
    if model.clearance or not model.bounded:
        return model
    return replace(model, J=model.J @ diag(free), gradient=free * model.gradient)

"""Newton's method: the pseudo-inverse step, with the same Q limit as the transpose method (formulations/newton.md)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from jtik import register_strategy
from jtik.errors import ArgumentError
from jtik.strategy import (
    Acceptance,
    Composition,
    LocalModel,
    Outcome,
    SecondaryTerm,
    Shape,
    State,
    TaskMove,
    TaskStep,
)
from jtik.symbolic import Expression, fmin, ratio
from jtik.symbolic.factorization import RowVector
from jtik.types import Array
from jtik_formulations.strategies.projected_gradient import ProjectedGradient
from jtik_formulations.strategies.transpose import backtracked, judged


def newton_step(model: LocalModel) -> RowVector:
    """x = J+ r: of all x that minimise |r - J x| the shortest."""
    return model.rows.least_squares(model.here.residual)


@dataclass(frozen=True, kw_only=True)
class NewtonStep(TaskStep):
    """The task step of ``Newton``."""

    q_limit: float
    backtracking: bool

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The fraction of the step that backtracking has come down to."""
        return {"fraction": np.ones(1)} if self.backtracking else {}

    def propose(self, model: LocalModel, state: State) -> TaskMove:
        """-J+ r, as a whole scaled down to the Q limit: its direction, and so the tip's, stays."""
        newton = newton_step(model)
        scale: Expression = state["fraction"] if self.backtracking else 1
        if math.isfinite(self.q_limit):
            scale = scale * fmin(1, ratio(self.q_limit, model.rotation_size(newton.vector, newton.squared_length)))
        return TaskMove.along(scale * newton, math.nan)

    def adapt(self, model: LocalModel, state: State, move: TaskMove, outcome: Outcome) -> State:
        """Half the step after a refusal, twice the fraction after an acceptance."""
        return backtracked(state, outcome) if self.backtracking else {}


@register_strategy("newton")
@dataclass(frozen=True, kw_only=True)
class Newton(Composition):
    """dq = -J+ e - beta (I - J+ J) grad H, each step limited in length.

    Quadratic near the target. With ``q_limit=math.inf, backtracking=False`` it is the undamped method the paper
    warns of, which jumps near singular poses.

    Attributes:
        q_limit: limit of Q, the length of the rotational part of a step [rad].
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.

    Source: Das, Slotine and Sheridan (1988), section 2.3; Whitney (1969).
    """

    q_limit: float = 0.5
    backtracking: bool = True
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    summary = "pseudo-inverse step with the Q limit and backtracking on V"
    source = "Das, Slotine and Sheridan 1988, section 2.3"

    def __post_init__(self) -> None:
        if not self.q_limit > 0:
            raise ArgumentError("q_limit", self.q_limit, "a positive angle [rad], math.inf for none")

    def task_step(self) -> TaskStep:
        """-J+ e."""
        return NewtonStep(q_limit=self.q_limit, backtracking=self.backtracking)

    def secondary_term(self) -> SecondaryTerm:
        """-beta (I - J+ J) grad H."""
        return self.secondary

    def acceptance(self) -> Acceptance:
        """By merit, by the task step, or always."""
        return judged(self.backtracking, self.secondary)

"""J-PARSE: the inverse in strong singular directions, the transpose in weak ones (formulations/jparse.md)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from jtik import register_strategy
from jtik.errors import ArgumentError
from jtik.strategy import Acceptance, Composition, LocalModel, Outcome, SecondaryTerm, Shape, State, TaskMove, TaskStep
from jtik.symbolic import Expression, fmin, if_else, norm, ratio
from jtik.symbolic.svd import SingularValues
from jtik.types import Array
from jtik_formulations.strategies.damped import positive
from jtik_formulations.strategies.projected_gradient import ProjectedGradient
from jtik_formulations.strategies.transpose import backtracked, judged


@dataclass(frozen=True, kw_only=True)
class JParseStep(TaskStep):
    """The task step of ``JParse``."""

    threshold: float
    singular_gain: float
    q_limit: float
    backtracking: bool

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The fraction of the step that backtracking has come down to."""
        return {"fraction": np.ones(1)} if self.backtracking else {}

    def propose(self, model: LocalModel, state: State) -> TaskMove:
        """-sum of g_i (u_i' r) sigma_i v_i, scaled down to the Q limit."""
        found = SingularValues(model.J)
        floor = self.threshold**2 * found.squared[0]
        gains = [
            if_else(squared > floor, 1, self.singular_gain) * ratio(component, if_else(squared > floor, squared, floor))
            for component, squared in zip(found.components(model.here.residual), found.squared, strict=True)
        ]
        full = found.combined(gains)
        scale: Expression = state["fraction"] if self.backtracking else 1
        if math.isfinite(self.q_limit):
            scale = scale * fmin(1, ratio(self.q_limit, model.rotation_size(full)))
        term = scale * full
        return TaskMove(term, scale * found.image(gains), norm(term), math.nan)

    def adapt(self, model: LocalModel, state: State, move: TaskMove, outcome: Outcome) -> State:
        """Half the step after a refusal, twice the fraction after an acceptance."""
        return backtracked(state, outcome) if self.backtracking else {}


@register_strategy("jparse")
@dataclass(frozen=True, kw_only=True)
class JParse(Composition):
    """dq = -sum g_i (u_i' r) sigma_i v_i - beta (I - J+ J) grad H, g_i = 1 / max(sigma_i, gamma sigma_1)^2.

    Newton's step along singular directions stronger than ``threshold`` times the strongest, and along weaker
    ones the transpose step of gain 1 / (gamma sigma_1)^2, which goes to zero with sigma_i. For servoing to, through and
    out of singular poses; where the target itself is weak it arrives linearly.

    Attributes:
        threshold: gamma, from 0 to 1.
        singular_gain: Kp of the paper, on the weak directions; 1 makes the law continuous at the threshold.
        q_limit: limit of Q, the length of the rotational part of a step [rad]; math.inf for none.
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.

    Source: Guptasarma, Strong, Zhen and Kennedy (2025), arXiv 2505.00306.
    """

    threshold: float = 0.1
    singular_gain: float = 1.0
    q_limit: float = 0.5
    backtracking: bool = True
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    summary = "inverse along strong singular directions, transpose along weak ones"
    source = "Guptasarma, Strong, Zhen and Kennedy 2025"

    def __post_init__(self) -> None:
        if not 0 < self.threshold <= 1:
            raise ArgumentError("threshold", self.threshold, "a number above 0, up to 1")
        positive("singular_gain", self.singular_gain)
        if not self.q_limit > 0:
            raise ArgumentError("q_limit", self.q_limit, "a positive angle [rad], math.inf for none")

    def task_step(self) -> TaskStep:
        """The inverse of the safe Jacobian on the strong directions, the singular feedback on the others."""
        return JParseStep(
            threshold=self.threshold,
            singular_gain=self.singular_gain,
            q_limit=self.q_limit,
            backtracking=self.backtracking,
        )

    def secondary_term(self) -> SecondaryTerm:
        """-beta (I - J+ J) grad H."""
        return self.secondary

    def acceptance(self) -> Acceptance:
        """By merit, by the task step, or always."""
        return judged(self.backtracking, self.secondary)

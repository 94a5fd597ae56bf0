"""J-PARSE: the inverse in strong singular directions, the transpose in weak ones (formulations/jparse.md)."""

from __future__ import annotations

from dataclasses import dataclass

from jtik import register_strategy
from jtik.strategy import LocalModel, Positive, Share, State, TaskDisplacement
from jtik.symbolic import if_else, ratio
from jtik.symbolic.svd import SingularValues
from jtik_formulations.bibliography import GUPTASARMA_2025
from jtik_formulations.strategies._parts.scaled_step import ScaledComposition


@register_strategy("jparse")
@dataclass(frozen=True, kw_only=True)
class JParse(ScaledComposition):
    """dq = -sum g_i (u_i' r) sigma_i v_i - beta (I - J+ J) grad H, g_i = 1 / max(sigma_i, gamma sigma_1)^2.

    Newton's step along singular directions stronger than ``threshold`` times the strongest, and along weaker
    ones the transpose step of gain 1 / (gamma sigma_1)^2, which goes to zero with sigma_i. For steps without a time to,
    through and out of singular poses; along a weak direction it converges linearly, the more slowly the larger the
    threshold is. A threshold of 0.1 keeps steps short at singular poses and fails at targets close to them
    (formulations/jparse.md). For a target out of reach it finds the closest posture with 0.1. With the default, which
    hardly shortens steps, it does not: a planar arm ends up to a third of its reach away from it (30 of 30 solves).

    Attributes:
        threshold: gamma, in (0, 1].
        singular_gain: Kp of the paper, on the weak directions; 1 makes the step continuous at the threshold.
        q_limit: limit of Q, the norm of the rotational part of a step [rad]; math.inf for none.
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.

    Source: Guptasarma, Strong, Zhen and Kennedy (2025), arXiv 2505.00306.
    """

    threshold: Share = 1e-3
    singular_gain: Positive = 1.0

    summary = "inverse along strong singular directions, transpose along weak ones"
    source = "Guptasarma, Strong, Zhen and Kennedy 2025"
    bibtex = GUPTASARMA_2025

    def damps_stagnation(self) -> bool:
        """With backtracking."""
        return self.backtracking

    def full_step(self, model: LocalModel, state: State) -> TaskDisplacement:
        """-sum of g_i (u_i' r) sigma_i v_i."""
        found = SingularValues(model.J_free)
        floor = self.threshold**2 * found.squared[0]
        damping = model.curvature + model.stagnation_damping
        gains = [
            if_else(squared > floor, 1, self.singular_gain)
            * ratio(component, if_else(squared > floor, squared, floor) + damping)
            for component, squared in zip(found.components(-model.here.residual), found.squared, strict=True)
        ]
        return TaskDisplacement(found.combined(gains), found.image(gains))

"""Damped least squares, with damping in proportion to V (formulations/damped.md)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from jtik import register_strategy
from jtik.strategy import LocalModel, Positive
from jtik.symbolic import Expression, if_else
from jtik_formulations.bibliography import CHAN_LAWRENCE_1988
from jtik_formulations.strategies._parts.damped_least_squares import DampedLeastSquares

EXPLORING = 0.03
"""Damping of an exploring step relative to that of other steps."""


@register_strategy("damped")
@dataclass(frozen=True, kw_only=True)
class Damped(DampedLeastSquares):
    """dq = -J' (J J' + mu I)^-1 r - beta (I - J+ J) grad H, with mu in proportion to V.

    The cheapest step that is short near singular poses and quadratic at the target. With ``backtracking=False`` every
    step is taken without evaluating where it ends, so that V may rise: together with ``restarts`` that finds *some*
    posture of an arm fastest.

    Attributes:
        damping: mu / V, [1 / rad^2] where the residual is in [m]; twice the ``lm_damping`` of mink, pink and
            `WeightedQP`, which is mu / |r|^2.
        q_limit: limit of Q, the norm of the rotational part of a step [rad]; math.inf for none.
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.
        explore: whether `solve` tries exploring steps where V has stopped falling; not without backtracking.

    Source: Chan and Lawrence (1988).
    """

    damping: Positive = 0.1
    explore: bool = True

    summary = "damped least squares, damping in proportion to V, with the Q limit and backtracking"
    source = "Chan and Lawrence 1988"
    bibtex = CHAN_LAWRENCE_1988

    def explores(self, has_criterion: bool) -> bool:
        """With backtracking, but beside a secondary term that is added without a test of the merit function."""
        return self.explore and self.backtracking and not (has_criterion and self.secondary.bounds_itself)

    def in_lanes(self) -> Damped:
        """The same without backtracking, and without the Q limit: the damping alone keeps a step short, see below.

        |dq| is at most sqrt(V / 2 mu), with mu = damping V.
        """
        return replace(self, backtracking=False, q_limit=math.inf)

    def damping_of(self, model: LocalModel) -> Expression:
        """Damping times V; less in an exploring step."""
        return if_else(model.exploring, EXPLORING * self.damping, self.damping) * model.here.V

"""Newton's method: the pseudo-inverse step, with the same Q limit as the transpose method (formulations/newton.md)."""

from __future__ import annotations

from dataclasses import dataclass

from jtik import register_strategy
from jtik.strategy import LocalModel, State, TaskDisplacement
from jtik.symbolic import is_symbolic
from jtik_formulations.bibliography import DAS_1988
from jtik_formulations.strategies._parts.damped_least_squares import damped_step, damped_where_stagnant
from jtik_formulations.strategies._parts.scaled_step import ScaledComposition


@register_strategy("newton")
@dataclass(frozen=True, kw_only=True)
class Newton(ScaledComposition):
    """dq = -J+ e - beta (I - J+ J) grad H, each step limited in length.

    Quadratic near the target. For a target out of reach it does not find the closest posture, but ends up to a third of
    the reach away from it (a planar arm, 30 of 30 solves), because its step along the direction that vanishes there is
    not damped; ``"hybrid"`` finds it. `step` finds it, too: it is damped where the error has stopped falling. With
    ``q_limit=math.inf, backtracking=False`` it is the undamped method the paper warns of, which jumps near singular
    poses.

    Attributes:
        q_limit: limit of Q, the norm of the rotational part of a step [rad]; math.inf for none.
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.

    Source: Das, Slotine and Sheridan (1988), section 2.3; Whitney (1969).
    """

    summary = "pseudo-inverse step with the Q limit and backtracking on V"
    source = "Das, Slotine and Sheridan 1988, section 2.3"
    bibtex = DAS_1988

    def damps_stagnation(self) -> bool:
        """With backtracking; without it every step is undamped."""
        return self.backtracking

    def full_step(self, model: LocalModel, state: State) -> TaskDisplacement:
        """-J+ r: of all displacements that minimise |r + J dq| the shortest; damped in a timed step."""
        if model.timed:
            return damped_step(model, model.curvature)
        r = -model.here.residual
        shortest = model.row_space_free.least_squares(r)
        if not is_symbolic(model.stagnation_damping):
            return TaskDisplacement.along(shortest)
        return TaskDisplacement(*damped_where_stagnant(model, model.J_free, r, shortest))

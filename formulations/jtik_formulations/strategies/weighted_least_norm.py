"""Steps of least weighted norm: joints that approach a limit get heavy (formulations/weighted_least_norm.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated

import numpy as np

from jtik import register_strategy
from jtik.arguments import number
from jtik.strategy import LocalModel, Outcome, Shape, State, TaskDisplacement
from jtik.symbolic import Expression, fabs, fmin, horzcat, if_else, is_finite, ratio, sqrt, vertcat, zeros
from jtik.symbolic.factorization import RowSpace, damped_multipliers
from jtik.types import Array
from jtik_formulations.bibliography import CHAN_DUBEY_1995
from jtik_formulations.strategies._parts.damped_least_squares import damped_where_stagnant
from jtik_formulations.strategies._parts.scaled_step import ScaledComposition


def limit_gradient(model: LocalModel) -> tuple[Expression, Expression]:
    """Slopes |dH/dq_i| and offsets |2 q_i - u_i - l_i|, both (n, 1), of H = 1/4 sum (u - l)^2 / ((u - q)(q - l)).

    For fixed limits a slope [1/rad] rises and falls with its offset [rad], which is finite also at a limit. Both are 0
    in the middle of a joint's range, and for a joint without limits on both sides.
    """
    slopes: list[Expression] = [0] * model.robot.n
    offsets: list[Expression] = [0] * model.robot.n
    lowest, highest = model.position_limits or (model.lower, model.upper)
    for i, j in model.bounded:
        lower, upper, q = lowest[i], highest[i], model.here.q[i]
        limited = is_finite(upper - lower)
        up, down = if_else(limited, upper - q, 1), if_else(limited, q - lower, 1)
        offsets[j] = fabs(down - up)
        slopes[j] = ratio((up + down) ** 2 * offsets[j], 4 * up**2 * down**2)
    return vertcat(*slopes), vertcat(*offsets)


@register_strategy("weighted_least_norm")
@dataclass(frozen=True, kw_only=True)
class WeightedLeastNorm(ScaledComposition):
    """dq = -W^-1 J' (J W^-1 J')^-1 r - beta (I - J+ J) grad H, W heavy for joints that approach a limit.

    w_i = 1 + |dH/dq_i| where that has grown since the last step, else 1; H is a barrier at each joint limit. Prefer it
    to keep joints from running into limits without self-motion, hence without a criterion and a gain. It slows joints
    down and does not push them back. For a target out of reach it does not find the closest posture, but ends up to a
    third of the reach away from it (a planar arm, 30 of 30 solves), because its step is not damped, as that of
    ``"newton"``; ``"hybrid"`` finds it.

    Attributes:
        max_weight: largest w_i, of a joint at its limit: it must still move where the task cannot do without.
        q_limit: limit of Q, the norm of the rotational part of a step [rad]; math.inf for none.
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.

    Source: Chan and Dubey (1995).
    """

    max_weight: Annotated[float, partial(number, minimum=1, accepted="a finite number, at least 1")] = 1e4

    summary = "least norm weighted against joints that approach their limits"
    source = "Chan and Dubey 1995"
    bibtex = CHAN_DUBEY_1995

    def damps_stagnation(self) -> bool:
        """With backtracking."""
        return self.backtracking

    def own_state(self, shape: Shape) -> Mapping[str, Array]:
        """|2 q - u - l| before the last step taken."""
        return {"limit_offset": np.zeros(shape.n)}

    def full_step(self, model: LocalModel, state: State) -> TaskDisplacement:
        """-W^-1 J' (J W^-1 J')^+ r by the pseudo-inverse of J W^-1/2."""
        (slope, offset), before = limit_gradient(model), state["limit_offset"]
        added = fmin(slope, self.max_weight - 1)
        light = [1 / sqrt(1 + if_else(offset[j] >= before[j], added[j], 0)) for j in range(model.robot.n)]
        scaled = horzcat(*[light[j] * model.J_free[:, j] for j in range(model.robot.n)])
        if model.timed:
            multipliers = damped_multipliers(scaled, model.curvature, -model.here.residual)
            return TaskDisplacement(vertcat(*light) * (scaled.T @ multipliers))
        shortest = RowSpace(scaled).least_squares(-model.here.residual)
        vector, image = damped_where_stagnant(model, scaled, -model.here.residual, shortest)
        return TaskDisplacement(vertcat(*light) * vector, image)

    def adapt_own_state(self, model: LocalModel, state: State, outcome: Outcome) -> State:
        """The present |2 q - u - l| if the step is taken."""
        _, offset = limit_gradient(model)
        return {"limit_offset": if_else(outcome.accepted, offset, state["limit_offset"]) + zeros(model.robot.n)}

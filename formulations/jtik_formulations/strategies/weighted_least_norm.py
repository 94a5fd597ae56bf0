"""Steps of least weighted norm: joints that approach a limit get heavy (formulations/weighted_least_norm.md)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from jtik import register_strategy
from jtik.errors import ArgumentError
from jtik.strategy import Acceptance, Composition, LocalModel, Outcome, SecondaryTerm, Shape, State, TaskMove, TaskStep
from jtik.symbolic import Expression, fabs, fmin, horzcat, if_else, is_finite, norm, ratio, sqrt, vertcat, zeros
from jtik.symbolic.factorization import RowSpace
from jtik.types import Array
from jtik_formulations.strategies.projected_gradient import ProjectedGradient
from jtik_formulations.strategies.transpose import backtracked, judged


def limit_gradient(model: LocalModel, most: float) -> Expression:
    """|dH/dq_i| of Chan and Dubey's H = 1/4 sum (u - l)^2 / ((u - q)(q - l)), at most ``most``, (n, 1) [1/rad].

    0 in the middle of a joint's range, and for a joint without limits on both sides.
    """
    slopes: list[Expression] = [0] * model.robot.n
    for i, j in model.bounded:
        lower, upper, q = model.lower[i], model.upper[i], model.here.q[i]
        limited = is_finite(upper - lower)
        up, down = if_else(limited, upper - q, 1), if_else(limited, q - lower, 1)
        slope = ratio((up + down) ** 2 * fabs(down - up), 4 * up**2 * down**2)
        slopes[j] = fmin(slope, most)
    return vertcat(*slopes)


@dataclass(frozen=True, kw_only=True)
class WeightedLeastNormStep(TaskStep):
    """The task step of ``WeightedLeastNorm``."""

    max_weight: float
    q_limit: float
    backtracking: bool

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """|dH/dq| before the last step taken, and the fraction of the step that backtracking has come down to."""
        slope = {"limit_slope": np.zeros(shape.n)}
        return slope | {"fraction": np.ones(1)} if self.backtracking else slope

    def propose(self, model: LocalModel, state: State) -> TaskMove:
        """-W^-1 J' (J W^-1 J')^+ r by the pseudo-inverse of J W^-1/2, scaled down to the Q limit."""
        slope, before = limit_gradient(model, self.max_weight - 1), state["limit_slope"]
        light = [1 / sqrt(1 + if_else(slope[j] >= before[j], slope[j], 0)) for j in range(model.robot.n)]
        scaled = horzcat(*[light[j] * model.J[:, j] for j in range(model.robot.n)])
        least = RowSpace(scaled).least_squares(model.here.residual)
        full = vertcat(*light) * least.vector
        scale: Expression = state["fraction"] if self.backtracking else 1
        if math.isfinite(self.q_limit):
            scale = scale * fmin(1, ratio(self.q_limit, model.rotation_size(full)))
        term = scale * full
        return TaskMove(term, scale * least.image, norm(term), math.nan)

    def adapt(self, model: LocalModel, state: State, move: TaskMove, outcome: Outcome) -> State:
        """The slope of now if the step is taken; half the step after a refusal, twice the fraction otherwise."""
        slope = limit_gradient(model, self.max_weight - 1)
        after: State = {"limit_slope": if_else(outcome.accepted, slope, state["limit_slope"]) + zeros(model.robot.n)}
        return {**after, **backtracked(state, outcome)} if self.backtracking else after


@register_strategy("weighted_least_norm")
@dataclass(frozen=True, kw_only=True)
class WeightedLeastNorm(Composition):
    """dq = -W^-1 J' (J W^-1 J')^-1 r - beta (I - J+ J) grad H, W heavy for joints on their way to a limit.

    w_i = 1 + |dH/dq_i| where that has grown since the last step, else 1; H is a wall at each joint limit. To keep
    joints from running into limits with no self-motion, hence no criterion and no gain. It slows joints down and
    does not push them back.

    Attributes:
        max_weight: largest w_i, of a joint at its limit: it must still move where the task cannot do without.
        q_limit: limit of Q, the length of the rotational part of a step [rad]; math.inf for none.
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.

    Source: Chan and Dubey (1995).
    """

    max_weight: float = 1e4
    q_limit: float = 0.5
    backtracking: bool = True
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    summary = "least norm weighted against joints that approach their limits"
    source = "Chan and Dubey 1995"

    def __post_init__(self) -> None:
        if not 1 <= self.max_weight < math.inf:
            raise ArgumentError("max_weight", self.max_weight, "a finite number from 1")
        if not self.q_limit > 0:
            raise ArgumentError("q_limit", self.q_limit, "a positive angle [rad], math.inf for none")

    def task_step(self) -> TaskStep:
        """The step of least weighted norm."""
        return WeightedLeastNormStep(max_weight=self.max_weight, q_limit=self.q_limit, backtracking=self.backtracking)

    def secondary_term(self) -> SecondaryTerm:
        """-beta (I - J+ J) grad H."""
        return self.secondary

    def acceptance(self) -> Acceptance:
        """By merit, by the task step, or always."""
        return judged(self.backtracking, self.secondary)

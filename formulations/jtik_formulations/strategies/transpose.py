"""The Jacobian-transpose method with alpha and S from its discrete stability proof (formulations/transpose.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

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
from jtik.symbolic import Expression, dot, fmin, if_else, norm, ratio, sumsqr, vertcat
from jtik.types import Array
from jtik_formulations.strategies.projected_gradient import ProjectedGradient


def optimal_gain(slope: Expression, image: Expression) -> Expression:
    """alpha = N / 2D = u'Mu / |image|^2, the minimum of the linear model of V along a step with J dq = -alpha image."""
    return ratio(slope, sumsqr(image))


@dataclass(frozen=True)
class CauchyStep:
    """The transpose step -gain * direction, with direction = S J' r.

    Attributes: direction (n, 1); image J direction (m, 1); gain; the paper's alpha; s, the entry of S for rotational
    joints.
    """

    direction: Expression
    image: Expression
    gain: Expression
    alpha: Expression
    s: Expression


def cauchy_step(model: LocalModel, limit: Expression) -> CauchyStep:
    """The transpose step whose rotational part is at most ``limit`` [rad] long.

    S = diag(1 for prismatic, s for rotational joints) with s = min(1, limit / Q), Q from the step with S = I; then
    alpha = min(alpha0, alpha*(S)), so that the linear model of V falls and the limit holds on mixed arms too.
    """
    J, g = model.J, model.task_gradient
    image = J @ g
    alpha = optimal_gain(sumsqr(g), image)
    s = fmin(1, ratio(limit, alpha * model.rotation_size(g)))
    if model.all_rotational:
        return CauchyStep(g, image, alpha * s, alpha, s)
    limited = _scaled(model, s, g)
    image = J @ limited
    alpha = fmin(alpha, optimal_gain(dot(g, limited), image))
    return CauchyStep(limited, image, alpha, alpha, s)


def printed_step(model: LocalModel, limit: float) -> CauchyStep:
    """The step as the paper prints it: s = 1/Q whenever Q exceeds the limit, and S inside N and D.

    On an all-revolute arm alpha(S) S does not depend on S, so the printed S changes nothing there.
    """
    J, g = model.J, model.task_gradient
    Q = optimal_gain(sumsqr(g), J @ g) * model.rotation_size(g)
    longer = limit < Q
    s = if_else(longer, 1 / if_else(longer, Q, 1), 1)
    limited = _scaled(model, s, g)
    image = J @ limited
    alpha = optimal_gain(dot(g, limited), image)
    return CauchyStep(limited, image, alpha, alpha, s)


def _scaled(model: LocalModel, s: Expression, g: Expression) -> Expression:
    """S g."""
    return vertcat(*[(s if model.rotational[i] else 1) * g[i] for i in range(model.robot.n)])


@dataclass(frozen=True, kw_only=True)
class TransposeStep(TaskStep):
    """The task step of ``Transpose``."""

    rule: Literal["optimal", "paper"]
    q_limit: float
    backtracking: bool

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The fraction of the step that backtracking has come down to."""
        return {"fraction": np.ones(1)} if self.backtracking else {}

    def propose(self, model: LocalModel, state: State) -> TaskMove:
        """-alpha S J' r."""
        rule = printed_step if self.rule == "paper" else cauchy_step
        step = rule(model, self.q_limit)
        gain = state["fraction"] * step.gain if self.backtracking else step.gain
        return TaskMove(gain * step.direction, gain * step.image, gain * norm(step.direction), step.alpha)

    def adapt(self, model: LocalModel, state: State, move: TaskMove, outcome: Outcome) -> State:
        """Half the step after a refusal, twice the fraction after an acceptance."""
        return backtracked(state, outcome) if self.backtracking else {}


def backtracked(state: State, outcome: Outcome) -> State:
    """Fraction of the step to try next."""
    fraction = state["fraction"]
    shorter = if_else(outcome.task_blamed, fraction / 2, fraction)
    return {"fraction": if_else(outcome.accepted, fmin(1, 2 * fraction), shorter)}


def judged(backtracking: bool, secondary: SecondaryTerm) -> Acceptance:
    """How a law with or without backtracking is judged beside this secondary term."""
    if not backtracking:
        return "always"
    bounded_by_beta = isinstance(secondary, ProjectedGradient) and secondary.rule != "merit"
    return "task" if bounded_by_beta else "merit"


@register_strategy("transpose")
@dataclass(frozen=True, kw_only=True)
class Transpose(Composition):
    """dq = -alpha S J' Kp e - beta (I - J+ J) grad H.

    Prefer it to study the paper, or where a bounded step without any factorisation matters more than the number of
    steps: it is steepest descent on V, exact for one task coordinate and slow for ill-conditioned J.

    Attributes:
        rule: ``"optimal"`` (alpha from S = I, then S, then the smaller alpha) or ``"paper"`` (as printed).
        q_limit: limit of Q, the length of the rotational part of a step [rad].
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.

    Source: Das, Slotine and Sheridan (1988), (2.8), (A.10)-(A.12), (B.11).
    """

    rule: Literal["optimal", "paper"] = "optimal"
    q_limit: float = 0.5
    backtracking: bool = True
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    summary = "Jacobian transpose with the optimal alpha, S and backtracking on V"
    source = "Das, Slotine and Sheridan 1988"

    def __post_init__(self) -> None:
        if self.rule not in ("optimal", "paper"):
            raise ArgumentError("rule", self.rule, "'optimal' or 'paper'")
        if not self.q_limit > 0:
            raise ArgumentError("q_limit", self.q_limit, "a positive angle [rad], math.inf for none")

    def task_step(self) -> TaskStep:
        """-alpha S J' Kp e."""
        return TransposeStep(rule=self.rule, q_limit=self.q_limit, backtracking=self.backtracking)

    def secondary_term(self) -> SecondaryTerm:
        """-beta (I - J+ J) grad H."""
        return self.secondary

    def acceptance(self) -> Acceptance:
        """By merit, by the task step, or always."""
        return judged(self.backtracking, self.secondary)

"""The null-space term -beta (I - J+ J) grad H, with three rules for beta (formulations/projected_gradient.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from jtik import register_secondary
from jtik.errors import ArgumentError
from jtik.strategy import LocalModel, NullMove, Outcome, SecondaryTerm, Shape, State
from jtik.symbolic import TINY, Expression, dot, fmax, fmin, if_else, logic_and, ratio, sqrt, sumsqr
from jtik.types import Array

_UNBOUNDED = 1e30

NOISE = 1e-13
"""|h| / |grad H| below which h is rounding, not a direction."""

UNTOLD = 1e-12
"""Change of grad H, relative to it, below which it is rounding and tells no curvature."""

NOTHING, WAY, NULL_STEP = 0.0, 1.0, 2.0
"""What is known of the last step: nothing; where it began; that a null step was most of it."""


@register_secondary("gradient")
@dataclass(frozen=True, kw_only=True)
class ProjectedGradient(SecondaryTerm):
    """nu = -beta h with h = (I - J+ J) grad H, at most ``step_limit`` long.

    Attributes:
        rule: ``"merit"``: beta is the Barzilai-Borwein step of the last accepted move, accepted by merit;
            ``"sqrt"``: the paper's V2 = 1/2 |beta h|^2 may not grow, with the square root its derivation calls for;
            ``"paper"``: the ratio as printed, which shrinks doubly exponentially.
        step_limit: longest null-space step [rad]; not applied by the rule "paper".
        beta_max: first and, for "sqrt" and "paper", largest gain; the unit of q^2 over that of H.
        floor: least |beta h| the rule "sqrt" remembers, so that a start at the optimum of H does not freeze it [rad].

    Source: Das, Slotine and Sheridan (1988), (2.1), (2.9), (A.12); Barzilai and Borwein (1988).
    """

    rule: Literal["merit", "sqrt", "paper"] = "merit"
    step_limit: float = 0.3
    beta_max: float = 1.0
    floor: float = 0.05

    def __post_init__(self) -> None:
        if self.rule not in ("merit", "sqrt", "paper"):
            raise ArgumentError("rule", self.rule, "'merit', 'sqrt' or 'paper'")
        for name in ("step_limit", "beta_max"):
            if not getattr(self, name) > 0:
                raise ArgumentError(name, getattr(self, name), "a positive number")

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """Step cap, and what the rule remembers of the last accepted move."""
        if self.rule != "merit":
            return {"null_energy": np.full(1, _UNBOUNDED)}
        return {
            "null_cap": np.full(1, self.step_limit),
            "seen_at": np.zeros(shape.nq),
            "seen_gradient": np.zeros(shape.n),
            "seen_free": np.zeros(shape.n),
            "seen": np.full(1, NOTHING),
            "beta": np.full(1, self.beta_max),
        }

    def propose(self, model: LocalModel, state: State, task_step: Expression) -> NullMove:
        """The step, capped."""
        h = model.null_gradient
        length = model.null_length
        if self.rule == "merit":
            beta = self.barzilai_borwein(model, state)
            cap = state["null_cap"]
            gain = (length > NOISE * model.gradient_length) * fmin(beta, ratio(cap, length))
            return _along(h, length, gain)
        if self.rule == "sqrt":
            energy = fmax(state["null_energy"], self.floor**2)
            beta = fmin(fmin(self.beta_max, (energy**0.5) / length), self.step_limit / length)
        else:
            energy = state["null_energy"]
            beta = if_else(length**2 > energy, ratio(energy, length**2), self.beta_max)
        return _along(h, length, beta)

    def free_gradient(self, model: LocalModel) -> Expression:
        """h, whose change along a null step is the curvature that beta answers to, (n, 1)."""
        return model.null_gradient

    def barzilai_borwein(self, model: LocalModel, state: State) -> Expression:
        """s's / s'y, s the way that q has come since the last step, y the change of the gradient on it (P2).

        If a null step was most of the way, y is the change of h, and where H is not convex there is no bound. Else y
        is that of grad H; and where H is not convex, or q has not moved, the gain stays as it was.
        """
        way = model.robot.difference(state["seen_at"], model.here.q)
        squared = sumsqr(way)
        free = dot(way, self.free_gradient(model) - state["seen_free"])
        whole = dot(way, model.full_gradient - state["seen_gradient"])
        told = logic_and(state["seen"] == WAY, whole > UNTOLD * sqrt(squared) * model.gradient_length)
        held = if_else(told, squared / whole, state["beta"])
        return if_else(state["seen"] == NULL_STEP, squared / fmax(free, squared / _UNBOUNDED + TINY), held)

    def adapt(self, model: LocalModel, state: State, move: NullMove, outcome: Outcome) -> State:
        """Cap and memory after the step was judged; or the energy V2 the next step may have."""
        if self.rule != "merit":
            energy = move.length**2
            return {"null_energy": if_else(outcome.accepted, energy, state["null_energy"])}
        cap, accepted = state["null_cap"], outcome.accepted
        size = outcome.null.length
        shorter = if_else(outcome.null_blamed, fmin(size, cap) / 4, cap)
        return {
            "null_cap": if_else(accepted, fmin(2 * cap, self.step_limit), shorter),
            "beta": if_else(move.beta > 0, move.beta, state["beta"]),
            "seen_at": model.here.q,
            "seen_gradient": model.full_gradient,
            "seen_free": self.free_gradient(model),
            "seen": if_else(logic_and(accepted, outcome.null_blamed), NULL_STEP, WAY),
        }


def _along(h: Expression, length: Expression, beta: Expression) -> NullMove:
    """beta h, with what it promises: (dH/dv)' h = |h|^2, because h is a projection of dH/dv."""
    return NullMove(term=beta * h, length=beta * length, decrease=beta * length**2, beta=beta)

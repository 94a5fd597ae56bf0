"""The null-space term -beta (I - J+ J) grad H, with three rules for beta (formulations/projected_gradient.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from jtik import register_secondary
from jtik.errors import ArgumentError
from jtik.strategy import LocalModel, NullMove, Outcome, SecondaryTerm, Shape, State
from jtik.symbolic import TINY, Expression, dot, fmax, fmin, if_else, logic_and, norm, ratio, sumsqr

Array = NDArray[np.float64]

_UNBOUNDED = 1e30

NOISE = 1e-13
"""|h| / |grad H| below which h is rounding, not a direction."""

UNTOLD = 1e-12
"""Change of grad H, relative to it, below which it is rounding and tells no curvature."""


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
            "null_gradient": np.zeros(shape.n),
            "null_length": np.zeros(1),
            "seen": np.zeros(1),
            "seen_at": np.zeros(shape.nq),
            "seen_gradient": np.zeros(shape.n),
            "gain": np.zeros(1),
            "beta": np.full(1, self.beta_max),
        }

    def propose(self, model: LocalModel, state: State, task_step: Expression) -> NullMove:
        """The step, capped."""
        h = model.null_gradient
        length = model.null_length
        if self.rule == "merit":
            beta = self._barzilai_borwein(model, h, state)
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

    def _barzilai_borwein(self, model: LocalModel, h: Expression, state: State) -> Expression:
        """s's / s'y of the last null step s, along which h changed by y, if it was most of the way that q has come.

        With s = -gain h0 and y = h - h0 this is gain |h0|^2 / (|h0|^2 - h0'h), without a bound where H is not convex.
        Else s is the whole way and y what grad H changed by on it; as before where q has not moved, or H is not convex.
        """
        squared = state["null_length"] ** 2
        curvature = squared - dot(state["null_gradient"], h)
        known = state["gain"] * squared / fmax(curvature, squared / _UNBOUNDED + TINY)
        way = model.robot.difference(state["seen_at"], model.here.q)
        rise = dot(way, model.full_gradient - state["seen_gradient"])
        told = logic_and(state["seen"], rise > UNTOLD * norm(way) * model.gradient_length)
        seen = if_else(told, sumsqr(way) / rise, state["beta"])
        return if_else(state["gain"] > 0, known, seen)

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
            "null_gradient": model.null_gradient,
            "null_length": model.null_length,
            "gain": if_else(logic_and(accepted, outcome.null_blamed), outcome.null.beta, 0),
            "beta": if_else(move.beta > 0, move.beta, state["beta"]),
            "seen": 1,
            "seen_at": model.here.q,
            "seen_gradient": model.full_gradient,
        }


def _along(h: Expression, length: Expression, beta: Expression) -> NullMove:
    """beta h, with what it promises: (dH/dv)' h = |h|^2, because h is a projection of dH/dv."""
    return NullMove(term=beta * h, length=beta * length, decrease=beta * length**2, beta=beta)

"""The null-space term -beta (I - J+ J) grad H, with three rules for beta (formulations/projected_gradient.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from jtik import register_secondary
from jtik.strategy import (
    LocalModel,
    NonNegative,
    NullSpaceDisplacement,
    Outcome,
    Positive,
    SecondaryTerm,
    Shape,
    State,
)
from jtik.symbolic import Expression, fmax, fmin, if_else, ratio, sqrt
from jtik.types import Array
from jtik_formulations.bibliography import BARZILAI_BORWEIN_1988, DAS_1988
from jtik_formulations.strategies._parts.barzilai_borwein import UNBOUNDED, BarzilaiBorweinGain
from jtik_formulations.strategies._parts.significance import significant


@register_secondary("gradient")
@dataclass(frozen=True, kw_only=True)
class ProjectedGradient(SecondaryTerm):
    """dq = -beta h with h = (I - J+ J) grad H, at most ``step_limit`` long.

    Attributes:
        rule: ``"merit"``: beta is the Barzilai-Borwein step of the last accepted step, accepted by merit;
            ``"sqrt"``: the same, and the paper's V2 = 1/2 |beta h|^2 may not grow, with the square root its derivation
            calls for; ``"paper"``: the ratio as printed, which shrinks doubly exponentially. It is added without a
            test: V may rise anywhere, and where the curvature of H along the self-motion exceeds 2 / beta_max it does
            not converge.
        step_limit: longest null-space step [rad]; not applied by the rule "paper".
        beta_max: first and, for "sqrt" and "paper", largest gain; the unit of q^2 over that of H.
        floor: smallest |beta h| that the rule "sqrt" remembers, so that a start at the optimum of H does not freeze
            it [rad].

    Source: Das, Slotine and Sheridan (1988), (2.1), (2.9), (A.12); Barzilai and Borwein (1988).
    """

    rule: Literal["merit", "sqrt", "paper"] = "merit"
    step_limit: Positive = 0.3
    beta_max: Positive = 1.0
    floor: NonNegative = 0.05

    summary = "projected gradient of the criterion, gain by Barzilai and Borwein or as the paper has it (default)"
    source = "Das, Slotine and Sheridan 1988; Barzilai and Borwein 1988"
    bibtex = "\n".join((DAS_1988, BARZILAI_BORWEIN_1988))

    @property
    def gain(self) -> BarzilaiBorweinGain:
        """The gain of the rule "merit", and a bound of that of "sqrt"."""
        return BarzilaiBorweinGain(self.step_limit, self.beta_max)

    @property
    def bounds_itself(self) -> bool:
        """The paper's rule as printed is supposed to."""
        return self.rule == "paper"

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The state of the gain, and the square of the length |beta h| that the next step may have."""
        state = {} if self.rule == "paper" else dict(self.gain.initial_state(shape))
        return state if self.rule == "merit" else state | {"null_energy": np.full(1, UNBOUNDED)}

    def propose(self, model: LocalModel, state: State, task_dq: Expression) -> NullSpaceDisplacement:
        """The step, capped."""
        h, length = model.null_gradient_free, model.null_gradient_norm
        if self.rule == "paper":
            energy = state["null_energy"]
            beta = if_else(length**2 > energy, ratio(energy, length**2), self.beta_max)
            return _along(h, length, model.null_space_share * beta)
        longest, beta = state["null_cap"], self.gain.gain(model, state, h)
        if self.rule == "sqrt":
            longest = fmin(longest, fmax(sqrt(state["null_energy"]), self.floor))
            beta = fmin(beta, self.beta_max)
        beta = significant(length, model.gradient_norm) * fmin(beta, ratio(longest, length))
        return _along(h, length, model.null_space_share * beta)

    def adapt(self, model: LocalModel, state: State, null_space: NullSpaceDisplacement, outcome: Outcome) -> State:
        """The state of the gain after the outcome is known, and the length that the next step may have."""
        after: dict[str, Expression] = {}
        if self.rule != "paper":
            after |= self.gain.adapt(model, state, model.null_gradient_free, null_space, outcome)
        if self.rule != "merit":
            after["null_energy"] = if_else(outcome.accepted, null_space.length**2, state["null_energy"])
        return after


def _along(h: Expression, length: Expression, beta: Expression) -> NullSpaceDisplacement:
    """-beta h, with what it promises: (dH/dv)' h = |h|^2, because h is a projection of dH/dv."""
    return NullSpaceDisplacement(dq=-beta * h, length=beta * length, decrease=beta * length**2, beta=beta)

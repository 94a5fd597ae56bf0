"""Shortening of a step after a refusal: by a fraction of the step, or by damping."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jtik.strategy.base import State
from jtik.strategy.displacement import Outcome
from jtik.strategy.options import Positive, read_options
from jtik.symbolic import Expression, fmax, fmin, if_else, logic_and
from jtik.types import Array


@dataclass(frozen=True)
class Backtracking:
    """The fraction of a step that is taken: half after a refusal, twice after an acceptance, at most 1.

    Attributes:
        active: whether there is any backtracking; if not, the fraction is 1 and there is no state.
        name: name of the state.
    """

    active: bool = True
    name: str = "fraction"

    def __post_init__(self) -> None:
        read_options(self)

    def initial_state(self) -> Mapping[str, Array]:
        """The fraction 1."""
        return {self.name: np.ones(1)} if self.active else {}

    def fraction(self, state: State) -> Expression:
        """The fraction of this step.

        Args:
            state: state of the strategy, with the fraction in it.
        """
        return state[self.name] if self.active else 1

    def adapt(self, state: State, outcome: Outcome) -> State:
        """The fraction of the next step.

        Args:
            state: state of the strategy, with the fraction of this step.
            outcome: whether the step was accepted, and if not, which parts to shorten.
        """
        if not self.active:
            return {}
        return {self.name: adapted_fraction(state[self.name], outcome.accepted, outcome.shorten_task)}


def adapted_fraction(fraction: Expression, accepted: Expression, shorten: Expression) -> Expression:
    """Twice the fraction, at most 1, after an acceptance; half of it after a refusal if the step is to be shortened.

    Args:
        fraction: the fraction of this step, in (0, 1].
        accepted: 1 if the step was taken, else 0.
        shorten: 1 if a refused step is to be shortened, else 0.
    """
    return if_else(accepted, fmin(1, 2 * fraction), if_else(shorten, fraction / 2, fraction))


def path_backtracking(acceptance: str, has_clearance: bool) -> Backtracking:
    """The fraction of a step that a strategy takes which accepts every step, beside clearances.

    Clearances refuse a step whose path is not proved safe. A strategy without backtracking of its own would try the
    same step for ever.

    Args:
        acceptance: what the strategy's ``acceptance()`` returns.
        has_clearance: whether there is a clearance.
    """
    return Backtracking(active=has_clearance and acceptance == "always", name="path_fraction")


POOR = 0.25
"""Ratio of actual to predicted decrease below which damping is added after an accepted step, too."""


@dataclass(frozen=True)
class AdaptiveDamping:
    """Damping that refusals and poor steps add, and other acceptances remove again.

    Attributes:
        increase: factor after a refusal, or after a step that achieves little of what was predicted.
        decrease: factor after any other step.
        name: name of the state.
    """

    increase: Positive
    decrease: Positive
    name: str = "damping"

    def __post_init__(self) -> None:
        read_options(self)

    def initial_state(self) -> Mapping[str, Array]:
        """No damping."""
        return {self.name: np.zeros(1)}

    def adapt(self, state: State, outcome: Outcome, smallest: Expression) -> State:
        """The damping of the next step.

        Args:
            state: the state before.
            outcome: verdict on the step.
            smallest: smallest damping after a refusal; less would not shorten the step that was refused.
        """
        damping = state[self.name]
        larger = if_else(outcome.shorten_task, fmax(self.increase * damping, smallest), damping)
        removed = logic_and(outcome.accepted, outcome.ratio >= POOR)
        return {self.name: if_else(removed, self.decrease * damping, larger)}

"""The transpose method with a gain from its own last step (formulations/transpose_bb.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import reduce

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
    Update,
)
from jtik.symbolic import dot, fmax, fmin, if_else, logic_and, norm, ratio, sumsqr, vertcat
from jtik.types import Array
from jtik_formulations.strategies.projected_gradient import ProjectedGradient
from jtik_formulations.strategies.transpose import backtracked, judged, optimal_gain

LONGEST = 1.9
"""Most that the monotone gain is of the optimal one; from twice that on, the linear model of V does not fall."""

SUFFICIENT = 1e-4
"""Share of the decrease to first order that a step must bring, below the largest V remembered (Grippo 1986)."""


@dataclass(frozen=True, kw_only=True)
class BarzilaiBorweinStep(TaskStep):
    """The task step of ``TransposeBB``."""

    q_limit: float
    monotone: bool

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The last step taken and J' r before it, zeros at first, and the fraction backtracking has come down to."""
        return {"last_step": np.zeros(shape.n), "last_force": np.zeros(shape.n), "fraction": np.ones(1)}

    def propose(self, model: LocalModel, state: State) -> TaskMove:
        """-alpha J' r."""
        force = model.task_gradient
        image = model.J @ force
        optimal = optimal_gain(sumsqr(force), image)
        step, change = state["last_step"], force - state["last_force"]
        curvature = dot(step, change)
        gain = if_else(curvature > 0, ratio(curvature, sumsqr(change)), optimal)
        if self.monotone:
            gain = fmin(gain, LONGEST * optimal)
        gain = state["fraction"] * fmin(gain, ratio(self.q_limit, model.rotation_size(force)))
        return TaskMove(gain * force, gain * image, gain * norm(force), gain)

    def adapt(self, model: LocalModel, state: State, move: TaskMove, outcome: Outcome) -> State:
        """The step and the force of now if it is taken; after a refusal half the step, after an acceptance twice."""
        return {
            "last_step": if_else(outcome.accepted, -move.term, state["last_step"]),
            "last_force": if_else(outcome.accepted, model.task_gradient, state["last_force"]),
            **backtracked(state, outcome),
        }


@register_strategy("transpose_bb")
@dataclass(frozen=True, kw_only=True)
class TransposeBB(Composition):
    """dq = -alpha J' Kp e - beta (I - J+ J) grad H, with alpha by Barzilai and Borwein.

    alpha is the reciprocal of the curvature of V that the last step has met. Prefer it to ``"transpose"`` wherever no
    matrix is to be factored but the number of steps matters: many rows, many joints.

    Attributes:
        q_limit: limit of Q, the length of the rotational part of a step [rad].
        monotone: whether V falls at every step, for which alpha stays below twice the optimal gain. Without, V must
            fall below the largest of the last ``memory`` values; beside a criterion it makes no difference.
        memory: how many values.
        secondary: the null-space term.

    Source: Barzilai and Borwein (1988); Grippo, Lampariello and Lucidi (1986) and Raydan (1997) for acceptance
    without monotony.
    """

    q_limit: float = 0.5
    monotone: bool = True
    memory: int = 10
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    summary = "Jacobian transpose with the Barzilai-Borwein gain"
    source = "Barzilai and Borwein 1988"

    def __post_init__(self) -> None:
        if not 0 < self.q_limit < np.inf:
            raise ArgumentError("q_limit", self.q_limit, "a positive, finite angle [rad]")
        if not (isinstance(self.memory, int) and self.memory >= 1):
            raise ArgumentError("memory", self.memory, "a whole number from 1")

    def task_step(self) -> TaskStep:
        """-alpha J' Kp e."""
        return BarzilaiBorweinStep(q_limit=self.q_limit, monotone=self.monotone)

    def secondary_term(self) -> SecondaryTerm:
        """-beta (I - J+ J) grad H."""
        return self.secondary

    def acceptance(self) -> Acceptance:
        """By merit, or, without monotony, by the memory."""
        return judged(self.monotone, self.secondary)

    def evaluates_candidate(self, has_criterion: bool) -> bool:
        """Always."""
        return True

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The last values of V besides, 0 before there are any."""
        state = dict(super().initial_state(shape))
        return state if self.monotone or shape.has_criterion else state | {"energies": np.zeros(self.memory)}

    def update(self, model: LocalModel, state: State) -> Update:
        """As composed; without monotony, judged by the memory."""
        if model.has_criterion and not self.monotone:
            return replace(self, monotone=True).update(model, state)
        update = super().update(model, state)
        if self.monotone:
            return update
        kept = [model.here.V, *[state["energies"][i] for i in range(self.memory - 1)]]
        gained = reduce(fmax, kept) - update.point.V
        accepted = logic_and(update.accepted, gained >= SUFFICIENT * dot(model.task_gradient, update.term))
        taken = {**update.state, "energies": vertcat(*kept)}
        refused = {**state, "fraction": state["fraction"] / 2}
        after = {name: if_else(accepted, value, refused[name]) for name, value in taken.items()}
        return replace(update, accepted=accepted, state=after)

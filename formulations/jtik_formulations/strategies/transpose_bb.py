"""The transpose method with a gain from its own last step (formulations/transpose_bb.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import reduce

import numpy as np

from jtik import register_strategy
from jtik.strategy import (
    Acceptance,
    AngleLimit,
    Backtracking,
    Composition,
    LocalModel,
    Outcome,
    PositiveInteger,
    SecondaryTerm,
    Shape,
    State,
    TaskDisplacement,
    TaskStep,
    Update,
    acceptance_beside,
)
from jtik.symbolic import dot, fmax, fmin, if_else, logic_and, norm, ratio, sumsqr, vertcat
from jtik.types import Array
from jtik_formulations.bibliography import BARZILAI_BORWEIN_1988
from jtik_formulations.strategies._parts.transpose_step import optimal_gain
from jtik_formulations.strategies.projected_gradient import ProjectedGradient

BACKTRACKING = Backtracking()
"""The fraction of a step that is taken."""

LARGEST_RATIO = 1.9
"""Largest ratio of the monotone gain to the optimal one; from 2 on, the linear model of V does not fall."""

SUFFICIENT = 1e-4
"""Share of the first-order decrease by which V must fall below the largest remembered V (Grippo 1986)."""


@dataclass(frozen=True, kw_only=True)
class BarzilaiBorweinStep(TaskStep):
    """The task step of ``TransposeBB``.

    Attributes:
        q_limit: limit of Q, the norm of the rotational part of a step [rad].
        monotone: whether the gain is limited so that V falls at every step.
        backtracking: fraction of the step that is taken.
    """

    q_limit: float
    monotone: bool
    backtracking: Backtracking = BACKTRACKING

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The last step taken and the gradient J' r before it, zeros at first, and the fraction to take."""
        last = {"last_step": np.zeros(shape.n), "last_gradient": np.zeros(shape.n)}
        return {**last, **self.backtracking.initial_state()}

    def propose(self, model: LocalModel, state: State) -> TaskDisplacement:
        """-alpha J' r."""
        gradient = model.task_gradient
        image = model.J_free @ gradient
        optimal = optimal_gain(sumsqr(gradient), image, model.curvature * sumsqr(gradient))
        step, change = state["last_step"], gradient - state["last_gradient"]
        curvature = dot(step, change)
        gain = if_else(curvature > 0, ratio(curvature, sumsqr(change)), optimal)
        if self.monotone:
            gain = fmin(gain, LARGEST_RATIO * optimal)
        gain = state["fraction"] * fmin(gain, ratio(self.q_limit, model.rotation_norm(gradient)))
        return TaskDisplacement(-gain * gradient, -gain * image, gain * norm(gradient), gain)

    def adapt(self, model: LocalModel, state: State, task: TaskDisplacement, outcome: Outcome) -> State:
        """The present step and gradient if it is taken, and the fraction to take next."""
        return {
            "last_step": if_else(outcome.accepted, task.dq, state["last_step"]),
            "last_gradient": if_else(outcome.accepted, model.task_gradient, state["last_gradient"]),
            **self.backtracking.adapt(state, outcome),
        }


@register_strategy("transpose_bb")
@dataclass(frozen=True, kw_only=True)
class TransposeBB(Composition):
    """dq = -alpha J' Kp e - beta (I - J+ J) grad H, with alpha by Barzilai and Borwein.

    alpha is the reciprocal of the curvature of V along the last step. Prefer it to ``"transpose"`` wherever no matrix
    is to be factored but the number of steps matters: many rows, many joints.

    Attributes:
        q_limit: limit of Q, the norm of the rotational part of a step [rad].
        monotone: whether V falls at every step, for which alpha stays below twice the optimal gain. Otherwise V must
            fall below the largest of the last ``memory`` values; with a criterion it makes no difference.
        memory: number of values of V remembered.
        secondary: the null-space term.

    Source: Barzilai and Borwein (1988); Grippo, Lampariello and Lucidi (1986) and Raydan (1997) for acceptance
    without monotony.
    """

    q_limit: AngleLimit = 0.5
    monotone: bool = True
    memory: PositiveInteger = 10
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    summary = "Jacobian transpose with the Barzilai-Borwein gain"
    source = "Barzilai and Borwein 1988"
    bibtex = BARZILAI_BORWEIN_1988

    def task_step(self) -> TaskStep:
        """-alpha J' Kp e."""
        return BarzilaiBorweinStep(q_limit=self.q_limit, monotone=self.monotone)

    def secondary_term(self) -> SecondaryTerm:
        """As given."""
        return self.secondary

    def acceptance(self) -> Acceptance:
        """By merit, or, without monotony, by the values remembered."""
        return acceptance_beside(self.monotone, self.secondary)

    def evaluates_candidate(self, has_criterion: bool) -> bool:
        """Always."""
        return True

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The composition's state, and the last values of V, 0 before there are any."""
        state = dict(super().initial_state(shape))
        return state if self.monotone or shape.has_criterion else state | {"energies": np.zeros(self.memory)}

    def update(self, model: LocalModel, state: State) -> Update:
        """As composed; without monotony, accepted by the values remembered."""
        if model.has_criterion and not self.monotone:
            return replace(self, monotone=True).update(model, state)
        update = super().update(model, state)
        if self.monotone:
            return update
        kept = [model.here.V, *[state["energies"][i] for i in range(self.memory - 1)]]
        assert update.candidate is not None
        assert update.state is not None
        decrease = reduce(fmax, kept) - update.candidate.V
        predicted = -dot(model.task_gradient, update.dq)
        accepted = logic_and(update.accepted, decrease >= SUFFICIENT * predicted)
        taken = {**update.state, "energies": vertcat(*kept)}
        refused = {**state, "fraction": state["fraction"] / 2}
        after = {name: if_else(accepted, value, refused[name]) for name, value in taken.items()}
        return replace(update, accepted=accepted, state=after)

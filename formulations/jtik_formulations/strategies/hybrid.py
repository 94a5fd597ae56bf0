"""The paper's hybrid of the transpose method and Newton's, as Powell's dogleg (formulations/hybrid.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from jtik import register_strategy
from jtik.strategy import (
    Acceptance,
    AngleLimit,
    Backtracking,
    Composition,
    LocalModel,
    Outcome,
    SecondaryTerm,
    Shape,
    State,
    TaskDisplacement,
    TaskStep,
    acceptance_beside,
)
from jtik.symbolic import Expression, fmax, fmin, if_else, is_symbolic, logic_and, logic_or, ratio, sqrt, sumsqr
from jtik.symbolic.factorization import RowVector
from jtik.types import Array
from jtik_formulations.bibliography import DAS_1988, POWELL_1970
from jtik_formulations.strategies._parts.damped_least_squares import damped_step
from jtik_formulations.strategies._parts.transpose_step import cauchy_step, optimal_gain
from jtik_formulations.strategies.projected_gradient import ProjectedGradient

BACKTRACKING = Backtracking()
"""The fraction of a step that is taken where prismatic joints move too."""

POOR, GOOD = 0.25, 0.75
"""Ratios of actual to predicted decrease below which the radius shrinks, above which it grows (Nocedal and
Wright 2006, algorithm 4.1)."""

EXPLORING = 0.03
"""Damping of an exploring step relative to V [1 / rad^2]."""


@dataclass(frozen=True, kw_only=True)
class DoglegStep(TaskStep):
    """The task step of ``Hybrid``: from the transpose point towards the Newton point, as far as the radius allows.

    Attributes:
        q_limit: largest trust radius [rad].
        backtracking: fraction of the step that is taken where prismatic joints move too.
    """

    q_limit: float
    backtracking: Backtracking = BACKTRACKING

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The trust radius [rad], and the fraction of the step to take where prismatic joints move too."""
        return {"radius": np.full(1, self.q_limit), **self.backtracking.initial_state()}

    def propose(self, model: LocalModel, state: State) -> TaskDisplacement:
        """The dogleg point."""
        radius = state["radius"]
        if model.timed:
            return self._general(model, state, damped_step(model, model.curvature).completed(model))
        newton = model.row_space_free.least_squares(-model.here.residual)
        if not model.all_rotational:
            return self._general(model, state, TaskDisplacement.along(newton))
        exploring, x = self._exploring(model), model.exploring
        gradient = model.task_gradient_rows
        alpha = optimal_gain(gradient.squared_length, gradient.image)
        s = fmin(1, ratio(radius, alpha * sqrt(gradient.squared_length)))
        gain = -alpha * s  # of the transpose step
        tt, tn, nn = gain * gradient.squared_length * gain, gain * gradient.dot(newton), newton.squared_length
        along = _along(tt, tn, nn, radius, s)
        dogleg = ((1 - along) * gain) * gradient + along * newton
        if exploring:
            dogleg = (1 - x) * dogleg + x * exploring
        return TaskDisplacement.along(dogleg, alpha)

    def _general(self, model: LocalModel, state: State, newton: TaskDisplacement) -> TaskDisplacement:
        """The dogleg to any Newton step, also with prismatic joints: the radius bounds the rotational part only."""
        radius, fraction = state["radius"], self.backtracking.fraction(state)
        transpose = cauchy_step(model, radius)
        towards, step = -transpose.gain * transpose.direction, newton.dq
        tt, tn = model.rotation_dot(towards, towards), model.rotation_dot(towards, step)
        along = _along(tt, tn, model.rotation_dot(step, step), radius, transpose.s)
        of_transpose, of_newton = fraction * (1 - along), fraction * along
        dq = of_transpose * towards + of_newton * step
        image = of_newton * newton.image - of_transpose * transpose.gain * transpose.image
        if exploring := self._exploring(model):
            dq = if_else(model.exploring, exploring.vector, dq)
            image = if_else(model.exploring, exploring.image, image)
        return TaskDisplacement(dq, image, sqrt(sumsqr(dq)), transpose.alpha)

    def _exploring(self, model: LocalModel) -> RowVector | None:
        """The exploring step, longer than any trust radius along weak directions; None if steps never explore."""
        if not is_symbolic(model.exploring):
            return None
        return model.row_space_free.damped(-model.here.residual, EXPLORING * model.here.V)

    def adapt(self, model: LocalModel, state: State, task: TaskDisplacement, outcome: Outcome) -> State:
        """A quarter of the step taken after a poor prediction, twice the radius after a good one at its edge."""
        radius = state["radius"]
        size = model.rotation_norm(task.dq, task.length**2)
        poor = logic_and(outcome.shorten_task, logic_or(outcome.accepted == 0, outcome.ratio < POOR))
        good = logic_and(outcome.ratio > GOOD, size > 0.99 * radius)
        smaller = fmin(if_else(size > 0, size, radius), radius) / 4
        larger = fmin(2 * radius, self.q_limit)
        after = {"radius": if_else(poor, smaller, if_else(good, larger, radius)), "fraction": state["fraction"]}
        if not model.rotational.all():
            after |= self.backtracking.adapt(state, outcome)
        return after


def _along(tt: Expression, tn: Expression, nn: Expression, radius: Expression, s: Expression) -> Expression:
    """How far from the transpose point t to the Newton point n: 1 within the radius, else |t + along (n - t)| = radius.

    From the products t't, t'n and n'n; 0 where S has already shortened the transpose step.
    """
    a, b, c = tt - 2 * tn + nn, tn - tt, tt - radius**2
    along = ratio(sqrt(fmax(b**2 - a * c, 0)) - b, fmax(a, 0))
    return (s >= 1) * if_else(nn <= radius**2, 1, along)


@register_strategy("hybrid")
@dataclass(frozen=True, kw_only=True)
class Hybrid(Composition):
    """The transpose step where Newton's is too long to be trusted, Newton's where it is not, a blend between.

    The default. Without a criterion V never rises; with one it does not outside the neighbourhood of the target, except
    with the paper's rule for beta as printed (formulations/merit.md). It needs as few steps as Newton's method on
    ordinary targets, and converges where the steps of Newton's method are too long: near singular poses and at the
    workspace boundary.

    Attributes:
        q_limit: largest trust radius, a limit of Q, the norm of the rotational part of a step [rad].
        secondary: the null-space term.
        explore: whether `solve` tries exploring steps where V has stopped falling.

    Source: Das, Slotine and Sheridan (1988), section 2.3, proposes the combination; Powell (1970) gives the dogleg.
    """

    q_limit: AngleLimit = 0.5
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)
    explore: bool = True

    summary = "dogleg between the transpose and the Newton step, within an adaptive Q limit (default)"
    source = "Das, Slotine and Sheridan 1988, section 2.3; Powell 1970"
    bibtex = "\n".join((DAS_1988, POWELL_1970))

    def explores(self, has_criterion: bool) -> bool:
        """If not switched off, but beside a secondary term that is added without a test of the merit function."""
        return self.explore and not (has_criterion and self.secondary.bounds_itself)

    def task_step(self) -> TaskStep:
        """The dogleg."""
        return DoglegStep(q_limit=self.q_limit)

    def secondary_term(self) -> SecondaryTerm:
        """As given."""
        return self.secondary

    def acceptance(self) -> Acceptance:
        """By merit, or by the task step."""
        return acceptance_beside(True, self.secondary)

"""Compositions whose task displacement is one full step, scaled to the Q limit and by backtracking."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

from jtik.strategy import (
    Acceptance,
    Backtracking,
    Composition,
    LocalModel,
    Outcome,
    SecondaryTerm,
    Shape,
    State,
    StepLimit,
    TaskDisplacement,
    TaskStep,
    acceptance_beside,
    within_step_limit,
)
from jtik.symbolic import if_else
from jtik.types import Array
from jtik_formulations.strategies.projected_gradient import ProjectedGradient


@dataclass(frozen=True, kw_only=True)
class ScaledComposition(Composition):
    """A full step for the task, scaled as a whole, and a secondary term.

    A subclass writes `full_step`; one with a state of its own also `own_state` and `adapt_own_state`.

    Attributes:
        q_limit: limit of Q, the norm of the rotational part of a step [rad]; math.inf for none.
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.
    """

    q_limit: StepLimit = 0.5
    backtracking: bool = True
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    @abstractmethod
    def full_step(self, model: LocalModel, state: State) -> TaskDisplacement:
        """The task displacement before it is scaled."""

    def own_state(self, shape: Shape) -> Mapping[str, Array]:
        """State of the full step, carried between updates."""
        return {}

    def adapt_own_state(self, model: LocalModel, state: State, outcome: Outcome) -> State:
        """That state after the outcome is known."""
        return {}

    def task_step(self) -> TaskStep:
        """The full step, scaled."""
        return ScaledStep(of=self)

    def secondary_term(self) -> SecondaryTerm:
        """As given."""
        return self.secondary

    def acceptance(self) -> Acceptance:
        """By merit, by the task step, or always."""
        return acceptance_beside(self.backtracking, self.secondary)


@dataclass(frozen=True, kw_only=True)
class ScaledStep(TaskStep):
    """The task step of a `ScaledComposition`.

    Attributes:
        of: the composition.
    """

    of: ScaledComposition

    @property
    def _backtracking(self) -> Backtracking:
        return Backtracking(self.of.backtracking)

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """State of the full step, and the fraction of it to take."""
        return {**self.of.own_state(shape), **self._backtracking.initial_state()}

    def propose(self, model: LocalModel, state: State) -> TaskDisplacement:
        """The full step scaled as a whole, so that the end effector keeps its direction."""
        full = self.of.full_step(model, state)
        row = full.row_vector
        scale = self._backtracking.fraction(state)
        scale = scale * within_step_limit(model, full.dq, self.of.q_limit, row.squared_length if row else None)
        scale = if_else(model.exploring, 1, scale)
        if row:
            return TaskDisplacement.along(scale * row, full.alpha)
        image = None if full.image is None else scale * full.image
        return TaskDisplacement(scale * full.dq, image, alpha=full.alpha)

    def adapt(self, model: LocalModel, state: State, task: TaskDisplacement, outcome: Outcome) -> State:
        """State of the full step, and the fraction to take next."""
        return {**self.of.adapt_own_state(model, state, outcome), **self._backtracking.adapt(state, outcome)}

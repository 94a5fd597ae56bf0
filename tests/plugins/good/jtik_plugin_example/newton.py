"""A strategy: Newton's task step with a shorter limit, any secondary term, acceptance by merit."""

from dataclasses import dataclass, field

from jtik.strategy import (
    Acceptance,
    Backtracking,
    Composition,
    SecondaryTerm,
    TaskDisplacement,
    TaskStep,
    within_step_limit,
)
from jtik_formulations import ProjectedGradient


@dataclass(frozen=True, kw_only=True)
class NewtonStep(TaskStep):
    q_limit: float

    def initial_state(self, shape):
        return Backtracking().initial_state()

    def propose(self, model, state):
        full = model.row_space_free.least_squares(-model.here.residual).vector
        scale = Backtracking().fraction(state) * within_step_limit(model, full, self.q_limit)
        return TaskDisplacement(scale * full)

    def adapt(self, model, state, task, outcome):
        return Backtracking().adapt(state, outcome)


@dataclass(frozen=True, kw_only=True)
class ExampleNewton(Composition):
    """Newton's step, at most ``q_limit`` long, with backtracking.

    Attributes:
        q_limit: limit of the rotational part of a step [rad].
        secondary: the null-space term.
    """

    q_limit: float = 0.2
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    summary = "Newton's step with a shorter limit"
    source = "an example"

    def task_step(self) -> TaskStep:
        return NewtonStep(q_limit=self.q_limit)

    def secondary_term(self) -> SecondaryTerm:
        return self.secondary

    def acceptance(self) -> Acceptance:
        return "merit"

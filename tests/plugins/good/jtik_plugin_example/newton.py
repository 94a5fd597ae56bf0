"""A strategy, composed of parts that jtik has: Newton's task step, a secondary term, acceptance by merit."""

from dataclasses import dataclass, field

from jtik.strategy import Acceptance, Composition, SecondaryTerm, TaskStep
from jtik_formulations import ProjectedGradient
from jtik_formulations.strategies.newton import NewtonStep


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
        return NewtonStep(q_limit=self.q_limit, backtracking=True)

    def secondary_term(self) -> SecondaryTerm:
        return self.secondary

    def acceptance(self) -> Acceptance:
        return "merit"

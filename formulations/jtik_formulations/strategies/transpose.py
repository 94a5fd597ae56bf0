"""The Jacobian-transpose method with alpha and S from its discrete stability proof (formulations/transpose.md)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from jtik import register_strategy
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
)
from jtik.symbolic import norm
from jtik.types import Array
from jtik_formulations.bibliography import DAS_1988
from jtik_formulations.strategies._parts.transpose_step import cauchy_step, printed_step
from jtik_formulations.strategies.projected_gradient import ProjectedGradient


@dataclass(frozen=True, kw_only=True)
class TransposeStep(TaskStep):
    """The task step of ``Transpose``.

    Attributes:
        rule: rule of alpha and S, as in `Transpose`.
        q_limit: limit of Q, the norm of the rotational part of a step [rad].
        backtracking: fraction of the step that is taken.
    """

    rule: Literal["optimal", "paper"]
    q_limit: float
    backtracking: Backtracking

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The fraction of the step to take."""
        return self.backtracking.initial_state()

    def propose(self, model: LocalModel, state: State) -> TaskDisplacement:
        """-alpha S J' r."""
        step = (printed_step if self.rule == "paper" else cauchy_step)(model, self.q_limit)
        gain = self.backtracking.fraction(state) * step.gain
        return TaskDisplacement(-gain * step.direction, -gain * step.image, gain * norm(step.direction), step.alpha)

    def adapt(self, model: LocalModel, state: State, task: TaskDisplacement, outcome: Outcome) -> State:
        """The fraction to take next."""
        return self.backtracking.adapt(state, outcome)


@register_strategy("transpose")
@dataclass(frozen=True, kw_only=True)
class Transpose(Composition):
    """dq = -alpha S J' Kp e - beta (I - J+ J) grad H.

    Prefer it to study the paper, or where a bounded step without any factorisation matters more than the number of
    steps: it is steepest descent on V, exact for one task coordinate and slow for ill-conditioned J.
    For a target just out of reach it may need more than 1000 steps to the closest posture: at 1.5 times the reach in 9
    of 50 solves of a Panda, because steepest descent converges slowly where joints at their limits leave little motion.

    Attributes:
        rule: ``"optimal"`` (alpha from S = I, then S, then the smaller alpha) or ``"paper"`` (as printed).
        q_limit: limit of Q, the norm of the rotational part of a step [rad]; with ``rule="paper"`` of all its entries.
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.

    Source: Das, Slotine and Sheridan (1988), (2.8), (A.10)-(A.12), (B.11).
    """

    rule: Literal["optimal", "paper"] = "optimal"
    q_limit: StepLimit = 0.5
    backtracking: bool = True
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    summary = "Jacobian transpose with the optimal alpha, S and backtracking on V"
    source = "Das, Slotine and Sheridan 1988"
    bibtex = DAS_1988

    def task_step(self) -> TaskStep:
        """-alpha S J' Kp e."""
        return TransposeStep(rule=self.rule, q_limit=self.q_limit, backtracking=Backtracking(self.backtracking))

    def secondary_term(self) -> SecondaryTerm:
        """As given."""
        return self.secondary

    def acceptance(self) -> Acceptance:
        """By merit, by the task step, or always."""
        return acceptance_beside(self.backtracking, self.secondary)

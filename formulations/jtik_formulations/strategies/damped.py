"""Damped least squares, with damping that fades as the error does (formulations/damped.md)."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from jtik import register_strategy
from jtik.errors import ArgumentError
from jtik.strategy import Acceptance, Composition, LocalModel, Outcome, SecondaryTerm, Shape, State, TaskMove, TaskStep
from jtik.symbolic import Expression, fmin, norm, ratio
from jtik.symbolic.factorization import damped_multipliers
from jtik.types import Array
from jtik_formulations.strategies.projected_gradient import ProjectedGradient
from jtik_formulations.strategies.transpose import backtracked, judged


@dataclass(frozen=True, kw_only=True)
class DampedLeastSquares(Composition):
    """dq = -J' (J J' + lambda I)^-1 r - beta (I - J+ J) grad H. Subclasses say what lambda is.

    Attributes:
        q_limit: limit of Q, the length of the rotational part of a step [rad]; math.inf for none.
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.
    """

    q_limit: float = 1.5
    backtracking: bool = True
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    def __post_init__(self) -> None:
        if not self.q_limit > 0:
            raise ArgumentError("q_limit", self.q_limit, "a positive angle [rad], math.inf for none")

    @abstractmethod
    def damping_of(self, model: LocalModel) -> Expression:
        """lambda, in the unit of J J'."""

    def task_step(self) -> TaskStep:
        """-J' (J J' + lambda I)^-1 r."""
        return DampedStep(law=self)

    def secondary_term(self) -> SecondaryTerm:
        """-beta (I - J+ J) grad H."""
        return self.secondary

    def acceptance(self) -> Acceptance:
        """By merit, by the task step, or always."""
        return judged(self.backtracking, self.secondary)


@dataclass(frozen=True, kw_only=True)
class DampedStep(TaskStep):
    """The task step of damped least squares."""

    law: DampedLeastSquares

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The fraction of the step that backtracking has come down to."""
        return {"fraction": np.ones(1)} if self.law.backtracking else {}

    def propose(self, model: LocalModel, state: State) -> TaskMove:
        """-J' (J J' + lambda I)^-1 r, scaled down to the Q limit."""
        full = model.J.T @ damped_multipliers(model.J, self.law.damping_of(model), model.here.residual)
        scale: Expression = state["fraction"] if self.law.backtracking else 1
        if math.isfinite(self.law.q_limit):
            scale = scale * fmin(1, ratio(self.law.q_limit, model.rotation_size(full)))
        term = scale * full
        return TaskMove(term, model.J @ term, norm(term), math.nan)

    def adapt(self, model: LocalModel, state: State, move: TaskMove, outcome: Outcome) -> State:
        """Half the step after a refusal, twice the fraction after an acceptance."""
        return backtracked(state, outcome) if self.law.backtracking else {}


def positive(name: str, value: float) -> None:
    """Refuse what is not a positive, finite number."""
    if not 0 < value < math.inf:
        raise ArgumentError(name, value, "a positive, finite number")


@register_strategy("damped")
@dataclass(frozen=True, kw_only=True)
class Damped(DampedLeastSquares):
    """dq = -J' (J J' + lambda I)^-1 r - beta (I - J+ J) grad H, with lambda in proportion to V.

    The cheapest step that is short near singular poses and quadratic at the target. With ``backtracking=False`` every
    step is taken without a look at where it leads, so that V may rise: together with ``restarts`` that finds *some*
    posture of an arm fastest.

    Attributes:
        damping: lambda / V, [1 / rad^2] where the residual is in [m].
        q_limit, backtracking, secondary: see `DampedLeastSquares`.

    Source: Chan and Lawrence (1988).
    """

    damping: float = 0.1

    summary = "damped least squares, damping in proportion to V, with the Q limit and backtracking"
    source = "Chan and Lawrence 1988"

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("damping", self.damping)

    def damping_of(self, model: LocalModel) -> Expression:
        """Damping times V."""
        return self.damping * model.here.V

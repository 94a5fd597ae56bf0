"""What strategies of damped least squares share: the step for a given damping."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

from jtik.strategy import LocalModel, State, TaskDisplacement
from jtik.symbolic import Expression
from jtik.symbolic.factorization import damped_multipliers
from jtik_formulations.strategies._parts.scaled_step import ScaledComposition


@dataclass(frozen=True, kw_only=True)
class DampedLeastSquares(ScaledComposition):
    """dq = -J' (J J' + mu I)^-1 r - beta (I - J+ J) grad H. A subclass defines mu.

    Attributes:
        q_limit: limit of Q, the norm of the rotational part of a step [rad]; math.inf for none.
        backtracking: halve the step until V falls. Without it every step is taken.
        secondary: the null-space term.
    """

    q_limit: float = 1.5

    @abstractmethod
    def damping_of(self, model: LocalModel) -> Expression:
        """mu, in the unit of J J'."""

    def full_step(self, model: LocalModel, state: State) -> TaskDisplacement:
        """-J' (J J' + mu I)^-1 r."""
        return damped_step(model, self.damping_of(model) + model.curvature)


def damped_step(model: LocalModel, damping: Expression) -> TaskDisplacement:
    """-J' (J J' + mu I)^-1 r for a mu in the unit of J J'."""
    J = model.J_free
    return TaskDisplacement(J.T @ damped_multipliers(J, damping, -model.here.residual))

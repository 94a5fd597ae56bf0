"""The weighted sum of V and H as a merit function, for strategies that are soft."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from jtik.strategy.evaluation import Evaluation
from jtik.strategy.merit import ROUNDING, SUFFICIENT, Merit, Verdict
from jtik.strategy.model import LocalModel
from jtik.strategy.step_limits import not_outward
from jtik.symbolic import Expression, fabs, logic_and, ratio

if TYPE_CHECKING:
    from jtik.strategy.base import State
    from jtik.strategy.programmed import Proposal


@dataclass(frozen=True)
class WeightedMerit(Merit):
    """The merit function gain V + weight H.

    The predicted decrease is that of the quadratic program, ``Proposal.predicted_decrease``.

    Attributes:
        gain: weight of V.
        weight: weight of H [unit of V / unit of H].
    """

    gain: float
    weight: float

    def verdict(self, model: LocalModel, state: State, proposal: Proposal, candidate: Evaluation) -> Verdict:
        """Armijo's test of the sum."""
        actual = self.gain * model.here.decrease(candidate)
        noise: Expression = 0
        progress = None
        if model.has_criterion:
            actual = actual + self.weight * (model.here.H - candidate.H)
            size = self.gain * model.here.V + self.weight * (fabs(model.here.H) + fabs(candidate.H))
            noise, progress = ROUNDING * size, ratio(actual, size)
        predicted = proposal.predicted_decrease
        accepted = logic_and(predicted > 0, actual >= SUFFICIENT * predicted - noise)
        return Verdict(accepted, progress=progress, predicted_decrease=predicted)

    def compromise_residual(self, model: LocalModel, taken: Expression = 0) -> Expression | None:
        """Norm of the gradient of gain V / weight + H that limits and clearances leave, by the joints themselves."""
        if not model.has_criterion:
            return None
        gradient = self.gain * (model.J.T @ model.here.residual) + self.weight * model.gradient + taken
        return ratio(model.joint_gradient_norm(not_outward(model, gradient) * gradient), self.weight)

"""Merit functions, which must fall in an accepted step, and the exact penalty function (formulations/merit.md)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from jtik.strategy.evaluation import Evaluation
from jtik.strategy.model import LocalModel
from jtik.symbolic import Expression, fabs, fmax, fmin, if_else, logic_and, norm, ratio, sqrt
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.strategy.base import Shape, State
    from jtik.strategy.programmed import Proposal

SUFFICIENT = 1e-4
"""Fraction of the predicted decrease that an accepted step must bring (Armijo 1966)."""

ROUNDING = 1e-14
"""Relative error of an evaluated H, and of a residual relative to |J|: a smaller change is not significant."""

LARGEST_INCREASE = 100
"""Largest factor by which one step may raise a penalty weight above its smallest admissible value."""


MEMORY = 0.98
"""Weight of the values of H before in their average, with which an accepted step is compared (Zhang and Hager 2004)."""


@dataclass(frozen=True)
class Verdict:
    """Whether a step decreases the merit function sufficiently.

    Attributes:
        accepted: 1 if it does, else 0.
        ratio: actual over predicted decrease.
        state: state of the merit function after the step, by name.
        progress: relative decrease of what the merit function minimises, if that is not V.
        predicted_decrease: decrease that the model predicts, for the trace; None to report none.
    """

    accepted: Expression
    ratio: Expression = 1
    state: Mapping[str, Expression] = field(default_factory=dict)
    progress: Expression | None = None
    predicted_decrease: Expression | None = None


class Merit(ABC):
    """A merit function of a `Programmed` strategy."""

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """State carried from step to step, such as a penalty weight.

        Args:
            shape: sizes of the problem.
        """
        return {}

    def compromise_residual(self, model: LocalModel, taken: Expression = 0) -> Expression | None:
        """The stationarity residual of a weighted sum of task and criterion; None if the merit function is none.

        Args:
            model: the local model.
            taken: what clearances take of the gradient of the sum (n, 1).
        """
        return None

    @abstractmethod
    def verdict(self, model: LocalModel, state: State, proposal: Proposal, candidate: Evaluation) -> Verdict:
        """Whether the step to ``candidate`` decreases the merit function sufficiently.

        Args:
            model: the local model.
            state: state of the strategy, with that of the merit function.
            proposal: the proposed step.
            candidate: task and criterion after it.
        """


def penalty_weight(
    model: LocalModel,
    before: Expression,
    decrease: Expression,
    reduction: Expression,
    lengths: tuple[Expression, Expression],
    H_after: Expression,
) -> Expression:
    """The penalty weight mu of H + mu |r| for a step, from the one before (M6).

    Args:
        model: the local model.
        before: mu of the step before.
        decrease: predicted decrease of H by the step, to first order.
        reduction: predicted decrease of |r| by the step.
        lengths: squared norms of its task part and of the full step.
        H_after: H where the step ends.
    """
    task, full = lengths
    curvature = ratio(2 * fmax(H_after - model.here.H + decrease, 0), full)
    smallest = 1.5 * norm(model.multipliers)
    smallest += (0.1 * model.gradient_norm + curvature * task**0.5) / model.jacobian_norm
    needed = fmin(ratio(curvature * task - decrease, 0.5 * fmax(reduction, 0)), LARGEST_INCREASE * smallest)
    return fmax(fmax(smallest, 0.5 * before), needed)


def residual_reduction(model: LocalModel, predicted: Expression) -> Expression:
    """Decrease of |r| when V falls by ``predicted``, near the target."""
    return _length(model, model.here) - sqrt(fmax(2 * (_V(model) - predicted), 0))


def penalty_falls(
    model: LocalModel,
    mu: Expression,
    candidate: Evaluation,
    decrease: Expression,
    reduction: Expression,
    allowance: Expression = 0,
) -> Expression:
    """1 where H + mu |r| falls sufficiently and the step ends in the neighbourhood of the target (M5).

    Args:
        model: the local model.
        mu: the penalty weight.
        candidate: task and criterion where the step ends.
        decrease: predicted decrease of H by the step, to first order.
        reduction: predicted decrease of |r| by the step.
        allowance: what H + mu |r| may rise by (M7).
    """
    here = model.here
    predicted = mu * reduction + decrease
    merit, after = (point.H + mu * _length(model, point) for point in (here, candidate))
    noise = ROUNDING * (fabs(here.H) + fabs(merit) + mu * model.jacobian_norm)
    better = logic_and(predicted > -noise, merit + allowance - after >= SUFFICIENT * predicted - noise)
    return logic_and(candidate.length <= model.neighbourhood, better)


def next_allowance(model: LocalModel, allowance: Expression, candidate: Evaluation, mu: Expression) -> Expression:
    """What H + mu |r| may rise by in the step after an accepted one (M7); nothing outside the neighbourhood."""
    decrease = model.here.H - candidate.H
    decrease = fmin(decrease, decrease + mu * (_length(model, model.here) - _length(model, candidate)))
    left = MEMORY * fmax(allowance + decrease, 0)
    return if_else(model.near_target, left, 0)


def _length(model: LocalModel, point: Evaluation) -> Expression:
    """|r| of the residual that the step is made for; near the target of an untimed step the error itself."""
    return norm(point.residual) if model.timed else point.length


def _V(model: LocalModel) -> Expression:
    return model.here.V if model.timed else model.here.V_to_target

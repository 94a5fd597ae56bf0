"""The tests that every accepted step passes, and the decision which part of a refused step is shortened."""

from __future__ import annotations

from typing import Literal, NamedTuple

from jtik.strategy.evaluation import Evaluation
from jtik.strategy.model import LocalModel
from jtik.symbolic import Expression, is_finite, is_symbolic, logic_and, logic_not, logic_or

SIGNIFICANT = 1e-9
"""Predicted decrease of V, relative to it, below which the refusal of a step at rest says nothing about its length."""

Acceptance = Literal["merit", "task", "always"]
"""By which test a step is accepted."""


class FinalVerdict(NamedTuple):
    """The verdict on a step after all tests.

    Attributes:
        accepted: 1 if it is taken.
        shorten_task: 1 if its task part is to be shortened after a refusal.
        shorten_null_space: 1 if its null-space part is.
    """

    accepted: Expression
    shorten_task: Expression
    shorten_null_space: Expression


def final_verdict(
    model: LocalModel,
    dq: Expression,
    candidate: Evaluation,
    accepted: Expression,
    *,
    null_longer: Expression,
    evaluated: bool,
    predicted: Expression | None = None,
) -> FinalVerdict:
    """The verdict of the merit function, and of the tests for clearances and finite numbers.

    Args:
        model: the local model.
        dq: the displacement (n, 1).
        candidate: task and criterion after it.
        accepted: whether the merit function accepts it.
        null_longer: 1 where the null-space part is the longer one and is shortened after a refusal.
        evaluated: whether the strategy depends on task and criterion at the candidate.
        predicted: decrease of V that the linear model predicts; None to compute it.
    """
    shorten_null = null_longer if model.has_criterion else 0
    shorten_task = logic_not(shorten_null) if model.has_criterion else 1
    restores: Expression = 0
    if model.clearance:
        restores = model.restoration.accepts(dq, candidate.length)
        accepted = logic_or(accepted, restores)
    accepted = logic_and(accepted, is_finite(candidate.V_to_target + candidate.H if evaluated else dq))
    if model.clearance:
        clear = model.clearance.keeps(dq)
        accepted = logic_and(accepted, clear)
        # a step whose path is not proved safe is too long: both of its parts are shortened
        shorten_task, shorten_null = (logic_or(part, logic_not(clear)) for part in (shorten_task, shorten_null))
        # what a restoration adds to V says nothing about the length of the task part
        shorten_task = logic_and(shorten_task, logic_not(logic_and(restores, clear)))
    # at rest a refusal by rounding must not shorten the step to the next target
    if model.timed or is_symbolic(model.stagnation_damping):
        predicted = model.predicted_decrease(model.J @ dq) if predicted is None else predicted
        matters = predicted > SIGNIFICANT * model.here.V
        if not model.timed:
            matters = logic_or(matters, model.stagnation_damping <= 0)
        shorten_task = logic_and(shorten_task, matters)
    return FinalVerdict(accepted, shorten_task, shorten_null)

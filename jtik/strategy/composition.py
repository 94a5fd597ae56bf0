"""Strategies made of two parts: a task step that moves the tip, and a secondary term that moves only the null space.

Acceptance, the third part, is here because it is the same for all of them (formulations/merit.md):

- ``"merit"``: outside a tube about the target only V counts, and the null-space motion may not spoil its decrease;
  inside the tube the exact penalty H + mu |r| must fall. Without a criterion this is plain monotone decrease of V.
- ``"task"``: V must fall by the task step alone; the null-space term is added unchecked (the paper's beta rules
  bound it).
- ``"always"``: every step is taken, as the paper prints it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from jtik.strategy.base import Shape, State, Strategy, Update
from jtik.strategy.merit import SUFFICIENT, outweighs, penalty, reach_of
from jtik.strategy.model import LocalModel
from jtik.symbolic import (
    Expression,
    dot,
    fabs,
    fmax,
    if_else,
    is_finite,
    logic_and,
    logic_not,
    logic_or,
    ratio,
    sqrt,
    sumsqr,
    zeros,
)
from jtik.symbolic.factorization import RowVector
from jtik.types import Array

Acceptance = Literal["merit", "task", "always"]


@dataclass(frozen=True)
class TaskMove:
    """The ``term`` (n, 1) a law subtracts from q to move the tip.

    Attributes: term; its image J term (m, 1); its length; the gain alpha a trace reports, NaN for laws without one;
    the term in coordinates of the row space, from a law that has them.
    """

    term: Expression
    image: Expression
    length: Expression
    alpha: Expression
    row_vector: RowVector | None = None

    @classmethod
    def along(cls, step: RowVector, alpha: Expression) -> TaskMove:
        """A step in the row space of J."""
        return cls(step.vector, step.image, sqrt(step.squared_length), alpha, step)


@dataclass(frozen=True)
class NullMove:
    """The ``term`` (n, 1) a law subtracts from q to lower H, such as beta h.

    Attributes: term; its length; the decrease of H it promises to first order, (dH/dv)' term; the gain beta a trace
    reports; how far H is from stationary, where the law knows better than ``model.null_length``; the
    share of the task step to take, where clearances leave no room for all of it; whether both terms together end inside
    the limits as they are; what a trace reports beside beta, scalars by name; what gave way, by name and unit.
    """

    term: Expression
    length: Expression
    decrease: Expression
    beta: Expression
    stationarity_residual: Expression | None = None
    task_scale: Expression = 1
    keeps_limits: bool = False
    figures: Mapping[str, Expression] = field(default_factory=dict)
    relaxed: Mapping[tuple[str, str], Expression] = field(default_factory=dict)


@dataclass(frozen=True)
class Outcome:
    """What became of a proposal.

    Attributes: accepted, 0 or 1; ratio of actual to predicted decrease; null, the null-space part as judged;
    task_blamed and null_blamed: which part is to be shortened after a poor outcome. It is the longer one, so that
    neither pays for the other.
    """

    accepted: Expression
    ratio: Expression
    null: NullMove
    task_blamed: Expression
    null_blamed: Expression


class TaskStep(ABC):
    """The part of an update that moves the tip."""

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """State carried between updates."""
        return {}

    @abstractmethod
    def propose(self, model: LocalModel, state: State) -> TaskMove:
        """A step towards the target."""

    def adapt(self, model: LocalModel, state: State, move: TaskMove, outcome: Outcome) -> State:
        """The state after the outcome is known."""
        return {}


class SecondaryTerm(ABC):
    """The part of an update that lowers H without moving the tip, to first order."""

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """State carried between updates."""
        return {}

    @abstractmethod
    def propose(self, model: LocalModel, state: State, task_term: Expression) -> NullMove:
        """A step in the null space of J."""

    def uses_qp(self) -> bool:
        """Whether it asks a QP solver, by ``model.solve``."""
        return False

    def supports_clearances(self) -> bool:
        """Whether its programs have the rows of clearances, and leave of the task step what they allow."""
        return False

    def correct(self, model: LocalModel, term: Expression) -> Expression:
        """The whole step ``term`` (n, 1), task step and null step, as it is to be tried: within the limits, too."""
        return term

    def adapt(self, model: LocalModel, state: State, move: NullMove, outcome: Outcome) -> State:
        """The state after the outcome is known."""
        return {}


class Composition(Strategy):
    """Task step x secondary term x acceptance. Subclasses say which."""

    @abstractmethod
    def task_step(self) -> TaskStep:
        """The part that moves the tip."""

    @abstractmethod
    def secondary_term(self) -> SecondaryTerm:
        """The part that moves the null space."""

    @abstractmethod
    def acceptance(self) -> Acceptance:
        """How a step is judged."""

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """States of both parts, and the penalty mu."""
        state = dict(self.task_step().initial_state(shape))
        if shape.has_criterion or shape.has_clearance:
            state |= self.secondary_term().initial_state(shape)
        if shape.has_criterion:
            state["penalty"] = np.zeros(1)
        return state

    def evaluates_candidate(self, has_criterion: bool) -> bool:
        """Not where every step is taken and no criterion is at stake."""
        return has_criterion or self.acceptance() != "always"

    def uses_qp(self, has_criterion: bool) -> bool:
        """If its secondary term does, and there is one."""
        return has_criterion and self.secondary_term().uses_qp()

    def supports_clearances(self) -> bool:
        """If its secondary term does."""
        return self.secondary_term().supports_clearances()

    def update(self, model: LocalModel, state: State) -> Update:
        """Propose, join, judge, adapt."""
        task_step, secondary, rule = self.task_step(), self.secondary_term(), self.acceptance()
        task = task_step.propose(model, state)
        task_term = model.within_limits(task.term)
        proposed = NullMove(zeros(model.robot.n), 0, 0, 0)
        if model.has_criterion or model.clearance:
            proposed = secondary.propose(model, state, task_term)
        task_term = proposed.task_scale * task_term
        wanted = task.term + proposed.term
        null = proposed if proposed.keeps_limits else _shortened(model, task_term, proposed)
        term = task_term + null.term
        if model.has_criterion:
            term = secondary.correct(model, term)
        point = model.moved(term)

        as_proposed = not (model.bounded or model.clearance)
        predicted = model.predicted_decrease(task.image if as_proposed else model.J @ task_term)
        judged = model.moved(task_term) if rule == "task" and model.has_criterion else point
        actual = model.here.V - judged.V
        falls = logic_and(predicted > 0, actual >= SUFFICIENT * predicted)
        mu = None
        if rule == "always":
            accepted = 1
        elif rule == "merit" and model.has_criterion:
            unhindered = task.row_vector if as_proposed else None
            rise = model.slope_of_criterion(unhindered) if unhindered else dot(model.gradient, task_term)
            slope, reach = null.decrease + rise, reach_of(model, predicted)
            lengths = (task.length**2, task.length**2 + null.length**2)  # at right angles
            if not (as_proposed and task.row_vector):
                lengths = (sumsqr(task_term), sumsqr(term))
            mu = penalty(model, state["penalty"], slope, reach, lengths, point.H)
            accepted = if_else(model.near, outweighs(model, mu, point, slope, reach), falls)
        elif rule == "task" and model.has_criterion:
            accepted = logic_or(falls, logic_and(model.near, judged.length <= model.tube))
        else:
            accepted = falls
        if model.clearance:
            accepted = logic_or(accepted, model.recovery.takes(term, point.length))
        judges = self.evaluates_candidate(model.has_criterion)
        accepted = logic_and(accepted, is_finite(point.V + point.H if judges else term))
        clear = model.clearance.keeps(term) if model.clearance else 1
        accepted = logic_and(accepted, clear)
        gained = ratio(actual, fmax(predicted, 0))
        if rule == "merit" and model.has_criterion:
            gained = if_else(model.near, accepted, gained)
        null_blamed = null.length > task.length if model.has_criterion else 0
        task_blamed = logic_not(null_blamed) if model.has_criterion else 1
        if model.clearance:  # too long for the way to be known clear: both parts pay
            task_blamed, null_blamed = (logic_or(blamed, logic_not(clear)) for blamed in (task_blamed, null_blamed))
        outcome = Outcome(accepted, gained, null, task_blamed, null_blamed)
        after = dict(task_step.adapt(model, state, task, outcome))
        if model.has_criterion or model.clearance:
            after |= secondary.adapt(model, state, proposed, outcome)
        if model.has_criterion:
            after["penalty"] = state["penalty"] if mu is None else mu
        figures = {
            "alpha": task.alpha,
            "beta": null.beta,
            "V2": null.length**2 / 2,
            "predicted_decrease": predicted,
            "actual_decrease": model.here.V - point.V,
            **proposed.figures,
        }
        stationarity_residual, relaxed = proposed.stationarity_residual, proposed.relaxed
        return Update(point, accepted, after, term, wanted, null.term, figures, stationarity_residual, relaxed=relaxed)


def _shortened(model: LocalModel, task_term: Expression, null: NullMove) -> NullMove:
    """The null step shortened as a whole, so that it keeps its direction and the sum ends inside the limits."""
    if not (model.bounded and model.has_criterion):
        return null
    scale: Expression = 1
    for i, j in model.bounded:
        step = -null.term[j]
        up = model.upper[i] - model.here.q[i] + task_term[j]
        down = model.lower[i] - model.here.q[i] + task_term[j]
        room = if_else(step > 0, up, down)
        moves = fabs(step) > 0
        fraction = room / if_else(moves, step, 1)
        blocked = logic_and(moves, fraction < scale)
        scale = if_else(blocked, fmax(fraction, 0), scale)
    return NullMove(scale * null.term, scale * null.length, scale * null.decrease, scale * null.beta)

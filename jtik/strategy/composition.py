"""Strategies composed of a displacement for the task and one in its null space.

Acceptance, the third part, is the same for all of them (formulations/merit.md):

- ``"merit"``: outside a neighbourhood of the target V must fall by the full step; inside, the exact penalty function
  H + mu |r| must fall. Without a criterion this is monotone decrease of V.
- ``"task"``: V must fall by the task displacement alone; the null-space displacement is added unchecked (the paper's
  rule for beta is supposed to bound it), so V may rise.
- ``"always"``: every step is taken, as in the paper.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, get_args

import numpy as np

from jtik.constructors import Constructed
from jtik.strategy.acceptance import Acceptance, final_verdict
from jtik.strategy.backtracking import path_backtracking
from jtik.strategy.base import Shape, State, Strategy, Update, take_renamed
from jtik.strategy.checked_call import CheckedCall
from jtik.strategy.displacement import NullSpaceDisplacement, Outcome, TaskDisplacement
from jtik.strategy.evaluation import Evaluation
from jtik.strategy.merit import SUFFICIENT, next_allowance, penalty_falls, penalty_weight, residual_reduction
from jtik.strategy.model import LocalModel
from jtik.strategy.options import Part, read_options
from jtik.symbolic import Expression, dot, fmax, if_else, is_symbolic, logic_and, logic_or, ratio, sumsqr
from jtik.symbolic.factorization import RowVector
from jtik.types import Array


class TaskStep(metaclass=Constructed):
    """The part of a composition that moves the end effector."""

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """State carried between updates, for the sizes ``shape`` of the problem."""
        return {}

    @abstractmethod
    def propose(self, model: LocalModel, state: State) -> TaskDisplacement:
        """A displacement towards the target.

        Args:
            model: the local model at q.
            state: this part's state.
        """

    def adapt(self, model: LocalModel, state: State, task: TaskDisplacement, outcome: Outcome) -> State:
        """The state after the outcome is known.

        Args:
            model: the local model at q.
            state: this part's state before the update.
            task: the displacement that `propose` returned.
            outcome: whether the step was accepted, and if not, which parts to shorten.

        Returns:
            New values by name; an entry that is left out is kept.
        """
        return {}


class SecondaryTerm(Part, metaclass=Constructed):
    """The part of a composition that lowers H without moving the end effector, to first order.

    Attributes:
        name: the registry name.
        summary: one line for listings.
        source: author and year of the paper.
        bibtex: BibTeX entries of the source, for `jtik.citations`.
    """

    name: ClassVar[str] = ""
    summary: ClassVar[str] = ""
    source: ClassVar[str] = ""
    bibtex: ClassVar[str] = ""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        take_renamed(cls, {"solves_programs": "uses_qp", "keeps_clear": "supports_clearances"})

    def __post_init__(self) -> None:
        """Read the options of a dataclass by their annotations, see `jtik.strategy.options`."""
        read_options(self)

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """State carried between updates, for the sizes ``shape`` of the problem."""
        return {}

    @abstractmethod
    def propose(self, model: LocalModel, state: State, task_dq: Expression) -> NullSpaceDisplacement:
        """A displacement in the null space of J.

        Args:
            model: the local model at q.
            state: this part's state.
            task_dq: the task displacement (n, 1), to which it is added; within the limits but in a timed step with
                clearances, where the term fits it into both.
        """

    def uses_qp(self) -> bool:
        """Whether it solves quadratic programs, by ``model.solve``."""
        return False

    def supports_clearances(self) -> bool:
        """Whether its QPs have the rows of clearances, and scale the task displacement to what they allow."""
        return False

    @property
    def bounds_itself(self) -> bool:
        """Whether its own rule bounds its length, so that it is added without a test of the merit function."""
        return False

    def correct(self, model: LocalModel, dq: Expression) -> Expression:
        """The displacement to try (n, 1), within the limits, for the sum ``dq`` (n, 1) of both parts.

        Args:
            model: the local model at q.
            dq: the sum of both displacements (n, 1).
        """
        return dq

    def adapt(self, model: LocalModel, state: State, null_space: NullSpaceDisplacement, outcome: Outcome) -> State:
        """The state after the outcome is known.

        Args:
            model: the local model at q.
            state: this part's state before the update.
            null_space: the displacement that `propose` returned.
            outcome: whether the step was accepted, and if not, which parts to shorten.

        Returns:
            New values by name; an entry that is left out is kept.
        """
        return {}


def acceptance_beside(backtracking: bool, secondary: SecondaryTerm) -> Acceptance:
    """The usual acceptance of a composition: by merit, by the task step alone, or always without backtracking.

    Args:
        backtracking: whether a refused step is shortened.
        secondary: the null-space term of the composition.
    """
    if not backtracking:
        return "always"
    return "task" if secondary.bounds_itself else "merit"


class Composition(Strategy):
    """A strategy composed of a task step, a secondary term and an acceptance, which a subclass names."""

    @abstractmethod
    def task_step(self) -> TaskStep:
        """The part that moves the end effector."""

    @abstractmethod
    def secondary_term(self) -> SecondaryTerm:
        """The part that moves the null space."""

    @abstractmethod
    def acceptance(self) -> Acceptance:
        """Which steps are taken."""

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """States of both parts, and the penalty weight mu."""
        state = dict(CheckedCall(self, self._checked_task_step(), "initial_state")(Mapping, shape))  # type: ignore[type-abstract]
        if shape.has_criterion or shape.has_clearance:
            state |= CheckedCall(self, self._checked_secondary_term(), "initial_state")(Mapping, shape)  # type: ignore[type-abstract]
        if shape.has_criterion:
            state["penalty"] = np.zeros(1)
            if self._checked_acceptance() == "merit" and not shape.timed:
                state["allowance"] = np.zeros(1)
        return state | dict(path_backtracking(self._checked_acceptance(), shape.has_clearance).initial_state())

    def evaluates_candidate(self, has_criterion: bool) -> bool:
        """Always, but where every step is taken and there is no criterion."""
        return has_criterion or self._checked_acceptance() != "always"

    def uses_qp(self, has_criterion: bool) -> bool:
        """If its secondary term does, and there is a criterion or a clearance."""
        return has_criterion and CheckedCall(self, self._checked_secondary_term(), "uses_qp").flag()

    def fits_limits(self) -> bool:
        """Always: the task displacement is."""
        return True

    def supports_clearances(self) -> bool:
        """If its secondary term does."""
        return CheckedCall(self, self._checked_secondary_term(), "supports_clearances").flag()

    def update(self, model: LocalModel, state: State) -> Update:
        """Propose both displacements, join them, evaluate the sum, adapt the state."""
        n, task_step = model.robot.n, self._checked_task_step()
        secondary = self._checked_secondary_term() if model.has_criterion or model.clearance else None
        proposing = CheckedCall(self, task_step, "propose")
        task = proposing(TaskDisplacement, model, state).checked(proposing, model).completed(model)
        task_dq = task.dq - model.weak_motion
        if not (model.timed and model.clearance):  # there the limits are in the QP of the clearances
            task_dq = model.fitted(task_dq)
        proposed = NullSpaceDisplacement.none(n)
        if secondary:
            proposing = CheckedCall(self, secondary, "propose")
            proposed = proposing(NullSpaceDisplacement, model, state, task_dq).checked(proposing, n).completed(model)
        task_dq = proposed.task_scale * task_dq if proposed.task_dq is None else proposed.task_dq
        null = proposed if proposed.within_limits else proposed.beside(model, task_dq)
        path = path_backtracking(self._checked_acceptance(), bool(model.clearance))
        if path.active:
            task_dq, null = path.fraction(state) * task_dq, null.scaled(path.fraction(state))
        dq = task_dq + null.dq
        if secondary and model.has_criterion:
            correcting = CheckedCall(self, secondary, "correct")
            dq = correcting.displacement("dq", correcting(object, model, dq), n)
        candidate = model.candidate(dq)

        step = _Step(model, task, task_dq, null, dq, candidate)
        accepted, actual, mu = self._verdict(step, state)
        if is_symbolic(model.exploring):
            accepted = logic_or(accepted, model.exploring)
        evaluated = self.evaluates_candidate(model.has_criterion)
        longer = null.length > task.length
        verdict = final_verdict(
            model, dq, candidate, accepted, null_longer=longer, evaluated=evaluated, predicted=step.predicted
        )
        gained = ratio(actual, fmax(step.predicted, 0))
        if self._checked_acceptance() == "merit" and model.has_criterion:
            gained = if_else(model.near_target, verdict.accepted, gained)
        outcome = Outcome(verdict.accepted, gained, null, verdict.shorten_task, verdict.shorten_null_space)

        after = dict(state) | CheckedCall(self, task_step, "adapt").states(state, model, state, task, outcome)
        after |= path.adapt(state, outcome)
        if secondary:
            after |= CheckedCall(self, secondary, "adapt").states(state, model, state, proposed, outcome)
        if model.has_criterion:
            after["penalty"] = mu
            if "allowance" in state:
                left = next_allowance(model, state["allowance"], candidate, mu)
                after["allowance"] = if_else(verdict.accepted, left, state["allowance"])
        return Update(
            dq=dq,
            accepted=verdict.accepted,
            state=after,
            candidate=candidate,
            wanted=task.dq + proposed.dq,
            null_space=null.dq,
            figures={
                "alpha": task.alpha,
                "beta": null.beta,
                "V2": null.length**2 / 2,
                "predicted_decrease": step.predicted,
                **proposed.figures,
            },
            stationarity_residual=proposed.stationarity_residual,
            relaxed=proposed.relaxed,
        )

    def _checked_task_step(self) -> TaskStep:
        return CheckedCall(self, self, "task_step")(TaskStep)  # type: ignore[type-abstract]

    def _checked_secondary_term(self) -> SecondaryTerm:
        return CheckedCall(self, self, "secondary_term")(SecondaryTerm)  # type: ignore[type-abstract]

    def _checked_acceptance(self) -> str:
        return CheckedCall(self, self, "acceptance").choice(get_args(Acceptance))

    def _verdict(self, step: _Step, state: State) -> tuple[Expression, Expression, Expression]:
        """Whether the step is accepted, by how much V falls, and the penalty weight after it."""
        rule, model, penalty = self._checked_acceptance(), step.model, state.get("penalty")
        by_task = rule == "task" and model.has_criterion
        candidate = model.candidate(step.task_dq) if by_task else step.candidate
        actual = model.here.decrease(candidate)
        falls = logic_and(step.predicted > 0, actual >= SUFFICIENT * step.predicted)
        if rule == "always":
            return 1, actual, penalty
        if by_task:
            stays = logic_and(model.near_target, candidate.length <= model.neighbourhood)
            return logic_or(falls, stays), actual, penalty
        if not model.has_criterion:
            return falls, actual, penalty
        decrease, reduction = step.decrease_of_criterion, residual_reduction(model, step.predicted)
        mu = penalty_weight(model, penalty, decrease, reduction, step.squared_lengths, step.candidate.H)
        allowance = state.get("allowance", 0)
        better = penalty_falls(model, mu, step.candidate, decrease, reduction, allowance)
        return if_else(model.near_target, better, falls), actual, mu


@dataclass(frozen=True)
class _Step:
    """A step of a composition before the acceptance tests.

    Attributes:
        model: the local model.
        task: the task displacement as proposed.
        task_dq: its displacement as it is tried, within limits and clearances (n, 1).
        null: the null-space displacement as it is tried.
        dq: the sum of both displacements (n, 1).
        candidate: task and criterion after it.
    """

    model: LocalModel
    task: TaskDisplacement
    task_dq: Expression
    null: NullSpaceDisplacement
    dq: Expression
    candidate: Evaluation

    @property
    def as_proposed(self) -> bool:
        """Whether neither limits nor clearances can have changed the task displacement."""
        return not (self.model.bounded or self.model.clearance or self.model.accelerated)

    @cached_property
    def predicted(self) -> Expression:
        """Decrease of V that the linear model predicts for the task displacement."""
        J = self.model.J if self.model.timed else self.model.J_free
        image = self.task.image if self.as_proposed else J @ self.task_dq
        return self.model.predicted_decrease(image)

    @property
    def _row_vector(self) -> RowVector | None:
        return self.task.row_vector if self.as_proposed else None

    @property
    def decrease_of_criterion(self) -> Expression:
        """Predicted decrease of H by both displacements, to first order."""
        row = self._row_vector
        gradient = self.model.gradient if self.model.timed else self.model.gradient_free
        change = self.model.criterion_change(row) if row else dot(gradient, self.task_dq)
        return self.null.decrease - change

    @property
    def squared_lengths(self) -> tuple[Expression, Expression]:
        """Squared norms of the task displacement and of the sum of both displacements."""
        if self._row_vector:  # the two parts are orthogonal
            return self.task.length**2, self.task.length**2 + self.null.length**2
        return sumsqr(self.task_dq), sumsqr(self.dq)

"""Base class of strategies that propose one displacement, usually from quadratic programs."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import get_args

from jtik.strategy.acceptance import Acceptance, final_verdict
from jtik.strategy.backtracking import AdaptiveDamping, Backtracking, path_backtracking
from jtik.strategy.base import Shape, State, Strategy, Update
from jtik.strategy.checked_call import CheckedCall
from jtik.strategy.composition import SecondaryTerm
from jtik.strategy.displacement import NullSpaceDisplacement, Outcome
from jtik.strategy.evaluation import Evaluation
from jtik.strategy.merit import Merit, Verdict
from jtik.strategy.model import LocalModel
from jtik.symbolic import Expression, norm
from jtik.types import Array

SMALLEST_DAMPING = 1e-4
"""Smallest damping after a refusal, relative to |J|^2."""


@dataclass(frozen=True)
class Proposal:
    """The displacement that a `Programmed` strategy proposes. Only ``dq`` is needed.

    Attributes:
        dq: displacement that is added to q (n, 1).
        task: the part of it for the tasks (n, 1); ``dq`` without the null-space part by default.
        null_space: the part of it for the criterion; none by default.
        null_space_unlimited: the same before limits and backtracking shortened it; ``null_space`` by default.
        null_space_longer: 1 where the null-space part is longer than the task part; by default from their norms.
        wanted: the displacement before limits and backtracking shortened it (n, 1); ``dq`` by default.
        predicted_decrease: decrease of the merit function that the quadratic program predicts, for a merit function
            that uses it.
        smallest_damping: smallest damping after a refusal; ``SMALLEST_DAMPING`` |J|^2 by default.
        state: entries of the strategy's own state after the step.
        figures: further scalars for the trace, by name.
        stationarity_residual: stationarity residual of H; that of the null-space part or of the engine by default.
        compromise_residual: norm of the projected gradient of what a soft strategy minimises, as in `Update`; that of
            the merit function by default.
        relaxed: amount by which each constraint is relaxed, non-negative, by (name, unit).
    """

    dq: Expression
    task: Expression = None
    null_space: NullSpaceDisplacement | None = None
    null_space_unlimited: NullSpaceDisplacement | None = None
    null_space_longer: Expression = None
    wanted: Expression = None
    predicted_decrease: Expression = None
    smallest_damping: Expression = None
    state: State = field(default_factory=dict)
    figures: Mapping[str, Expression] = field(default_factory=dict)
    stationarity_residual: Expression | None = None
    compromise_residual: Expression | None = None
    relaxed: Mapping[tuple[str, str], Expression] = field(default_factory=dict)

    def scaled(self, share: Expression) -> Proposal:
        """``share``, in [0, 1], of a proposal whose defaults are filled in."""
        assert self.null_space is not None
        return replace(self, dq=share * self.dq, task=share * self.task, null_space=self.null_space.scaled(share))


class Programmed(Strategy):
    """A strategy that computes one displacement by quadratic programs and tests it by a merit function.

    A subclass writes `propose` and names its `merit`. Acceptance, damping after a refusal, feasibility restoration,
    clearances, the report of relaxed constraints, and figures are provided by this class and the engine. The state
    joins those of `own_state`, of the merit function, of `shortening`, and of the `secondary_term`.
    """

    @abstractmethod
    def propose(self, model: LocalModel, state: State) -> Proposal:
        """The displacement, from the local model and the state.

        Args:
            model: the local model at q.
            state: the state of the strategy.
        """

    @abstractmethod
    def merit(self) -> Merit | None:
        """The merit function that must fall in an accepted step; None if every step is taken."""

    def acceptance(self) -> Acceptance:
        """``"merit"``: the merit function must fall; ``"always"``: every step is taken."""
        return "always" if self.merit() is None else "merit"

    def shortening(self) -> AdaptiveDamping | Backtracking | None:
        """How the next step is shortened after a refusal; None if the strategy's own state does that.

        A strategy that takes every step needs none: beside clearances, which may refuse a step, it takes a fraction
        of its step, half of it after a refusal.
        """
        return None

    def secondary_term(self) -> SecondaryTerm | None:
        """The secondary term whose state this strategy carries, if it uses one."""
        return None

    def own_state(self, shape: Shape) -> Mapping[str, Array]:
        """Entries of the state that only this strategy has.

        Args:
            shape: sizes of the problem.
        """
        return {}

    def adapt(self, model: LocalModel, state: State, proposal: Proposal, outcome: Outcome) -> State:
        """The entries of `own_state` after the outcome is known; by default those of ``proposal.state``.

        Args:
            model: the local model at q.
            state: the state before the update.
            proposal: what `propose` returned.
            outcome: whether the step was accepted, and if not, which parts to shorten.
        """
        return proposal.state

    def uses_qp(self, has_criterion: bool) -> bool:
        """Always."""
        return True

    def evaluates_candidate(self, has_criterion: bool) -> bool:
        """Always, but where every step is taken and there is no criterion."""
        return self._checked_acceptance() != "always" or has_criterion

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The states of all parts."""
        merit, shortening, secondary = self._checked_parts()
        state = dict(CheckedCall(self, self, "own_state")(Mapping, shape))  # type: ignore[type-abstract]
        if merit:
            state |= CheckedCall(self, merit, "initial_state")(Mapping, shape)  # type: ignore[type-abstract]
        if shortening:
            state |= shortening.initial_state()
        if secondary and (shape.has_criterion or shape.has_clearance):
            state |= CheckedCall(self, secondary, "initial_state")(Mapping, shape)  # type: ignore[type-abstract]
        return state | dict(self._path(shape.has_clearance).initial_state())

    def update(self, model: LocalModel, state: State) -> Update:
        """Propose, test, adapt the state."""
        proposal, path = self._proposed(model, state), self._path(bool(model.clearance))
        if path.active:
            proposal = proposal.scaled(path.fraction(state))
        null = proposal.null_space
        assert null is not None
        candidate = model.candidate(proposal.dq)
        verdict = self._checked_verdict(model, state, proposal, candidate)
        longer = proposal.null_space_longer
        final = final_verdict(
            model,
            proposal.dq,
            candidate,
            1 if self._checked_acceptance() == "always" else verdict.accepted,
            null_longer=null.length > norm(proposal.task) if longer is None else longer,
            evaluated=self.evaluates_candidate(model.has_criterion),
        )
        outcome = Outcome(final.accepted, verdict.ratio, null, final.shorten_task, final.shorten_null_space)
        return Update(
            dq=proposal.dq,
            accepted=final.accepted,
            state={
                **state,
                **verdict.state,
                **self._adapted(model, state, proposal, outcome),
                **path.adapt(state, outcome),
            },
            candidate=candidate,
            wanted=proposal.wanted,
            null_space=null.dq,
            figures={
                "beta": null.beta,
                "V2": null.length**2 / 2,
                **({} if verdict.predicted_decrease is None else {"predicted_decrease": verdict.predicted_decrease}),
                **null.figures,
                **proposal.figures,
            },
            stationarity_residual=proposal.stationarity_residual,
            compromise_residual=proposal.compromise_residual,
            progress=verdict.progress,
            relaxed={**null.relaxed, **proposal.relaxed},
        )

    def _path(self, has_clearance: bool) -> Backtracking:
        """The fraction of a step to take where the strategy accepts every step and clearances do not."""
        shortened = self._checked_parts()[1] is not None
        return path_backtracking(self._checked_acceptance(), has_clearance and not shortened)

    def _proposed(self, model: LocalModel, state: State) -> Proposal:
        """What `propose` returns, checked and with its defaults filled in."""
        call, n = CheckedCall(self, self, "propose"), model.robot.n
        given = call(Proposal, model, state)
        dq = call.displacement("dq", given.dq, n)
        null = unlimited = NullSpaceDisplacement.none(n)
        if given.null_space is not None:
            null = unlimited = self._checked_null_space(call, "null_space", given.null_space, model)
        if given.null_space_unlimited is not None:
            unlimited = self._checked_null_space(call, "null_space_unlimited", given.null_space_unlimited, model)
        task = (dq if given.null_space is None else dq - null.dq) if given.task is None else given.task
        residual = call.optional("stationarity_residual", given.stationarity_residual)
        return Proposal(
            dq=dq,
            task=call.displacement("task", task, n),
            null_space=null,
            null_space_unlimited=unlimited,
            null_space_longer=call.optional("null_space_longer", given.null_space_longer),
            wanted=dq if given.wanted is None else call.displacement("wanted", given.wanted, n),
            predicted_decrease=call.optional("predicted_decrease", given.predicted_decrease),
            smallest_damping=call.optional("smallest_damping", given.smallest_damping),
            state=call.instance("state", given.state, Mapping),  # type: ignore[type-abstract]
            figures=call.figures("figures", given.figures),
            stationarity_residual=null.stationarity_residual if residual is None else residual,
            compromise_residual=self._compromise_residual(call, given, model),
            relaxed=call.relaxed("relaxed", given.relaxed),
        )

    def _compromise_residual(self, call: CheckedCall, given: Proposal, model: LocalModel) -> Expression | None:
        """That of the proposal or else of the merit function, checked."""
        merit = self._checked_parts()[0]
        if given.compromise_residual is not None or merit is None:
            return call.optional("compromise_residual", given.compromise_residual)
        call = CheckedCall(self, merit, "compromise_residual")
        return call.optional("residual", merit.compromise_residual(model))

    def _checked_null_space(
        self, call: CheckedCall, what: str, given: object, model: LocalModel
    ) -> NullSpaceDisplacement:
        """A null-space displacement of a proposal, checked and completed."""
        return (
            call.instance(what, given, NullSpaceDisplacement).checked(call, model.robot.n, f"{what}.").completed(model)
        )

    def _checked_verdict(self, model: LocalModel, state: State, proposal: Proposal, candidate: Evaluation) -> Verdict:
        """The merit function's verdict, checked."""
        merit = self._checked_parts()[0]
        if merit is None:
            return Verdict(1)
        call = CheckedCall(self, merit, "verdict")
        given = call(Verdict, model, state, proposal, candidate)
        return Verdict(
            accepted=call.column("accepted", given.accepted, 1),
            ratio=call.column("ratio", given.ratio, 1),
            state=call.state("state", given.state, state),
            progress=call.optional("progress", given.progress),
            predicted_decrease=call.optional("predicted_decrease", given.predicted_decrease),
        )

    def _adapted(self, model: LocalModel, state: State, proposal: Proposal, outcome: Outcome) -> State:
        """The state of all parts but the merit function."""
        _, shortening, secondary = self._checked_parts()
        after = CheckedCall(self, self, "adapt").states(state, model, state, proposal, outcome)
        if isinstance(shortening, AdaptiveDamping):
            smallest = proposal.smallest_damping
            if smallest is None:
                smallest = SMALLEST_DAMPING * model.row_space.squared_length
            after |= shortening.adapt(state, outcome, smallest)
        elif shortening:
            after |= shortening.adapt(state, outcome)
        if secondary and (model.has_criterion or model.clearance):
            null = proposal.null_space_unlimited
            after |= CheckedCall(self, secondary, "adapt").states(state, model, state, null, outcome)
        return after

    def _checked_parts(self) -> tuple[Merit | None, AdaptiveDamping | Backtracking | None, SecondaryTerm | None]:
        """Merit function, shortening and secondary term, checked."""
        merit = CheckedCall(self, self, "merit").optional_part((Merit,))
        shortening = CheckedCall(self, self, "shortening").optional_part((AdaptiveDamping, Backtracking))
        return merit, shortening, CheckedCall(self, self, "secondary_term").optional_part((SecondaryTerm,))

    def _checked_acceptance(self) -> str:
        return CheckedCall(self, self, "acceptance").choice(get_args(Acceptance))

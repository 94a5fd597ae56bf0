"""Base class of strategies that propose one displacement, usually from quadratic programs."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from jtik.strategy.acceptance import Acceptance, final_verdict
from jtik.strategy.backtracking import AdaptiveDamping, Backtracking
from jtik.strategy.base import Shape, State, Strategy, Update
from jtik.strategy.composition import SecondaryTerm
from jtik.strategy.displacement import NullSpaceDisplacement, Outcome
from jtik.strategy.errors import CheckedCall
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
    relaxed: Mapping[tuple[str, str], Expression] = field(default_factory=dict)


class Programmed(Strategy):
    """A strategy that computes one displacement by quadratic programs and tests it by a merit function.

    A subclass writes `propose` and names its `merit`. Acceptance, damping after a refusal, feasibility restoration,
    clearances, the report of relaxed constraints, and figures are provided by this class and the engine. The state
    joins those of `own_state`, of the merit function, of `shortening`, and of the `secondary_term`.
    """

    @abstractmethod
    def propose(self, model: LocalModel, state: State) -> Proposal:
        """The displacement, from the local model and the state."""

    @abstractmethod
    def merit(self) -> Merit | None:
        """The merit function that must fall in an accepted step; None if every step is taken."""

    def acceptance(self) -> Acceptance:
        """``"merit"``: the merit function must fall; ``"always"``: every step is taken."""
        return "always" if self.merit() is None else "merit"

    def shortening(self) -> AdaptiveDamping | Backtracking | None:
        """How the next step is shortened after a refusal; None if the strategy's own state does that."""
        return None

    def secondary_term(self) -> SecondaryTerm | None:
        """The secondary term whose state this strategy carries, if it uses one."""
        return None

    def own_state(self, shape: Shape) -> Mapping[str, Array]:
        """Entries of the state that only this strategy has."""
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
        return self.acceptance() != "always" or has_criterion

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The states of all parts."""
        merit, shortening, secondary = self.merit(), self.shortening(), self.secondary_term()
        state = dict(self.own_state(shape))
        if merit:
            state |= merit.initial_state(shape)
        if shortening:
            state |= shortening.initial_state()
        if secondary and (shape.has_criterion or shape.has_clearance):
            state |= secondary.initial_state(shape)
        return state

    def update(self, model: LocalModel, state: State) -> Update:
        """Propose, test, adapt the state."""
        proposal = self._proposed(model, state)
        null = proposal.null_space
        assert null is not None
        candidate = model.candidate(proposal.dq)
        merit = self.merit()
        verdict = merit.verdict(model, state, proposal, candidate) if merit else Verdict(1)
        longer = proposal.null_space_longer
        final = final_verdict(
            model,
            proposal.dq,
            candidate,
            1 if self.acceptance() == "always" else verdict.accepted,
            null_longer=null.length > norm(proposal.task) if longer is None else longer,
            evaluated=self.evaluates_candidate(model.has_criterion),
        )
        outcome = Outcome(final.accepted, verdict.ratio, null, final.shorten_task, final.shorten_null_space)
        return Update(
            dq=proposal.dq,
            accepted=final.accepted,
            state={**verdict.state, **self._adapted(model, state, proposal, outcome)},
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
            progress=verdict.progress,
            relaxed={**null.relaxed, **proposal.relaxed},
        )

    def _proposed(self, model: LocalModel, state: State) -> Proposal:
        """What `propose` returns, checked and with its defaults filled in."""
        call, n = CheckedCall(self, self.propose), model.robot.n
        proposal = call(Proposal, model, state)
        dq = call.column("dq", proposal.dq, n)
        null = proposal.null_space or NullSpaceDisplacement.none(n)
        null = replace(null, dq=call.column("null_space.dq", null.dq, n)).completed(model)
        residual = proposal.stationarity_residual
        return replace(
            proposal,
            dq=dq,
            task=(dq - null.dq if proposal.null_space else dq)
            if proposal.task is None
            else call.column("task", proposal.task, n),
            null_space=null,
            null_space_unlimited=proposal.null_space_unlimited or null,
            wanted=dq if proposal.wanted is None else call.column("wanted", proposal.wanted, n),
            stationarity_residual=null.stationarity_residual if residual is None else residual,
        )

    def _adapted(self, model: LocalModel, state: State, proposal: Proposal, outcome: Outcome) -> State:
        """The state of all parts but the merit function."""
        shortening, secondary = self.shortening(), self.secondary_term()
        after = dict(self.adapt(model, state, proposal, outcome))
        if isinstance(shortening, AdaptiveDamping):
            smallest = proposal.smallest_damping
            if smallest is None:
                smallest = SMALLEST_DAMPING * model.row_space.squared_length
            after |= shortening.adapt(state, outcome, smallest)
        elif shortening:
            after |= shortening.adapt(state, outcome)
        if secondary and (model.has_criterion or model.clearance):
            null = proposal.null_space_unlimited
            assert null is not None
            after |= secondary.adapt(model, state, null, outcome)
        return after

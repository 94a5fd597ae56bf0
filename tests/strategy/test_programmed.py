"""Strategies with one displacement: the parts of a proposal, the merit, damping after a refusal, the state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi
import numpy as np
import pytest

from jtik.strategy import (
    AdaptiveDamping,
    Backtracking,
    Merit,
    NullSpaceDisplacement,
    Programmed,
    Proposal,
    SecondaryTerm,
    Shape,
    Verdict,
)
from jtik.strategy.programmed import SMALLEST_DAMPING

from .conftest import numbers, quadratic_model

J = np.array([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
R = np.array([0.3, -0.4])
DQ = np.array([-0.3, 0.2, 0.1])
NULL = np.array([0.0, 0.0, 0.1])


@dataclass(frozen=True)
class Fixed(Merit):
    """A merit whose verdict is given."""

    given: Verdict

    def initial_state(self, shape):
        return {"merit": np.zeros(1)}

    def verdict(self, model, state, proposal, candidate):
        return self.given


class Term(SecondaryTerm):
    """A secondary term that keeps the length of the displacement it is given."""

    def initial_state(self, shape):
        return {"term": np.zeros(1)}

    def propose(self, model, state, task_dq):
        raise AssertionError("the strategy proposes by itself")

    def adapt(self, model, state, null_space, outcome):
        return {"term": null_space.length}


@dataclass(frozen=True)
class Proposing(Programmed):
    proposal: Proposal
    verdict: Verdict | None = Verdict(1)  # noqa: RUF009
    shortened: Any = None
    term: SecondaryTerm | None = None

    def propose(self, model, state):
        return self.proposal

    def merit(self):
        return Fixed(self.verdict) if self.verdict else None

    def shortening(self):
        return self.shortened

    def secondary_term(self):
        return self.term

    def own_state(self, shape):
        return {"own": np.zeros(1)}


def updated(proposal, verdict=Verdict(1), state=None, *, criterion=True, shortened=None, term=None):  # noqa: B008
    model = quadratic_model(J, R, gradient=np.array([0.0, 0.0, -1.0]) if criterion else None)
    state = {name: casadi.SX(0) for name in ("own", "merit", "term")} | (state or {})
    return Proposing(proposal, verdict, shortened, term).update(model, state)


def null_space(**options):
    return NullSpaceDisplacement(casadi.SX(NULL), **options)


class TestProposal:
    def test_dq_is_enough(self):
        update = updated(Proposal(casadi.SX(DQ)))
        assert numbers(update.dq).tolist() == DQ.tolist()
        assert numbers(update.wanted).tolist() == DQ.tolist()
        assert numbers(update.null_space).tolist() == [0, 0, 0]
        assert (update.figures["beta"], update.figures["V2"], update.relaxed) == (0, 0, {})

    def test_the_candidate_is_where_it_ends(self):
        update = updated(Proposal(casadi.SX(DQ)))
        assert numbers(update.candidate.residual) == pytest.approx(R + J @ DQ)

    def test_the_task_part_is_the_rest_beside_the_null_space_part(self):
        """The longer part is the one to shorten: the null-space part only where it exceeds DQ - NULL."""
        shortened = Backtracking()
        for null, shorten in ((NULL, True), (DQ, False)):
            proposal = Proposal(casadi.SX(DQ), null_space=NullSpaceDisplacement(casadi.SX(null)))
            update = updated(proposal, Verdict(0), {"fraction": casadi.SX(1)}, shortened=shortened)
            assert (numbers(update.state["fraction"]) == 0.5) is shorten

    def test_it_may_say_which_part_is_longer(self):
        proposal = Proposal(casadi.SX(DQ), null_space=null_space(), null_space_longer=1)
        update = updated(proposal, Verdict(0), {"fraction": casadi.SX(1)}, shortened=Backtracking())
        assert numbers(update.state["fraction"]) == 1

    def test_figures_and_relaxations_of_both_parts_are_joined(self):
        null = null_space(beta=0.4, figures={"a": 1.0}, relaxed={("a", "m"): 2.0})
        proposal = Proposal(casadi.SX(DQ), null_space=null, figures={"b": 3.0}, relaxed={("b", ""): 4.0})
        update = updated(proposal, Verdict(1, predicted_decrease=5.0))
        figures = {name: numbers(value) for name, value in update.figures.items()}
        assert figures == pytest.approx({"beta": 0.4, "V2": 0.005, "predicted_decrease": 5.0, "a": 1.0, "b": 3.0})
        assert update.relaxed == {("a", "m"): 2.0, ("b", ""): 4.0}

    def test_the_stationarity_residual_is_the_strategys_else_the_null_space_parts(self):
        null = null_space(stationarity_residual=6.0)
        assert updated(Proposal(casadi.SX(DQ), null_space=null)).stationarity_residual == 6.0
        own = Proposal(casadi.SX(DQ), null_space=null, stationarity_residual=7.0)
        assert updated(own).stationarity_residual == 7.0
        assert updated(Proposal(casadi.SX(DQ))).stationarity_residual is None


class TestAcceptance:
    @pytest.mark.parametrize("accepted", [0, 1])
    def test_the_merit_decides(self, accepted):
        update = updated(Proposal(casadi.SX(DQ)), Verdict(accepted, progress=0.3))
        assert numbers(update.accepted) == accepted
        assert update.progress == 0.3

    def test_without_a_merit_every_finite_step_is_taken(self):
        assert numbers(updated(Proposal(casadi.SX(-DQ)), None).accepted) == 1
        root = casadi.SX.sym("root")
        step = updated(Proposal(casadi.SX(DQ) * casadi.sqrt(root)), None).accepted
        finite = casadi.Function("finite", [root], [step])
        assert [float(finite(number)) for number in (1.0, -1.0)] == [1, 0]

    def test_the_candidate_is_evaluated_unless_every_step_is_taken_without_a_criterion(self):
        proposal = Proposal(casadi.SX(DQ))
        with_merit, without = Proposing(proposal), Proposing(proposal, None)
        assert [with_merit.acceptance(), without.acceptance()] == ["merit", "always"]
        assert [with_merit.evaluates_candidate(c) for c in (False, True)] == [True, True]
        assert [without.evaluates_candidate(c) for c in (False, True)] == [False, True]


class TestState:
    def test_the_first_one_has_those_of_all_parts(self):
        strategy = Proposing(Proposal(casadi.SX(DQ)), shortened=AdaptiveDamping(10, 0.5), term=Term())
        assert set(strategy.initial_state(Shape(3, 3, 2, True))) == {"own", "merit", "damping", "term"}
        assert set(strategy.initial_state(Shape(3, 3, 2, False))) == {"own", "merit", "damping"}
        assert set(Proposing(Proposal(casadi.SX(DQ)), None).initial_state(Shape(3, 3, 2, True))) == {"own"}

    def test_those_of_proposal_and_merit_are_passed_on(self):
        update = updated(Proposal(casadi.SX(DQ), state={"own": 2.0}), Verdict(1, state={"merit": 3.0}))
        assert (update.state["own"], update.state["merit"]) == (2.0, 3.0)
        assert numbers(update.state["term"]) == 0  # not returned, and kept

    def test_after_a_refusal_damping_is_relative_to_the_jacobian_unless_the_proposal_says_how_much(self):
        options = {"state": {"damping": casadi.SX(0)}, "shortened": AdaptiveDamping(10, 0.5)}
        after = updated(Proposal(casadi.SX(DQ)), Verdict(0), **options).state
        assert numbers(after["damping"]) == pytest.approx(SMALLEST_DAMPING * np.sum(J**2))
        after = updated(Proposal(casadi.SX(DQ), smallest_damping=0.25), Verdict(0), **options).state
        assert numbers(after["damping"]) == 0.25

    def test_the_secondary_term_learns_the_null_space_part_before_it_was_shortened(self):
        proposal = Proposal(casadi.SX(DQ), null_space=null_space())
        assert numbers(updated(proposal, term=Term()).state["term"]) == pytest.approx(0.1)
        unlimited = NullSpaceDisplacement(casadi.SX(5 * NULL), 0.5)
        proposal = Proposal(casadi.SX(DQ), null_space=null_space(), null_space_unlimited=unlimited)
        assert numbers(updated(proposal, term=Term()).state["term"]) == 0.5
        assert numbers(updated(proposal, term=Term(), criterion=False).state["term"]) == 0

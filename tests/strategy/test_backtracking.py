"""Backtracking and adaptive damping: the state after sequences of accepted and refused steps."""

from __future__ import annotations

import pytest

from jtik.strategy import AdaptiveDamping, Backtracking, adapted_fraction

from .conftest import numbers, outcome


def states(rule, outcomes, **arguments):
    """The value of the only state after each outcome."""
    (name,) = rule.initial_state()
    state, found = rule.initial_state(), []
    for each in outcomes:
        after = rule.adapt(state, each, **arguments)
        assert list(after) == [name]
        state = {name: numbers(after[name])}
        found.append(state[name])
    return found


class TestBacktracking:
    def test_the_first_step_is_whole(self):
        assert Backtracking().initial_state()["fraction"].tolist() == [1.0]

    def test_half_after_a_refusal_and_twice_after_an_acceptance_up_to_one(self):
        assert states(Backtracking(), map(outcome, [0, 0, 0, 1, 0, 1, 1, 1])) == [
            *[1 / 2, 1 / 4, 1 / 8],
            *[1 / 4, 1 / 8],
            *[1 / 4, 1 / 2, 1],
        ]
        assert states(Backtracking(), [outcome(1)]) == [1]

    def test_a_refusal_that_is_not_its_fault_changes_nothing(self):
        assert states(Backtracking(), [outcome(0), outcome(0, shorten_task=0)]) == [1 / 2, 1 / 2]

    def test_without_backtracking_there_is_no_state_and_the_whole_step(self):
        none = Backtracking(active=False)
        assert none.initial_state() == {}
        assert none.fraction({}) == 1
        assert none.adapt({}, outcome(0)) == {}

    def test_the_state_has_the_given_name(self):
        mine = Backtracking(name="share")
        assert mine.fraction({"share": 0.25}) == 0.25
        assert numbers(mine.adapt({"share": 0.25}, outcome(0))["share"]) == 0.125


@pytest.mark.parametrize(
    ("fraction", "accepted", "shorten", "expected"),
    [(0.3, 1, 0, 0.6), (0.3, 1, 1, 0.6), (0.7, 1, 0, 1.0), (0.3, 0, 1, 0.15), (0.3, 0, 0, 0.3)],
)
def test_adapted_fraction(fraction, accepted, shorten, expected):
    assert numbers(adapted_fraction(fraction, accepted, shorten)) == pytest.approx(expected, abs=0)


class TestAdaptiveDamping:
    rule = AdaptiveDamping(increase=10.0, decrease=0.5)

    def test_it_starts_at_zero(self):
        assert self.rule.initial_state()["damping"].tolist() == [0.0]

    def test_a_refusal_raises_it_to_the_smallest_value_then_by_the_factor(self):
        assert states(self.rule, map(outcome, [0, 0, 0]), smallest=3.0) == [3.0, 30.0, 300.0]

    def test_an_acceptance_lowers_it(self):
        assert states(self.rule, map(outcome, [0, 1, 1, 0]), smallest=3.0) == [3.0, 1.5, 0.75, 7.5]

    def test_an_accepted_step_that_overshoots_raises_it(self):
        """It achieves less than a quarter of what was predicted: the next one would be as long."""
        poor, fair = outcome(1, ratio=0.24), outcome(1, ratio=0.26)
        assert states(self.rule, [outcome(0), poor, fair], smallest=3.0) == [3.0, 30.0, 15.0]

    def test_a_refusal_that_is_not_its_fault_changes_nothing(self):
        assert states(self.rule, [outcome(0), outcome(0, shorten_task=0)], smallest=3.0) == [3.0, 3.0]

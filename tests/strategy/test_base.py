"""The base of strategies: defaults of an update and of a strategy, and former names of what a class defines."""

from __future__ import annotations

import casadi
import pytest

from jtik.strategy import SecondaryTerm, Shape, Strategy, Update


class Still(Strategy):
    """A strategy with what it has to define only."""

    def update(self, model, state):
        return Update(casadi.SX(3, 1))


def test_an_update_needs_dq_only():
    update = Update(casadi.SX(3, 1))
    assert update.accepted == 1
    assert (update.state, update.candidate, update.wanted, update.null_space) == (None, None, None, None)
    assert (update.figures, update.relaxed) == ({}, {})
    assert (update.stationarity_residual, update.progress) == (None, None)


def test_defaults_of_a_strategy():
    still = Still()
    assert still.initial_state(Shape(3, 3, 2, True)) == {}
    assert still.evaluates_candidate(True)
    assert still.evaluates_candidate(False)
    assert not still.uses_qp(True)
    assert not still.supports_clearances()
    assert not still.is_soft
    assert (still.name, still.summary, still.source) == ("", "", "")


def test_a_strategy_without_update_cannot_be_created():
    with pytest.raises(TypeError, match="update"):
        type("Nothing", (Strategy,), {})()


@pytest.mark.parametrize(
    ("base", "old", "new"),
    [
        (Strategy, "judges", "evaluates_candidate"),
        (Strategy, "solves_programs", "uses_qp"),
        (Strategy, "keeps_clear", "supports_clearances"),
        (Strategy, "compromises", "is_soft"),
        (SecondaryTerm, "solves_programs", "uses_qp"),
        (SecondaryTerm, "keeps_clear", "supports_clearances"),
    ],
)
class TestFormerNames:
    def test_a_definition_gets_its_present_name_with_a_warning(self, base, old, new):
        given = object()
        with pytest.warns(DeprecationWarning, match=f"^Mine.{old} is now called {new}; the old name goes"):
            mine = type("Mine", (base,), {old: given})
        assert vars(mine)[new] is given

    def test_a_definition_under_both_names_keeps_the_present_one(self, base, old, new):
        given = object()
        mine = type("Mine", (base,), {old: None, new: given})
        assert vars(mine)[new] is given

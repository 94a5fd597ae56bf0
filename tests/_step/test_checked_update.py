"""The update of a strategy: defaults of what it leaves out, and checks of what it returns."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik._step.checked_update import checked_update, first_state
from jtik.strategy import Shape, Strategy, StrategyError, Update

from ..strategy.conftest import numbers, quadratic_model

SHAPE = Shape(2, 2, 1, False)
DQ = np.array([0.1, -0.2])


class Returning(Strategy):
    """A strategy whose update and first state are given."""

    def __init__(self, update=None, state=None):
        self._update, self._state = update, state or {}

    def initial_state(self, shape):
        return self._state

    def update(self, model, state):
        return self._update(model, state)


def checked(update, state=None):
    model = quadratic_model(np.array([[1.0, 2.0]]), np.array([0.5]))
    return checked_update(Returning(update), model, {name: casadi.SX(v) for name, v in (state or {}).items()})


def refused(update, state=None):
    with pytest.raises(StrategyError) as caught:
        checked(update, state)
    assert caught.value.method == "Returning.update"
    return str(caught.value)


class TestFirstState:
    def test_values_become_arrays(self):
        found = first_state(Returning(state={"a": [1, 2], "b": np.zeros(1)}), SHAPE)
        assert {name: value.tolist() for name, value in found.items()} == {"a": [1.0, 2.0], "b": [0.0]}
        assert all(value.dtype == float for value in found.values())

    def test_it_is_a_copy(self):
        given = np.zeros(2)
        found = first_state(Returning(state={"a": given}), SHAPE)
        given[:] = 7
        assert found["a"].tolist() == [0, 0]

    @pytest.mark.parametrize("value", [1.0, [[1.0]], [np.nan], [np.inf], "one", None], ids=repr)
    def test_anything_but_finite_one_dimensional_arrays_is_refused(self, value):
        with pytest.raises(StrategyError, match=r"returned state 'a' = .*; accepted: names with finite one-dim"):
            first_state(Returning(state={"a": value}), SHAPE)

    def test_a_name_is_a_text(self):
        with pytest.raises(StrategyError, match="returned state 3 ="):
            first_state(Returning(state={3: [1.0]}), SHAPE)


class TestDefaults:
    def test_from_dq_alone(self):
        found = checked(lambda model, state: Update(casadi.SX(DQ)), {"a": [1, 2]})
        assert numbers(found.wanted).tolist() == DQ.tolist()
        assert numbers(found.null_space).tolist() == [0, 0]
        assert numbers(found.candidate.residual) == pytest.approx(0.5 + DQ @ [1, 2])
        assert numbers(found.accepted) == 1
        assert numbers(found.state["a"]).tolist() == [1, 2]
        assert (found.figures, found.relaxed) == ({}, {})

    def test_numbers_become_expressions(self):
        found = checked(lambda model, state: Update([0.1, 0.2], accepted=0, figures={"gain": 0.3}))
        assert numbers(found.dq).tolist() == [0.1, 0.2]
        assert (numbers(found.accepted), numbers(found.figures["gain"])) == (0, 0.3)

    def test_a_candidate_of_the_same_displacement_is_kept(self):
        seen = []

        def update(model, state):
            dq = casadi.SX(DQ)
            seen.append(model.candidate(dq))
            return Update(dq, candidate=seen[0])

        assert checked(update).candidate is seen[0]


class TestMistakes:
    def test_a_candidate_of_another_displacement(self):
        text = refused(lambda model, state: Update(casadi.SX(DQ), candidate=model.candidate(casadi.SX(2 * DQ))))
        assert "evaluated for another displacement" in text
        text = refused(lambda model, state: Update(casadi.SX(DQ), candidate=model.here))
        assert "evaluated for another displacement" in text
        assert "returned candidate int" in refused(lambda model, state: Update(casadi.SX(DQ), candidate=3))

    @pytest.mark.parametrize(
        ("after", "expected"),
        [
            ({}, "those of initial_state, {'a': 2}"),
            ({"a": casadi.SX(3, 1)}, "state 'a' as an expression of shape (2, 1)"),
            ({"a": casadi.SX(2, 1), "b": casadi.SX(1, 1)}, "those of initial_state, {'a': 2}"),
        ],
        ids=["none", "long", "new"],
    )
    def test_a_state_with_other_names_or_sizes(self, after, expected):
        text = refused(lambda model, state: Update(casadi.SX(DQ), state=after), {"a": [1, 2]})
        assert expected in text

    @pytest.mark.parametrize(
        ("field", "value"),
        [("dq", None), ("wanted", [1.0]), ("null_space", np.zeros((2, 2))), ("accepted", [1, 1])],
        ids=lambda value: value if isinstance(value, str) else "",
    )
    def test_a_field_of_the_wrong_shape_is_named(self, field, value):
        fields = {"dq": casadi.SX(DQ)} | {field: value}
        assert f"returned {field} " in refused(lambda model, state: Update(**fields))

    def test_a_figure_and_a_relaxation_are_scalars(self):
        column = casadi.SX(2, 1)
        assert "figure 'gain'" in refused(lambda model, state: Update(casadi.SX(DQ), figures={"gain": column}))
        assert "relaxed['a', 'm']" in refused(lambda m, state: Update(casadi.SX(DQ), relaxed={("a", "m"): column}))

"""The record of a step: names and sizes of its figures, and their values."""

from __future__ import annotations

from itertools import pairwise

import casadi
import numpy as np
import pytest

from jtik._step.checked_update import checked_update
from jtik._step.record import OPTIONAL, figures_of
from jtik._step.relaxation import RelaxationTerms
from jtik.strategy import Strategy, Update

from ..strategy.conftest import numbers, quadratic_model

J = np.array([[1.0, 2.0, 0.5], [0.0, 1.0, -1.0]])
R = np.array([0.5, -0.2])
G = np.array([1.0, 0.0, 2.0])
DQ = np.array([0.1, -0.2, 0.3])
NULL = np.array([0.2, -0.1, -0.1])


class Fixed(Strategy):
    """A strategy with a given displacement."""

    def update(self, model, state):
        return Update(casadi.SX(DQ), null_space=casadi.SX(NULL), figures={"beta": 0.5, "mine": 7.0})


def recorded(terms=None, **options):
    model = quadratic_model(J, R, **options)
    layout, figures = figures_of(model, checked_update(Fixed(), model, {}), casadi.SX(1), terms or RelaxationTerms())
    column = numbers(layout.join(figures))
    return layout, {name: column[where] for name, where in layout.slices.items()}


def test_values_of_the_figures():
    _, found = recorded(gradient=G)
    after = R + J @ DQ
    expected = {
        "V": R @ R / 2,
        "H": 0.0,
        "accepted": 1,
        "null_residual": np.linalg.norm(G - np.linalg.pinv(J) @ J @ G),
        "actual_decrease": R @ R / 2 - after @ after / 2,
        "beta": 0.5,
        "mine": 7.0,
    }
    assert {name: found[name].item() for name in expected} == pytest.approx(expected)
    assert found["dq"] == pytest.approx(DQ)
    assert found["null_space"] == pytest.approx(NULL)
    assert found["null_space_image"] == pytest.approx(J @ NULL)


def test_figures_that_a_strategy_does_not_give_are_nan():
    _, found = recorded()
    assert {name for name in OPTIONAL if np.isnan(found[name].item())} == {"alpha", "V2", "predicted_decrease"}


def test_the_jacobian_is_that_of_the_free_joints_column_by_column():
    _, found = recorded(active=[1])
    assert pytest.approx(J * [1, 0, 1]) == found["J"].reshape(3, 2).T
    assert found["null_space_image"] == pytest.approx(J @ NULL)  # of all joints


def test_without_a_criterion_there_is_no_null_residual():
    assert recorded()[1]["null_residual"].item() == 0


def test_relaxations_are_recorded_too():
    layout, found = recorded(RelaxationTerms((("a", "m"), ("b", "")), {"relaxed": casadi.SX([0.1, 0.2])}))
    assert found["relaxed"].tolist() == [0.1, 0.2]
    assert all(first.stop == second.start for first, second in pairwise(layout.slices.values()))

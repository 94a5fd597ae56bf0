"""Compositions with one full step: it is scaled as a whole by the Q limit and by backtracking, and keeps its state."""

from __future__ import annotations

import math
from dataclasses import dataclass

import casadi
import numpy as np
import pytest

import jtik
from jtik.strategy import Shape, TaskDisplacement
from jtik_formulations import ProjectedGradient
from jtik_formulations.strategies._parts.scaled_step import ScaledComposition

from ...strategy.conftest import numbers, outcome, quadratic_model

J = np.array([[1.0, 2.0, 0.5], [0.0, 1.0, -1.0]])
DQ = np.array([0.6, 0.0, -0.8])
SHAPE = Shape(3, 3, 2, False)


@dataclass(frozen=True, kw_only=True)
class Full(ScaledComposition):
    """A composition whose full step is given, and that counts accepted steps."""

    rows: bool = False
    image: bool = False

    def full_step(self, model, state):
        if self.rows:
            return TaskDisplacement.along(model.row_space_free.least_squares(casadi.SX([0.3, -0.4])), 0.5)
        return TaskDisplacement(casadi.SX(DQ), casadi.SX([1.0, 2.0]) if self.image else None, alpha=0.5)

    def own_state(self, shape):
        return {"mine": np.zeros(1)}

    def adapt_own_state(self, model, state, outcome):
        return {"mine": state["mine"] + outcome.accepted}


def proposed(fraction=1.0, **options):
    model = quadratic_model(J, np.ones(2))
    return Full(**options).task_step().propose(model, {"fraction": casadi.SX(fraction), "mine": casadi.SX(0)})


class TestScale:
    """The full step is 1 rad long."""

    @pytest.mark.parametrize(
        ("limit", "fraction", "length"), [(math.inf, 1, 1), (2, 1, 1), (0.5, 1, 0.5), (math.inf, 0.25, 0.25)]
    )
    def test_limit_and_fraction_scale_the_whole_step(self, limit, fraction, length):
        assert numbers(proposed(fraction, q_limit=limit).dq) == pytest.approx(length * DQ)

    def test_without_backtracking_there_is_no_fraction(self):
        assert numbers(proposed(0.25, q_limit=math.inf, backtracking=False).dq) == pytest.approx(DQ)

    def test_a_known_image_is_scaled_with_it(self):
        assert numbers(proposed(q_limit=0.5, image=True).image) == pytest.approx([0.5, 1.0])
        assert proposed(q_limit=0.5).image is None

    def test_coordinates_of_the_row_space_are_scaled_with_it(self):
        found, full = proposed(q_limit=0.1, rows=True), np.linalg.pinv(J) @ [0.3, -0.4]
        scale = 0.1 / np.linalg.norm(full)
        assert scale < 1
        assert numbers(found.dq) == pytest.approx(scale * full)
        assert numbers(found.image) == pytest.approx(scale * np.array([0.3, -0.4]))
        assert numbers(found.length) == pytest.approx(0.1)
        assert found.alpha == 0.5


class TestState:
    def test_it_is_that_of_the_full_step_and_the_fraction(self):
        assert set(Full().task_step().initial_state(SHAPE)) == {"mine", "fraction"}
        assert set(Full(backtracking=False).task_step().initial_state(SHAPE)) == {"mine"}

    @pytest.mark.parametrize(("accepted", "expected"), [(1, (1, 1.0)), (0, (0, 0.25))])
    def test_both_learn_the_outcome(self, accepted, expected):
        state = {"fraction": casadi.SX(0.5), "mine": casadi.SX(0)}
        found = Full().task_step().adapt(quadratic_model(J, np.ones(2)), state, None, outcome(accepted))
        assert (numbers(found["mine"]), numbers(found["fraction"])) == expected


def test_acceptance_follows_backtracking_and_the_secondary_term():
    assert Full().acceptance() == "merit"
    assert Full(backtracking=False).acceptance() == "always"
    assert Full(secondary=ProjectedGradient(rule="paper")).acceptance() == "task"
    assert Full(secondary=ProjectedGradient(rule="sqrt")).acceptance() == "merit"


@pytest.mark.parametrize("limit", [0.0, -1.0, math.nan])
def test_the_limit_is_checked(limit):
    with pytest.raises(jtik.ArgumentError, match="q_limit"):
        Full(q_limit=limit)

"""The gain of Barzilai and Borwein on quadratic criteria: the inverse curvature along the last step, and its cap."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.strategy import NullSpaceDisplacement, Outcome, Shape
from jtik_formulations.strategies._parts.barzilai_borwein import (
    NO_STEP,
    NULL_STEP,
    STEP,
    UNBOUNDED,
    BarzilaiBorweinGain,
)

from ...strategy.conftest import numbers, quadratic_model

GAIN = BarzilaiBorweinGain(step_limit=0.3, beta_max=2.0)
J = np.array([[1.0, 0.0, 0.0]])
HESSIAN = np.diag([1.0, 4.0, 10.0])


def model_at(q, hessian=HESSIAN):
    """H = q' hessian q / 2; the task is the first coordinate."""
    return quadratic_model(J, np.zeros(1), gradient=hessian @ q, hessian=hessian, q=q)


def state(before=None, seen=NO_STEP, *, beta=0.7, cap=0.3, hessian=HESSIAN):
    """The state after a step from the configuration ``before``."""
    first = {name: casadi.SX(value) for name, value in GAIN.initial_state(Shape(3, 3, 1, True)).items()}
    first |= {"last_kind": casadi.SX(seen), "beta": casadi.SX(beta), "null_cap": casadi.SX(cap)}
    if before is not None:
        gradient = hessian @ before
        first |= {
            "last_q": casadi.SX(before),
            "last_H_gradient": casadi.SX(gradient),
            "last_null_gradient": casadi.SX(gradient * [0, 1, 1]),
        }
    return first


def gain(q, *arguments, hessian=HESSIAN, **options):
    model = model_at(np.array(q), hessian)
    return numbers(GAIN.gain(model, state(*arguments, hessian=hessian, **options), model.null_gradient_free))


class TestGain:
    def test_the_first_one_is_the_largest_that_is_given(self):
        first = {name: casadi.SX(value) for name, value in GAIN.initial_state(Shape(3, 3, 1, True)).items()}
        model = model_at(np.ones(3))
        assert numbers(GAIN.gain(model, first, model.null_gradient_free)) == 2.0

    @pytest.mark.parametrize("seen", [STEP, NULL_STEP])
    @pytest.mark.parametrize(
        ("along", "expected"), [([0, 1.0, 0], 1 / 4), ([0, 0, 1.0], 1 / 10), ([0, 1.0, 1.0], 1 / 7)]
    )
    def test_it_is_the_inverse_curvature_along_the_last_step(self, seen, along, expected):
        before = np.array([0.2, 0.5, -0.4])
        assert gain(before + 0.1 * np.array(along), before, seen) == pytest.approx(expected)

    def test_after_a_task_step_the_gradient_of_all_joints_counts(self):
        """Along the first joint the null-space gradient does not change, the whole gradient by 1 per unit."""
        before = np.array([0.2, 0.5, -0.4])
        moved = before + np.array([0.1, 0, 0])
        assert gain(moved, before, STEP) == pytest.approx(1.0)
        assert gain(moved, before, NULL_STEP) == pytest.approx(UNBOUNDED)

    def test_where_H_is_not_convex_a_task_step_keeps_it_and_a_null_space_step_has_no_bound(self):
        before, concave = np.array([0.2, 0.5, -0.4]), np.diag([1.0, -4.0, 10.0])
        moved = before + np.array([0, 0.1, 0])
        assert gain(moved, before, STEP, hessian=concave) == 0.7
        assert gain(moved, before, NULL_STEP, hessian=concave) == pytest.approx(UNBOUNDED)

    @pytest.mark.parametrize("seen", [STEP, NULL_STEP])
    def test_without_a_motion_it_stays(self, seen):
        before = np.array([0.2, 0.5, -0.4])
        assert gain(before, before, seen) == 0.7

    @pytest.mark.parametrize("seen", [STEP, NULL_STEP])
    def test_a_live_parameter_that_changes_at_rest_leaves_it(self, seen):
        """Displacement of the size of rounding, gradient of another criterion: their ratio is no curvature."""
        before = np.array([0.2, 0.5, -0.4])
        remembered = state(before, seen)
        model = model_at(before + np.array([0, 1e-16, 1e-16]), 1e3 * HESSIAN)
        assert numbers(GAIN.gain(model, remembered, model.null_gradient_free)) == 0.7


class TestAdapt:
    def after(self, accepted, *, shorten=1, length=0.2, beta=0.5, **options):
        null_space = NullSpaceDisplacement(casadi.SX(3, 1), length, 0.0, beta)
        outcome = Outcome(accepted, 1.0, null_space, 0, shorten)
        model = model_at(np.array([0.1, 0.2, 0.3]))
        found = GAIN.adapt(model, state(**options), model.null_gradient_free, null_space, outcome)
        return {name: numbers(value) for name, value in found.items()}

    def test_the_cap_doubles_up_to_the_step_limit(self):
        assert self.after(1, cap=0.1)["null_cap"] == pytest.approx(0.2)
        assert self.after(1, cap=0.2)["null_cap"] == pytest.approx(0.3)

    def test_a_refused_step_is_divided_by_four(self):
        assert self.after(0, cap=0.3, length=0.2)["null_cap"] == pytest.approx(0.05)
        assert self.after(0, cap=0.1, length=0.2)["null_cap"] == pytest.approx(0.025)
        assert self.after(0, cap=0.3, shorten=0)["null_cap"] == pytest.approx(0.3)

    def test_a_positive_gain_is_remembered(self):
        assert self.after(1)["beta"] == 0.5
        assert self.after(1, beta=0.0)["beta"] == 0.7

    @pytest.mark.parametrize(("accepted", "shorten", "seen"), [(1, 1, NULL_STEP), (1, 0, STEP), (0, 1, STEP)])
    def test_the_configuration_and_its_gradients_are_remembered(self, accepted, shorten, seen):
        found = self.after(accepted, shorten=shorten)
        assert found["last_kind"] == seen
        assert found["last_q"].tolist() == [0.1, 0.2, 0.3]
        assert found["last_H_gradient"] == pytest.approx([0.1, 0.8, 3.0])
        assert found["last_null_gradient"] == pytest.approx([0, 0.8, 3.0])

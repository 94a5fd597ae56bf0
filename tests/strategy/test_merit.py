"""The exact penalty H + mu |r|: its weight, and the test near the target, on linear tasks with quadratic criteria."""

from __future__ import annotations

import itertools
from dataclasses import replace

import casadi
import numpy as np
import pytest

from jtik.strategy.merit import (
    LARGEST_INCREASE,
    MEMORY,
    next_allowance,
    penalty_falls,
    penalty_weight,
    residual_reduction,
)

from .conftest import numbers, quadratic_model


def problem(rng):
    """J (2, 4), r (2,), gradient (4,) of numbers of order one."""
    return rng.normal(size=(2, 4)), rng.normal(size=2), rng.normal(size=4)


@pytest.mark.parametrize(("r", "predicted", "expected"), [([3, 4], 10.5, 3), ([3, 4], 12.5, 5), ([3, 4], 99, 5)])
def test_the_reach_is_the_decrease_of_the_norm(r, predicted, expected):
    """V = 12.5 at |r| = 5; V = 2 is left of it at |r| = 2; it is never negative."""
    model = quadratic_model(np.eye(2), np.array(r, dtype=float))
    assert numbers(residual_reduction(model, predicted)) == pytest.approx(expected)


class TestPenaltyWeight:
    def weight(self, model, before=0.0, decrease=0.0, reach=1.0, lengths=(0.0, 1.0), H_after=0.0):
        return numbers(penalty_weight(model, before, decrease, reach, lengths, casadi.SX(H_after)))

    def test_it_exceeds_the_multipliers_of_the_task(self, rng):
        """Above |lambda| the penalty is exact: its minimum is that of H on the task's solutions."""
        for _ in range(10):
            J, r, g = problem(rng)
            multipliers = np.linalg.pinv(J).T @ g
            assert self.weight(quadratic_model(J, r, gradient=g)) > 1.5 * np.linalg.norm(multipliers)

    def test_it_lets_the_task_displacement_lower_the_penalty(self, rng):
        """Half of mu times the reach covers what the task displacement costs H to first order."""
        for _ in range(10):
            J, r, g = problem(rng)
            model, dq = quadratic_model(J, r, gradient=g), -np.linalg.pinv(J) @ r
            decrease, reach = -g @ dq, np.linalg.norm(r)
            mu = self.weight(model, 0.0, decrease, reach, (dq @ dq, dq @ dq), g @ dq + dq @ dq / 2)
            assert mu * reach / 2 + decrease > 0

    def test_it_falls_to_half_at_most(self, rng):
        model = quadratic_model(*problem(rng)[:2], gradient=np.zeros(4))
        assert self.weight(model, before=1e6) == 5e5

    def test_it_rises_by_a_bounded_factor(self, rng):
        """A step that promises next to no reach would ask for any weight."""
        model = quadratic_model(*problem(rng)[:2], gradient=np.ones(4))
        ordinary = self.weight(model)
        assert self.weight(model, decrease=-1.0, reach=1e-30) == pytest.approx(LARGEST_INCREASE * ordinary)


class TestPenaltyFalls:
    def falls(self, model, dq, mu, allowance=0):
        """Whether dq is accepted; what it promises are the exact decreases to first order."""
        J, r, g = (np.array(casadi.DM(part)) for part in (model.J, model.here.residual, model.gradient))
        reach = np.linalg.norm(r) - np.linalg.norm(r[:, 0] + J @ dq)
        return bool(numbers(penalty_falls(model, mu, model.candidate(casadi.SX(dq)), -g[:, 0] @ dq, reach, allowance)))

    def test_a_newton_step_of_the_task_is_accepted(self, rng):
        J, r, _ = problem(rng)
        model = quadratic_model(J, r, gradient=np.zeros(4), hessian=np.zeros((4, 4)))
        assert self.falls(model, -np.linalg.pinv(J) @ r, mu=1.0)

    def test_a_step_away_from_the_target_is_refused(self, rng):
        J, r, _ = problem(rng)
        model = quadratic_model(J, r, gradient=np.zeros(4), hessian=np.zeros((4, 4)), neighbourhood=100.0)
        assert not self.falls(model, np.linalg.pinv(J) @ r, mu=1.0)

    def test_a_step_that_leaves_the_neighbourhood_is_refused(self):
        """It lowers H by more than the error costs."""
        J, r, g = np.array([[1.0, 0.0]]), np.array([0.1]), np.array([-10.0, 0.0])
        dq = np.array([0.5, 0.0])
        for neighbourhood, accepted in ((1.0, True), (0.5, False)):
            model = quadratic_model(J, r, gradient=g, hessian=np.zeros((2, 2)), neighbourhood=neighbourhood)
            assert self.falls(model, dq, mu=1.0) is accepted

    @pytest.mark.parametrize(("curvature", "accepted"), [(1.0, True), (4.0, False)])
    def test_a_null_space_step_is_accepted_where_H_falls(self, curvature, accepted):
        """Along -gradient by the length 1, H changes by -1 + curvature / 2."""
        J, g = np.array([[1.0, 0.0]]), np.array([0.0, 1.0])
        model = quadratic_model(J, np.zeros(1), gradient=g, hessian=curvature * np.eye(2))
        assert self.falls(model, -g, mu=1.0) is accepted

    def test_at_the_optimum_rounding_is_accepted(self):
        J, g = np.array([[1.0, 0.0]]), np.zeros(2)
        model = quadratic_model(J, np.zeros(1), gradient=g)
        assert self.falls(model, np.zeros(2), mu=1.0)

    @pytest.mark.parametrize(("allowance", "accepted"), [(0.99, False), (1.01, True)])
    def test_it_may_rise_by_the_allowance(self, allowance, accepted):
        """Along -gradient by the length 1, H rises by -1 + 4 / 2."""
        J, g = np.array([[1.0, 0.0]]), np.array([0.0, 1.0])
        model = quadratic_model(J, np.zeros(1), gradient=g, hessian=4.0 * np.eye(2))
        assert self.falls(model, -g, mu=1.0, allowance=allowance) is accepted


class TestAllowance:
    def after(self, allowance, change, near=1):
        """The allowance after a step that changes H by ``change``."""
        J, r = np.array([[1.0, 0.0]]), np.array([0.1])
        model = quadratic_model(J, r, gradient=np.array([0.0, change]), hessian=np.zeros((2, 2)))
        model = replace(model, near_target=casadi.SX(near))
        return numbers(next_allowance(model, casadi.SX(allowance), model.candidate(casadi.SX([0.0, 1.0])), 2.0))

    def test_H_that_falls_while_the_error_rises_by_more_leaves_nothing(self):
        """Otherwise two steps, one for H and one for the task, could follow each other for ever."""
        J = np.array([[1.0, 0.0]])
        model = quadratic_model(J, np.array([0.1]), gradient=np.array([-0.3, 0.0]), hessian=np.zeros((2, 2)))
        model = replace(model, near_target=casadi.SX(1))
        assert numbers(next_allowance(model, casadi.SX(0.0), model.candidate(casadi.SX([0.1, 0.0])), 2.0)) == 0

    def test_with_H_it_is_the_weighted_average_of_H(self, rng):
        values = np.sort(rng.random(8))[::-1]
        allowance, average = 0.0, values[0]
        for before, H in itertools.pairwise(values):
            allowance = self.after(allowance, H - before)
            average = MEMORY * average + (1 - MEMORY) * H
            assert H + allowance == pytest.approx(average)

    def test_it_is_never_negative(self):
        assert self.after(0.2, 0.3) == 0
        assert self.after(0.2, 0.1) == pytest.approx(MEMORY * 0.1)

    def test_there_is_none_far_from_the_target(self):
        assert self.after(0.2, -0.3, near=0) == 0

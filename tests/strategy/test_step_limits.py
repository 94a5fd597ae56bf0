"""Limits of a step: a box for each rotation, or one factor for the whole displacement."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik.strategy import limited_box, within_step_limit

from .conftest import numbers, quadratic_model


def crane():
    """Two revolute joints around a prismatic one."""
    kinds = ["revolute", "prismatic", "revolute"]
    return jtik.Robot.from_dh([{"a": 0.5, "alpha": 0.3, "d": 0.1, "joint": kind} for kind in kinds])


def model(**options):
    return quadratic_model(np.ones((2, 3)), np.ones(2), robot=crane(), **options)


class TestBox:
    def test_rotations_are_limited_and_translations_are_not(self):
        low, high = map(numbers, limited_box(model(), 0.2))
        assert low.tolist() == [-0.2, -math.inf, -0.2]
        assert high.tolist() == [0.2, math.inf, 0.2]

    def test_the_closer_of_joint_limit_and_step_limit_counts(self):
        limits = np.array([-0.1, -5.0, -3.0]), np.array([1.0, 4.0, 0.15])
        low, high = map(numbers, limited_box(model(limits=limits), 0.2))
        assert low.tolist() == [-0.1, -5.0, -0.2]
        assert high.tolist() == [0.2, 4.0, 0.15]

    def test_an_infinite_limit_leaves_the_joint_limits(self):
        limits = np.array([-0.1, -5.0, -3.0]), np.array([1.0, 4.0, 0.15])
        low, high = map(numbers, limited_box(model(limits=limits), math.inf))
        assert (low.tolist(), high.tolist()) == (limits[0].tolist(), limits[1].tolist())

    def test_it_contains_zero_where_a_joint_is_outside_its_limits(self):
        limits = np.array([0.3, -1.0, -1.0]), np.array([1.0, -0.4, 1.0])
        low, high = map(numbers, limited_box(model(limits=limits), 0.2))
        assert (low <= 0).all()
        assert (high >= 0).all()


class TestFactor:
    def test_the_norm_of_the_rotations_is_brought_to_the_limit(self, rng):
        for _ in range(20):
            dq, limit = rng.uniform(-2, 2, 3), rng.uniform(0.1, 2)
            factor = numbers(within_step_limit(model(), dq, limit))
            assert np.linalg.norm(factor * dq[[0, 2]]) == pytest.approx(min(limit, np.linalg.norm(dq[[0, 2]])))
            assert factor <= 1

    def test_translations_do_not_count(self):
        assert numbers(within_step_limit(model(), np.array([0.0, 100.0, 0.0]), 0.1)) == 1

    def test_an_infinite_limit_is_the_factor_one(self):
        assert within_step_limit(model(), np.full(3, 1e9), math.inf) == 1

    def test_a_known_squared_length_serves_an_arm_of_rotations(self):
        arm = quadratic_model(np.ones((2, 3)), np.ones(2))
        assert numbers(within_step_limit(arm, np.array([3.0, 0, 4.0]), 1.0, 25.0)) == pytest.approx(0.2)

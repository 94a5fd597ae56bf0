"""The transpose step: its gain minimises the linear model of V, and its rotations stay within the limit."""

from __future__ import annotations

import casadi
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import jtik
from jtik_formulations.strategies._parts.transpose_step import cauchy_step, optimal_gain, printed_step

from ...strategy.conftest import numbers, quadratic_model

KINDS = ["prismatic", "revolute", "prismatic", "revolute"]
ROTATIONAL = np.array([kind == "revolute" for kind in KINDS])
CRANE = jtik.Robot.from_dh([{"a": 0.4, "alpha": 0.3, "joint": kind} for kind in KINDS])


def problem(rng):
    return rng.normal(size=(2, 4)), rng.normal(size=2)


def values(step):
    return {name: numbers(getattr(step, name)) for name in ("direction", "image", "gain", "alpha", "s")}


def V_along(J, r, found):
    """V of the linear model as a function of the gain."""
    return lambda gain: np.sum((r - gain * J @ found["direction"]) ** 2) / 2


def test_the_optimal_gain_is_zero_where_nothing_moves():
    assert numbers(optimal_gain(casadi.SX(0.0), casadi.SX(2, 1))) == 0


class TestRevolute:
    def test_without_a_limit_it_minimises_V_along_the_gradient(self, rng):
        for _ in range(10):
            J, r = problem(rng)
            found = values(cauchy_step(quadratic_model(J, r), 1e9))
            assert found["direction"] == pytest.approx(J.T @ r)
            assert found["image"] == pytest.approx(J @ J.T @ r)
            assert (found["s"], found["gain"]) == (1, found["alpha"])
            assert found["gain"] == pytest.approx(minimize_scalar(V_along(J, r, found)).x)

    def test_the_limit_is_applied_after_alpha(self, rng):
        J, r = problem(rng)
        free, found = (values(cauchy_step(quadratic_model(J, r), limit)) for limit in (1e9, 0.05))
        assert found["alpha"] == pytest.approx(free["alpha"])
        assert np.linalg.norm(found["gain"] * found["direction"]) == pytest.approx(0.05)

    def test_as_printed_the_limit_changes_nothing(self, rng):
        J, r = problem(rng)
        free, found = (values(printed_step(quadratic_model(J, r), limit)) for limit in (1e9, 0.05))
        assert found["gain"] * found["direction"] == pytest.approx(free["gain"] * free["direction"])

    def test_as_printed_S_is_one_over_Q_beyond_the_limit(self, rng):
        J, r = problem(rng)
        free, found = (values(printed_step(quadratic_model(J, r), limit)) for limit in (1e9, 1e-3))
        assert free["s"] == 1
        assert found["s"] == pytest.approx(1 / np.linalg.norm(free["gain"] * free["direction"]))


class TestMixed:
    def test_rotations_stay_within_the_limit_and_V_falls(self, rng):
        limited = 0
        for _ in range(30):
            J, r = problem(rng)
            found = values(cauchy_step(quadratic_model(J, r, robot=CRANE), 0.2))
            dq = found["gain"] * found["direction"]
            limited += found["s"] < 1
            assert np.linalg.norm(dq[ROTATIONAL]) <= 0.2 * (1 + 1e-12)
            assert np.sum((r - J @ dq) ** 2) < np.sum(r**2)
            assert found["direction"] == pytest.approx(np.where(ROTATIONAL, found["s"], 1) * (J.T @ r))
            assert found["image"] == pytest.approx(J @ found["direction"])
        assert limited > 5

    def test_as_printed_Q_is_of_all_joints(self, rng):
        J, r = problem(rng)
        free, found = (values(printed_step(quadratic_model(J, r, robot=CRANE), limit)) for limit in (1e9, 1e-3))
        assert found["s"] == pytest.approx(1 / np.linalg.norm(free["gain"] * free["direction"]))
        assert found["direction"] == pytest.approx(np.where(ROTATIONAL, found["s"], 1) * (J.T @ r))
        assert found["gain"] == pytest.approx(minimize_scalar(V_along(J, r, found)).x)

    def test_where_nothing_is_limited_it_minimises_V_along_the_gradient(self, rng):
        J, r = problem(rng)
        found = values(cauchy_step(quadratic_model(J, r, robot=CRANE), 1e9))
        assert found["gain"] == pytest.approx(minimize_scalar(V_along(J, r, found)).x)

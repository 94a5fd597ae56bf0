"""Timing: limits hold at all times, judged by dense differences of positions, and simple paths take their time."""

from __future__ import annotations

import importlib.util
import sys
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jtik.errors import ArgumentError
from jtik.planner.commit.timing import SPACING, smoothed, timed_path

METHODS = ("toppra", "trapezoid") if importlib.util.find_spec("toppra") else ("trapezoid",)

DIFFERENCES = 1e-5
"""Rounding of second differences of positions of order one over a step of a ten-thousandth of the duration."""


def noisy_path(seed, k=80, n=4, noise=1e-3, still=True):
    """Smooth joints with noise, with a pause and with a way back on itself."""
    rng = np.random.default_rng(seed)
    time = np.linspace(0, 6, k)
    q = np.stack([a * np.sin(w * time + p) for a, w, p in rng.uniform(0.2, 1.5, (n, 3))], axis=1)
    q += noise * rng.normal(size=q.shape)
    if still:
        q[k // 3 : k // 2] = q[k // 3]
    return np.concatenate([q, q[::-3]])


@pytest.mark.thinned
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("noise", [0.0, 1e-2])
@pytest.mark.parametrize("seed", range(4))
def test_limits_hold_between_all_times(method, noise, seed):
    waypoints = noisy_path(seed, noise=noise)
    rng = np.random.default_rng(seed)
    velocity, acceleration = rng.uniform(0.5, 3, 4), rng.uniform(1, 8, 4)
    path = timed_path(waypoints, velocity, acceleration, method=method)
    assert path.method == method
    times = np.linspace(0, path.duration, 20_001)
    q, v, a = path.at(times)
    step = times[1]
    assert (np.abs(np.diff(q, axis=0)) / step <= velocity * (1 + DIFFERENCES)).all()
    assert (np.abs(np.diff(q, 2, axis=0)) / step**2 <= acceleration * (1 + DIFFERENCES)).all()
    assert (np.abs(v) <= velocity * (1 + 1e-9)).all()
    assert (np.abs(a) <= acceleration * (1 + 1e-9)).all()
    assert np.allclose(v[[0, -1]], 0, atol=1e-7)
    assert np.allclose(np.diff(q, axis=0) / step, (v[1:] + v[:-1]) / 2, atol=2 * step * acceleration.max())
    tight = path.used(velocity, acceleration)
    assert tight == pytest.approx(1.0, abs=1e-6)


@pytest.mark.thinned
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", range(3))
def test_the_path_goes_through_the_samples_and_no_joint_leaves_their_range(method, seed):
    waypoints = noisy_path(seed)
    path = timed_path(waypoints, np.full(4, 2.0), np.full(4, 5.0), method=method)
    q, _, _ = path.at(np.linspace(0, path.duration, 40_001))
    assert np.array_equal(q[0], waypoints[0])
    assert np.allclose(q[-1], waypoints[-1], atol=1e-12)
    for each in waypoints:
        assert np.abs(q - each).max(axis=1).min() <= 2 * SPACING + 1e-3
    assert (q <= waypoints.max(axis=0) + 1e-12).all()
    assert (q >= waypoints.min(axis=0) - 1e-12).all()


def test_a_straight_path_takes_the_time_of_a_trapezoid():
    """One joint, 2 rad at 1 rad/s and 2 rad/s^2: half a second up, half a second down, 1.5 s between."""
    ends, limits = np.array([[0.0], [2.0]]), (np.array([1.0]), np.array([2.0]))
    assert 2.5 <= timed_path(ends, *limits, method="trapezoid").duration <= 3.01
    if "toppra" in METHODS:
        assert timed_path(ends, *limits, method="toppra").duration == pytest.approx(2.5, rel=0.01)
        short = timed_path(ends / 16, np.array([10.0]), np.array([2.0]), method="toppra")
        assert short.duration == pytest.approx(2 * np.sqrt(0.125 / 2), rel=0.01)


def test_the_faster_of_both_is_taken_and_the_trapezoid_without_toppra(monkeypatch):
    waypoints, limits = noisy_path(0), (np.full(4, 2.0), np.full(4, 5.0))
    both = {method: timed_path(waypoints, *limits, method=method).duration for method in METHODS}
    assert timed_path(waypoints, *limits).duration == min(both.values())
    monkeypatch.setitem(sys.modules, "toppra", None)
    assert timed_path(waypoints, *limits).method == "trapezoid"
    with pytest.raises(ArgumentError, match="not installed"):
        timed_path(waypoints, *limits, method="toppra")
    with pytest.raises(ArgumentError, match="method"):
        timed_path(waypoints, *limits, method="fast")


def test_an_infinite_speed_and_a_joint_that_stands_still():
    waypoints = noisy_path(1)
    waypoints[:, 2] = 0.7
    for method in METHODS:
        path = timed_path(waypoints, np.array([1.0, np.inf, 1.0, np.inf]), np.full(4, 3.0), method=method)
        q, _, _ = path.at(np.linspace(0, path.duration, 1001))
        assert (q[:, 2] == 0.7).all()
        assert path.used(np.array([1.0, np.inf, 1.0, np.inf]), np.full(4, 3.0)) == pytest.approx(1.0, abs=1e-6)


def test_an_arm_that_does_not_move_is_refused():
    for waypoints in (np.zeros((1, 3)), np.zeros((9, 3))):
        with pytest.raises(ArgumentError, match="no joint moves"):
            timed_path(waypoints, np.ones(3), np.ones(3))


@pytest.mark.parametrize("tolerance", [1e-4, 0.02, 0.3])
def test_smoothing_keeps_the_ends_the_range_and_its_tolerance(tolerance):
    waypoints = noisy_path(3, noise=0.01)
    found = smoothed(waypoints, tolerance)
    assert np.abs(found - waypoints).max() <= tolerance * (1 + 1e-12)
    assert (found[[0, -1]] == waypoints[[0, -1]]).all()
    assert (found <= waypoints.max(axis=0) + 1e-12).all()
    assert (found >= waypoints.min(axis=0) - 1e-12).all()
    limits = np.full(4, 2.0), np.full(4, 5.0)
    if tolerance > 0.01:
        assert timed_path(found, *limits).duration < 0.7 * timed_path(waypoints, *limits).duration


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(2, 12), st.floats(1e-3, 3.0), st.sampled_from(METHODS))
def test_jagged_paths_obey_their_limits(seed, k, size, method):
    rng = np.random.default_rng(seed)
    waypoints = size * rng.normal(size=(k, 2))
    velocity, acceleration = rng.uniform(0.1, 5, 2), rng.uniform(0.1, 20, 2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            path = timed_path(waypoints, velocity, acceleration, method=method)
        except ArgumentError:
            assert method == "toppra"
            return
    times = np.linspace(0, path.duration, 5001)
    q, _, _ = path.at(times)
    assert (np.abs(np.diff(q, axis=0)) / times[1] <= velocity * (1 + DIFFERENCES)).all()
    assert (np.abs(np.diff(q, 2, axis=0)) / times[1] ** 2 <= acceleration * (1 + DIFFERENCES)).all()
    assert np.allclose(q[-1], waypoints[-1], atol=1e-9)

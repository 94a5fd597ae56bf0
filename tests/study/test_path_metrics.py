"""Path metrics of traces and paths with known values."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik.study import path_metrics

ARM = jtik.Robot.planar(2)


def trace(V, *, accepted=None, error=None, q=None, **figures):
    """A trace with these values of V; all steps are accepted by default."""
    steps = len(V)
    figures = {"V": V, "accepted": np.ones(steps) if accepted is None else accepted, **figures}
    return jtik.Trace(
        q=np.arange(2.0 * (steps + 1)).reshape(-1, 2) if q is None else np.array(q, dtype=float),
        error=np.ones(steps + 1) if error is None else np.array(error, dtype=float),
        figures={name: np.array(figure, dtype=float) for name, figure in figures.items()},
    )


class TestMonotone:
    def test_a_falling_V_is_monotone(self):
        assert path_metrics.monotone(trace([3, 2, 1]), 0.5, 1e-6) == 1

    def test_a_rising_V_is_not_monotone(self):
        assert path_metrics.monotone(trace([3, 1, 2]), 0.5, 1e-6) == 0

    def test_the_last_step_counts(self):
        assert path_metrics.monotone(trace([3, 2, 1]), 1.5, 1e-6) == 0

    def test_monotone_is_nan_without_a_step(self):
        assert math.isnan(path_metrics.monotone(trace([]), 0.5, 1e-6))

    def test_rejected_steps_are_ignored(self):
        assert path_metrics.monotone(trace([3, 1, 2], accepted=[1, 0, 1]), 0.5, 1e-6) == 1

    def test_rises_on_target_are_ignored(self):
        error = [1, 1e-7, 5e-7, 2e-7]
        assert path_metrics.monotone(trace([3, 1e-14, 1e-13], error=error), 2e-14, 1e-6) == 1
        assert path_metrics.monotone(trace([3, 1e-14, 1e-13], error=error), 2e-14, 1e-7) == 0

    def test_rounding_is_ignored(self):
        assert path_metrics.monotone(trace([1, 1 + 1e-15]), 0.5, 1e-6) == 1
        assert path_metrics.monotone(trace([1, 1 + 1e-9]), 0.5, 1e-6) == 0

    def test_a_restart_is_ignored(self):
        assert path_metrics.monotone(trace([3, 2, 9, 4], attempt=[0, 0, 1, 1]), 0.1, 1e-6) == 1
        assert path_metrics.monotone(trace([3, 4, 9, 4], attempt=[0, 0, 1, 1]), 0.1, 1e-6) == 1
        assert path_metrics.monotone(trace([3, 2, 4, 9], attempt=[0, 0, 1, 1]), 0.1, 1e-6) == 0

    def test_nan_is_a_rise(self):
        assert path_metrics.monotone(trace([3, math.nan, 1]), 0.5, 1e-6) == 0

    def test_a_trace_without_V_uses_the_error(self):
        bare = jtik.Trace(q=np.arange(6.0).reshape(3, 2), error=np.array([1.0, 2.0, 0.5]), figures={})
        assert path_metrics.monotone(bare, 0.125, 1e-6) == 0


class TestLeakage:
    def test_leakage_is_the_largest_of_accepted_steps(self):
        leaks = {"leakage": [1e-3, 5e-2, math.nan], "accepted": [1, 0, 1]}
        assert path_metrics.leakage(trace([3, 2, 1], **leaks)) == 1e-3

    def test_without_a_null_space_step_there_is_none(self):
        assert math.isnan(path_metrics.leakage(trace([3, 2], leakage=[math.nan, math.nan])))
        assert math.isnan(path_metrics.leakage(trace([3, 2])))


class TestPaths:
    def test_path_length_is_the_length_in_joint_space(self):
        assert path_metrics.path_length(ARM, np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0]])) == 6
        assert path_metrics.path_length(ARM, np.array([[1.0, 2.0]])) == 0

    def test_iterates_are_those_of_the_last_attempt(self):
        attempts = trace([1, 1, 1], q=[[9, 9], [8, 8], [0, 0], [3, 4]], attempt=[0, 0, 1])
        np.testing.assert_array_equal(path_metrics.iterates(attempts), [[0, 0], [3, 4]])

    def test_smoothness_is_the_mean_square_of_the_acceleration(self):
        dt, times = 0.1, 0.1 * np.arange(6)
        parabola = np.column_stack([1.5 * times**2, -2.0 * times**2])  # accelerations 3 and -4
        assert path_metrics.smoothness(ARM, parabola, dt) == pytest.approx(5.0)
        assert path_metrics.smoothness(ARM, np.column_stack([times, 3 * times]), dt) == pytest.approx(0, abs=1e-11)

    def test_smoothness_needs_three_configurations_and_a_time_step(self):
        assert math.isnan(path_metrics.smoothness(ARM, np.zeros((2, 2)), 0.1))
        assert math.isnan(path_metrics.smoothness(ARM, np.zeros((3, 2)), None))

    def test_drift_is_the_distance_from_first_to_last_configuration(self):
        assert path_metrics.drift(ARM, np.array([[0.0, 1.0], [7.0, 7.0], [3.0, 5.0]])) == 5

    def test_quaternions_are_measured_by_their_rotation_angle(self):
        ball = jtik.Robot([jtik.Joint("ball", jtik.JointType.BALL, "base", "hand")])
        turned = np.array([[1, 0, 0, 0], [math.cos(0.2), math.sin(0.2), 0, 0], [-1, 0, 0, 0]], dtype=float)
        assert path_metrics.path_length(ball, turned) == pytest.approx(0.8)
        assert path_metrics.drift(ball, turned) == pytest.approx(0, abs=1e-12)


def test_traces_number_the_attempts_of_a_solve_with_restarts():
    arm = jtik.Robot.builtin("panda")
    ik = jtik.InverseKinematics(arm, jtik.FrameTask("tip", "pose"), strategy="newton")
    rng = np.random.default_rng(11)  # not the restarts' own seed
    found = 0
    for _ in range(10):
        target, q0 = arm.pose(arm.random_configuration(rng)), ik.robot.random_configuration(rng)
        solution = ik.solve(target, q0=q0, restarts=20, trace=True)
        attempts = solution.trace.attempt
        assert attempts[0] == 0
        assert set(np.diff(attempts)) <= {0, 1}
        if solution.converged:
            assert attempts[-1] == solution.restarts
            found += solution.restarts > 0
    assert found

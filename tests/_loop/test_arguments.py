"""Configurations, targets and tolerances that are refused, and what is read as one."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering

from ..conftest import ball_arm, planar
from .conftest import solver


class TestInvalidInput:
    @pytest.mark.parametrize("q", [[0.1], [0.1] * 3, 0.1, [[0.1, 0.2]], [0.1, np.nan], [np.inf, 0], "ab", [0.1, None]])
    def test_a_configuration_of_another_shape_or_not_finite_by_name(self, q):
        ik = solver(planar(2))
        for call, name in (
            (lambda: ik.solve([1.0, 1.0], q0=q), "q0"),
            (lambda: ik.step(q, [1.0, 1.0]), "q"),
            (lambda: ik.track([[1.0, 1.0]], q0=q), "q0"),
        ):
            with pytest.raises(jtik.ArgumentError, match=r"shape \(2,\)") as caught:
                call()
            assert caught.value.argument == name

    def test_a_step_needs_a_configuration(self):
        """A solve starts from the robot's home by default, a controller from where the robot is."""
        ik = solver(planar(2), strategy="newton+qp", criteria=JointCentering())
        for call in (lambda: ik.step(None, [1.0, 1.0]), lambda: ik.build(None, [1.0, 1.0])):
            with pytest.raises(jtik.ArgumentError, match=r"q: .*NoneType.*shape \(2,\)"):
                call()
        assert ik.solve([1.0, 1.0], q0=None).q.shape == (2,)

    @pytest.mark.parametrize(
        "wrong",
        [np.array(["1", "1"]), np.array([1 + 0j, 1]), np.array([True, False]), np.array([1.0, 1.0], dtype=object)],
    )
    def test_arrays_that_are_no_numbers_are_not_copied(self, wrong):
        """NumPy would read them, the text as numbers, without the imaginary part, as 1 and 0."""
        ik, good = solver(planar(2)), np.array([1.0, 0.5])
        for call, name in ((lambda: ik.step(wrong, good), "q"), (lambda: ik.step(good, wrong), "target")):
            with pytest.raises(jtik.ArgumentError) as caught:
                call()
            assert caught.value.argument == name

    @pytest.mark.parametrize("dtype", [np.float32, np.int64])
    def test_other_numbers_are_read_as_floats(self, dtype):
        ik = solver(planar(2))
        q = np.array([1, 0], dtype=dtype)
        assert ik.step(q, np.array([1, 1], dtype=np.float32)).q.tolist() == ik.step([1.0, 0.0], [1.0, 1.0]).q.tolist()

    def test_a_list_and_a_tuple_are_read_as_an_array_is(self):
        ik, target = solver(planar(3)), np.array([1.0, 1.5])
        expected = ik.solve(target, q0=np.array([0.1, 0.2, 0.3])).q.tolist()
        for q0 in ([0.1, 0.2, 0.3], (0.1, 0.2, 0.3), [np.float64(0.1), 0.2, 0.3]):
            assert ik.solve(target, q0=q0).q.tolist() == expected

    @pytest.mark.parametrize("name", ["position_tolerance", "orientation_tolerance", "optimality_tolerance"])
    @pytest.mark.parametrize("value", [0.0, -1e-6, np.nan, np.inf, "small", [1e-6, 1e-6]])
    def test_tolerances_are_finite_and_positive(self, name, value):
        with pytest.raises(jtik.ArgumentError) as caught:
            solver(planar(2)).solve([1.0, 1.0], **{name: value})
        assert caught.value.argument == name

    @pytest.mark.parametrize("robot", [None, "planar", 3])
    def test_an_argument_that_is_not_a_robot(self, robot):
        with pytest.raises(jtik.ArgumentError, match="robot.*a jtik.Robot"):
            solver(robot)

    def test_limits_that_are_crossed(self):
        with pytest.raises(jtik.ArgumentError, match="limits"):
            jtik.Robot.planar(2, lower=[0.0, 1.0], upper=[1.0, 0.0])

    def test_a_zero_quaternion(self):
        robot = ball_arm()
        q0 = robot.neutral.copy()
        q0[:4] = 0
        with pytest.raises(jtik.ArgumentError, match="quaternion"):
            solver(robot).solve([0.5, 0.5, 0.5], q0=q0)
        with pytest.raises(jtik.ArgumentError, match="quaternion"):
            solver(robot).step(q0, [0.5, 0.5, 0.5])

    def test_a_refusal_leaves_the_solver_as_it_was(self):
        ik, q0 = solver(planar(3)), [0.3, 0.2, 0.1]
        before = ik.solve([1.0, 1.0], q0=q0).q.tolist()
        for wrong in (
            {"q0": [np.nan] * 3},
            {"position_tolerance": -1},
            {"max_iterations": -1},
            {"until": "x"},
        ):
            with pytest.raises(jtik.ArgumentError):
                ik.solve([2.0, 0.0], **wrong)
        with pytest.raises(jtik.ArgumentError):
            ik.solve([np.nan, 0.0])
        assert ik.solve([1.0, 1.0], q0=q0).q.tolist() == before

    def test_a_controllers_arrays_are_checked_as_lists_are(self):
        """The fast path for arrays refuses NaN, infinity and other shapes."""
        ik = solver(planar(2))
        good, target = np.array([0.1, 0.2]), np.array([1.0, 1.0])
        for q, x, name in (
            (np.array([np.nan, 0.0]), target, "q"),
            (np.array([-np.inf, 0.0]), target, "q"),
            (np.zeros(3), target, "q"),
            (np.zeros((2, 1)), target, "q"),
            (good, np.array([np.nan, 0.0]), "target"),
            (good, np.array([np.inf, 0.0]), "target"),
            (good, np.zeros(3), "target"),
        ):
            with pytest.raises(jtik.ArgumentError) as caught:
                ik.step(q, x)
            assert caught.value.argument == name

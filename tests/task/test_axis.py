"""AxisTask: the rotation from a direction to an axis, by angles from zero to pi."""

from __future__ import annotations

import functools

import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import jtik
from jtik.task.pointing import NARROW, across, rotation_onto

from ..conftest import DIFFERENCES, EXACT, differences, report_at
from .conftest import ROBOTS, ball_arm, built, dh_arm, floating_arm, planar, solver

AXES = [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, 1, 0), (0.3, -0.5, 0.8), (1, 1, 1), (-1, 1, 0)]


def unit(vector):
    return np.asarray(vector, dtype=float) / np.linalg.norm(vector)


def away(axis, angle, side):
    """The direction at ``angle`` from the unit vector ``axis``, rotated about it by ``side`` [rad]."""
    direction = Rotation.from_rotvec(side * axis).apply(across(axis)[0])
    return np.cos(angle) * axis + np.sin(angle) * direction


@functools.cache
def compiled(axis):
    u = casadi.SX.sym("u", 3)
    error = rotation_onto(np.array(axis), u)
    return casadi.Function("rotation", [u], [error, casadi.jacobian(error, u)])


def rotation_vector(axis, direction):
    return compiled(tuple(axis))(direction)[0].full()[:, 0]


class TestRotationOnto:
    @given(st.sampled_from(AXES), st.floats(0, np.pi - 1e-5), st.floats(-np.pi, np.pi))
    def test_it_is_the_shortest_rotation_from_the_direction_to_the_axis(self, axis, angle, side):
        axis = unit(axis)
        direction = away(axis, angle, side)
        found = rotation_vector(axis, direction)
        assert np.linalg.norm(found) == pytest.approx(angle, abs=1e-11)
        vector = found @ np.array(across(axis))
        assert Rotation.from_rotvec(vector).apply(direction) == pytest.approx(axis, abs=1e-10)

    @pytest.mark.thinned
    @pytest.mark.parametrize("axis", AXES)
    @pytest.mark.parametrize("angle", [1e-3, 2e-6, 5e-7, 1e-9, 1e-13, 0.0])
    def test_small_angles_keep_their_accuracy(self, axis, angle):
        axis = unit(axis)
        first, second = across(axis)
        direction = np.cos(angle) * axis + np.sin(angle) * (0.6 * first + 0.8 * second)
        assert rotation_vector(axis, direction) == pytest.approx([0.8 * angle, -0.6 * angle], rel=EXACT, abs=1e-15)

    def test_tiny_angles_are_not_lost(self):
        assert rotation_vector((0, 0, 1), (6e-201, 8e-201, 1.0)) == pytest.approx([8e-201, -6e-201], rel=EXACT, abs=0)

    @pytest.mark.parametrize("axis", AXES)
    def test_from_opposite_the_rotation_is_about_the_first_basis_vector(self, axis):
        axis = unit(axis)
        found = rotation_vector(axis, -axis)
        assert found == pytest.approx([np.pi, 0.0], abs=EXACT)
        assert Rotation.from_rotvec(found @ np.array(across(axis))).apply(-axis) == pytest.approx(axis, abs=EXACT)

    @pytest.mark.thinned
    @pytest.mark.parametrize("side", np.linspace(-3, 3, 7))
    @pytest.mark.parametrize("angle", [NARROW * 0.999, NARROW * 1.001, np.pi - NARROW * 0.999, np.pi - NARROW * 1.001])
    def test_the_length_is_the_angle_on_both_sides_of_where_the_formula_changes(self, angle, side):
        axis = unit((0.3, -0.5, 0.8))
        # at pi the choice of the rotation changes the length by up to twice the width of the cone
        assert np.linalg.norm(rotation_vector(axis, away(axis, angle, side))) == pytest.approx(angle, abs=2.1 * NARROW)
        if angle < 1:
            assert np.linalg.norm(rotation_vector(axis, away(axis, angle, side))) == pytest.approx(angle, rel=1e-9)

    @pytest.mark.parametrize("side", np.linspace(-3, 3, 13))
    def test_away_from_pi_the_length_does_not_rise(self, side):
        axis = np.array([0.0, 0.0, 1.0])
        lengths = [
            np.linalg.norm(rotation_vector(axis, away(axis, np.pi - NARROW * gap, side))) for gap in (0.99, 1.01, 2.0)
        ]
        assert lengths == sorted(lengths, reverse=True)

    @pytest.mark.parametrize("angle", [0.0, 1e-200, 1e-9, NARROW, 1.0, np.pi - NARROW, np.pi - 1e-9, np.pi])
    def test_value_and_derivative_are_finite_everywhere(self, angle):
        for axis in map(unit, AXES):
            for side in np.linspace(-3, 3, 5):
                for output in compiled(tuple(axis))(away(axis, angle, side)):
                    assert np.isfinite(output.full()).all()

    @pytest.mark.parametrize("axis", AXES)
    def test_the_basis_is_right_handed(self, axis):
        axis = unit(axis)
        basis = np.array([*across(axis), axis])
        assert basis @ basis.T == pytest.approx(np.eye(3), abs=EXACT)
        assert np.linalg.det(basis) == pytest.approx(1.0, abs=EXACT)

    def test_the_basis_of_a_coordinate_axis_is_the_next_two(self):
        x, y, z = np.eye(3)
        for axis, basis in ((x, (y, z)), (y, (z, x)), (z, (x, y))):
            assert np.array_equal(across(axis), basis)


@pytest.mark.quick(2)
@pytest.mark.parametrize("name", ROBOTS)
def test_error_is_the_rotation_in_the_frames_axes(name, rng):
    robot = ROBOTS[name]()
    for axis in AXES[:5]:
        ik = built(robot, jtik.AxisTask, "tip", axis)
        q, direction = robot.random_configuration(rng), rng.standard_normal(3)
        R = robot.pose(q)[:3, :3]
        found = report_at(ik, q, direction)
        rotation = Rotation.from_rotvec(R @ (found.error @ np.array(across(unit(axis)))))
        assert rotation.apply(unit(direction)) == pytest.approx(R @ unit(axis), abs=1e-10)
        assert found.orientation_error == pytest.approx(np.arccos(unit(direction) @ R @ unit(axis)), abs=1e-9)
        assert found.position_error == 0.0


def test_for_the_z_axis_it_is_the_orientation_task_without_rz(rng):
    """The rows "rx", "ry" of a target that differs by a rotation about an axis in the x-y plane."""
    robot = dh_arm(7, 2)
    q = robot.random_configuration(rng)
    R = robot.pose(q)[:3, :3]
    error = np.array([0.7, -1.1, 0.0])
    target = R @ Rotation.from_rotvec(-error).as_matrix()
    of_frame = report_at(built(robot, jtik.FrameTask, "tip", "orientation", axes=("rx", "ry")), q, target)
    assert of_frame.error == pytest.approx(error[:2], abs=1e-11)
    assert report_at(built(robot, jtik.AxisTask), q, target[:, 2]).error == pytest.approx(error[:2], abs=1e-11)


@pytest.mark.thinned
@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-7, 1e-5, 0.4, 2.0, np.pi - 0.1])
@pytest.mark.parametrize("name", ROBOTS)
def test_jacobian_is_the_derivative_of_the_error(name, angle, rng):
    robot = ROBOTS[name]()
    ik = built(robot, jtik.AxisTask, "tip", (0.6, 0.0, 0.8))
    q = robot.random_configuration(rng)
    direction = robot.pose(q)[:3, :3] @ away(unit((0.6, 0.0, 0.8)), angle, 1.0)
    numeric = differences(lambda at: report_at(ik, at, direction).error, robot, q)
    # at pi - 0.1 third derivatives are some 1e4
    assert report_at(ik, q, direction).jacobian == pytest.approx(numeric, abs=DIFFERENCES)


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-5])
def test_close_to_pi_the_jacobian_is_the_closed_form(gap, rng):
    """For a frame that rotates at w: e' = (n.w) n + angle (cot(angle) m.w - c.w) m, with e = angle n and m = c x n."""
    robot = dh_arm(7, 2)
    q = robot.random_configuration(rng)
    R, angle = robot.pose(q)[:3, :3], np.pi - gap
    found = report_at(built(robot, jtik.AxisTask), q, R @ away(np.array([0.0, 0.0, 1.0]), angle, 0.7))
    n = unit(found.error)
    m = np.array([-n[1], n[0]])
    w = R.T @ robot.jacobian(q)[3:]
    assert n @ found.jacobian == pytest.approx(n @ w[:2], abs=1e-9)
    rate = angle * (m @ w[:2] / np.tan(angle) - w[2])
    # the sine is known to 1e-16, so the rate to 1e-16 / gap of its size 1 / gap; times 100 as a margin
    assert m @ found.jacobian == pytest.approx(rate, abs=1e-14 / gap**2)


@pytest.mark.parametrize("name", ROBOTS)
def test_jacobian_on_the_target_itself(name, rng):
    robot = ROBOTS[name]()
    q = robot.random_configuration(rng)
    R = robot.pose(q)[:3, :3]
    found = report_at(built(robot, jtik.AxisTask), q, R[:, 2])
    assert found.error == pytest.approx([0.0, 0.0], abs=EXACT)
    assert found.jacobian == pytest.approx((R.T @ robot.jacobian(q)[3:])[:2], abs=EXACT)


@pytest.mark.parametrize("gap", [0.0, 1e-8, 1e-5, 1e-2, 1.0])
@pytest.mark.parametrize("make", [lambda: dh_arm(7, 2), ball_arm, floating_arm])
def test_it_is_reached_from_any_angle(make, gap, rng):
    robot = make()
    ik = built(robot, jtik.AxisTask)
    for side in (0.0, 2.0):
        q = robot.random_configuration(rng)
        direction = robot.pose(q)[:3, :3] @ away(np.array([0.0, 0.0, 1.0]), np.pi - gap, side)
        solution = ik.solve(direction, q0=q)
        assert solution.converged
        assert robot.pose(solution.q)[:3, 2] == pytest.approx(direction, abs=2e-6)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (1, 2, 0)])
def test_a_robot_with_parallel_axes_moves_away_from_the_opposite_direction(axis):
    """For the x axis the rotation about the first basis vector, y, is impossible with parallel axes."""
    robot = jtik.Robot.from_dh([(0.3, 0, 0, 0)] * 3)
    solution = built(robot, jtik.AxisTask, "tip", axis).solve(-np.array(axis), q0=np.zeros(3))
    assert solution.converged
    assert abs(solution.q.sum()) == pytest.approx(np.pi, abs=2e-6)


class TestInThePlane:
    def test_error_is_one_angle(self, rng):
        robot = planar(4)
        ik = built(robot, jtik.AxisTask, "tip", (1, 2))
        for _ in range(20):
            q, angle = robot.random_configuration(rng), rng.uniform(-np.pi, np.pi)
            expected = (q.sum() + np.arctan2(2, 1) - angle + np.pi) % (2 * np.pi) - np.pi
            found = report_at(ik, q, (3 * np.cos(angle), 3 * np.sin(angle)))
            assert found.error == pytest.approx([expected], abs=EXACT)
            assert found.jacobian == pytest.approx(np.ones((1, 4)), abs=EXACT)

    def test_it_is_reached_from_the_opposite(self):
        solution = built(planar(3), jtik.AxisTask, "tip", (1, 0, 0)).solve((-1, 0), q0=np.zeros(3))
        assert solution.converged
        assert abs(solution.q.sum()) == pytest.approx(np.pi, abs=2e-6)

    def test_an_axis_out_of_the_plane_is_refused(self):
        with pytest.raises(jtik.ArgumentError, match=r"axis.*in the plane.*\(1, 0\)"):
            built(planar(3), jtik.AxisTask)


class TestInvalidInput:
    @pytest.mark.parametrize("axis", [(0, 0, 0), (0, 0), (1e-13, 0, 0), (1,), (1, 0, 0, 0), 1.0, "z", (np.nan, 0, 1)])
    @pytest.mark.parametrize("task", [jtik.AxisTask, jtik.LookAtTask])
    def test_an_invalid_axis_is_refused_when_the_task_is_created(self, task, axis):
        with pytest.raises(jtik.ArgumentError, match="^axis: ") as caught:
            task("tip", axis)
        assert caught.value.argument == "axis"

    @pytest.mark.parametrize("target", [(0, 0, 0), (0, 1e-13, 0), (1, 0), 1.0, np.eye(3), "up", None, (np.nan, 0, 1)])
    def test_an_invalid_direction_is_refused(self, target):
        with pytest.raises(jtik.ArgumentError, match=r"(?s)^target: .*a direction \(x, y, z\), not zero"):
            built(dh_arm(), jtik.AxisTask).solve(target)

    @pytest.mark.parametrize("task", [jtik.AxisTask, jtik.LookAtTask])
    def test_an_unknown_frame_lists_the_frames(self, task):
        with pytest.raises(jtik.UnknownNameError) as caught:
            solver(dh_arm(), task("hand"))
        assert caught.value.name == "hand"

    def test_a_stiffness_for_other_than_two_rows_is_refused(self):
        with pytest.raises(jtik.ArgumentError, match="stiffness.*2 positive values"):
            built(dh_arm(), jtik.AxisTask, stiffness=(1.0, 1.0, 1.0))


def test_a_direction_may_have_any_length(rng):
    robot = dh_arm()
    ik = built(robot, jtik.AxisTask)
    q, direction = robot.random_configuration(rng), rng.standard_normal(3)
    expected = report_at(ik, q, direction).error
    for scale in (1e-9, 1e9, 1e200):
        assert report_at(ik, q, scale * direction).error == pytest.approx(expected, abs=EXACT)

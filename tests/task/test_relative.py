"""RelativeFrameTask: a frame in the axes of another, against mink, SciPy and differences."""

from __future__ import annotations

import mink
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jtik

from ..conftest import DIFFERENCES, EXACT, differences, report_at
from .conftest import ball_arm, built, planar, two_arms, two_arms_model

KINDS = ("position", "orientation", "pose")
MINK = 1e-9
"""MuJoCo keeps unit quaternions to rounding; a random rotation may be close to pi, where that counts more."""

PAIRS = {
    "hands": (two_arms, "left", "right"),
    "hand in the trunk": (two_arms, "left", "trunk"),
    "trunk in the hand": (two_arms, "trunk", "right"),
    "eye in the world": (two_arms, "eye", "world"),
    "two ball joints": (ball_arm, "tip", "base"),
    "one ball joint": (ball_arm, "fore", "tip"),
    "plane": (lambda: planar(4), "tip", "link2"),
}


def relative_pose(robot, q, frame, reference):
    return np.linalg.inv(robot.pose(q, reference)) @ robot.pose(q, frame)


def expected_error(robot, q, kind, pair, target):
    """From robot.pose and scipy."""
    pose = relative_pose(robot, q, *pair)
    position = (pose - target)[: robot.dimension, 3]
    rotation = Rotation.from_matrix(target[:3, :3].T @ pose[:3, :3]).as_rotvec()
    rotation = rotation[2:] if robot.dimension == 2 else rotation
    return {"position": position, "orientation": rotation, "pose": np.concatenate([position, rotation])}[kind]


@pytest.mark.thinned
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", PAIRS)
def test_error_is_that_of_the_pose_in_the_reference(name, kind, rng):
    make, *pair = PAIRS[name]
    robot = make()
    ik = built(robot, jtik.RelativeFrameTask, *pair, kind)
    for _ in range(5):
        q, target = (robot.random_configuration(rng) for _ in range(2))
        target = relative_pose(robot, target, *pair)
        found = report_at(ik, q, target)
        assert found.error == pytest.approx(expected_error(robot, q, kind, pair, target), abs=MINK)


@pytest.mark.thinned
@pytest.mark.parametrize("gap", [0.0, 0.3, np.pi - 1e-2])
@pytest.mark.parametrize("name", PAIRS)
def test_jacobian_is_the_derivative_of_the_error(name, gap, rng):
    """On the target, away from it, and at a rotation of almost pi."""
    make, *pair = PAIRS[name]
    robot = make()
    ik = built(robot, jtik.RelativeFrameTask, *pair)
    for _ in range(3):
        q = robot.random_configuration(rng)
        target = relative_pose(robot, q, *pair)
        axis = np.array([0.0, 0.0, 1.0]) if robot.dimension == 2 else rng.standard_normal(3)
        target[:3, :3] = target[:3, :3] @ Rotation.from_rotvec(gap * axis / np.linalg.norm(axis)).as_matrix()
        target[: robot.dimension, 3] += gap
        numeric = differences(lambda at, t=target: report_at(ik, at, t).error, robot, q)
        assert report_at(ik, q, target).jacobian == pytest.approx(numeric, abs=DIFFERENCES)


def test_error_and_jacobian_agree_with_mink(rng):
    """mink's error is the logarithm of the pose error: the same rotation, with its own translation."""
    robot, model = two_arms(), two_arms_model()
    ik = built(robot, jtik.RelativeFrameTask, "left", "right")
    theirs = mink.RelativeFrameTask("left", "body", "right", "body", position_cost=1.0, orientation_cost=1.0)
    configuration = mink.Configuration(model)
    for _ in range(5):
        q, other = robot.random_configuration(rng), robot.random_configuration(rng)
        configuration.update(other)
        target = configuration.get_transform("left", "body", "right", "body")
        theirs.set_target(target)
        configuration.update(q)
        twist = theirs.compute_error(configuration)
        found = report_at(ik, q, target)
        assert found.error[3:] == pytest.approx(twist[3:], abs=MINK)
        moved = (target @ mink.SE3.exp(twist)).translation()
        assert found.error[:3] == pytest.approx(moved - target.translation(), abs=MINK)
        assert found.jacobian[3:] == pytest.approx(theirs.compute_jacobian(configuration)[3:], abs=MINK)


def test_joints_that_carry_both_frames_do_not_appear(rng):
    robot = two_arms()
    q = robot.random_configuration(rng)
    ik = built(robot, jtik.RelativeFrameTask, "left", "right")
    jacobian = report_at(ik, q, np.eye(4)).jacobian
    between = [
        k
        for name in ("left1", "left2", "left3", "right1", "right2", "right3", "right")
        for k in range(*robot.v_slice(name).indices(robot.n))
    ]
    assert not np.delete(jacobian, between, axis=1).any()
    assert np.abs(jacobian[:, between]).max(axis=0).min() > 0


def test_on_a_straight_arm_the_radial_row_is_zero():
    robot = planar(4)
    found = report_at(built(robot, jtik.RelativeFrameTask, "tip", "link2", "position"), np.zeros(4), (1.0, 1.0))
    assert found.error == pytest.approx([2.0, -1.0], abs=EXACT)
    assert found.jacobian == pytest.approx(np.array([[0, 0, 0, 0], [0, 0, 2, 1]]), abs=EXACT)


def test_axes_are_those_of_the_reference(rng):
    robot = two_arms()
    q = robot.random_configuration(rng)
    full = report_at(built(robot, jtik.RelativeFrameTask, "left", "right"), q, np.eye(4))
    part = report_at(built(robot, jtik.RelativeFrameTask, "left", "right", axes=("z", "rx")), q, np.eye(4))
    assert part.error.tolist() == full.error[[2, 3]].tolist()


def test_a_relative_pose_is_reached(rng):
    robot = two_arms()
    goal = robot.random_configuration(rng)
    ik = built(robot, jtik.RelativeFrameTask, "left", "right")
    target = relative_pose(robot, goal, "left", "right")
    solution = ik.solve(target, q0=robot.integrate(goal, rng.uniform(-0.3, 0.3, robot.n)))
    assert solution.converged
    assert relative_pose(robot, solution.q, "left", "right") == pytest.approx(target, abs=5e-6)


class TestInvalidInput:
    def test_a_frame_is_not_its_own_reference(self):
        with pytest.raises(jtik.ArgumentError, match="reference: given left; accepted: a frame other than") as caught:
            jtik.RelativeFrameTask("left", "left")
        assert caught.value.argument == "reference"

    @pytest.mark.parametrize("pair", [("hand", "left"), ("left", "hand")])
    def test_an_unknown_frame_lists_the_frames(self, pair):
        with pytest.raises(jtik.UnknownNameError) as caught:
            built(two_arms(), jtik.RelativeFrameTask, *pair)
        assert caught.value.name == "hand"
        assert set(caught.value.known) == set(two_arms().frame_names)

    def test_a_target_is_refused_as_for_a_frame(self):
        ik = built(two_arms(), jtik.RelativeFrameTask, "left", "right")
        for invalid in (np.full((4, 4), np.nan), (0.0, 0.0, 0.0), np.diag([1.0, 1.0, -1.0, 1.0])):
            with pytest.raises(jtik.ArgumentError, match="^target: "):
                ik.solve(invalid)

"""URDF text: read back by jtik and by Pinocchio, which the writer does not use."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jtik
from jtik.interop.urdf import UNLIMITED, to_urdf
from jtik.robot import JointType
from jtik.robot.masses_and_shapes import Mass
from jtik.robot.tree import Mimic

from ..conftest import ball_arm, floating_arm

EXACT = 1e-12


def pose_of(x, y, z, *rpy):
    """A pose by position and roll, pitch and yaw."""
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    pose[:3, :3] = Rotation.from_euler("xyz", rpy).as_matrix()
    return pose


def arm(pitch=0.3):
    """Every joint type of URDF, skew axes, and a fixed frame whose pitch may be a right angle."""
    skew = np.array([1.0, 2.0, -2.0]) / 3
    return jtik.Robot(
        [
            jtik.Joint("yaw", JointType.REVOLUTE, "base", "a", origin=pose_of(0, 0, 0.3, 0.1, 0.2, 0.3)),
            jtik.Joint("shoulder", JointType.REVOLUTE, "a", "b", axis=skew, lower=-2.0, upper=2.5, velocity_limit=1.5),
            jtik.Joint(
                "reach",
                JointType.PRISMATIC,
                "b",
                "c",
                origin=pose_of(0.3, 0, 0.1, 0.5, pitch, -2.0),
                lower=-0.1,
                upper=0.4,
            ),
            jtik.Joint("rail", JointType.PRISMATIC, "c", "d", axis=skew),
            jtik.Joint("stop", JointType.REVOLUTE, "d", "e", lower=-1.0),
            jtik.Joint("follower", JointType.REVOLUTE, "e", "f", axis=skew, mimic=Mimic("shoulder", 0.5, 0.1)),
            jtik.Joint("tip", JointType.FIXED, "f", "tip", origin=pose_of(0.1, 0.2, 0.3, 1.0, -pitch, 2.0)),
        ],
        name="arm",
        masses={"b": Mass(2.0, np.array([0.1, 0.0, 0.2])), "tip": Mass(0.5)},
    )


@pytest.mark.quick(2)
@pytest.mark.parametrize("pitch", [0.3, math.pi / 2, -math.pi / 2, math.pi / 2 - 1e-7])
def test_written_and_read_back(pitch, rng):
    """Also where roll and yaw are rotations about the same axis."""
    robot = arm(pitch)
    again = jtik.Robot.from_urdf(to_urdf(robot), tip="tip")
    assert again.joint_names == robot.joint_names
    assert again.frame_names == robot.frame_names
    for _ in range(5):
        q = robot.random_configuration(rng)
        for frame in robot.frame_names:
            assert again.pose(q, frame) == pytest.approx(robot.pose(q, frame), abs=EXACT)
        assert again.center_of_mass(q) == pytest.approx(robot.center_of_mass(q), abs=EXACT)


def test_limits():
    robot = arm()
    again = jtik.Robot.from_urdf(to_urdf(robot), tip="tip")
    known = np.isfinite(robot.lower) & np.isfinite(robot.upper)
    assert (again.lower[known] == robot.lower[known]).all()
    assert (again.upper[known] == robot.upper[known]).all()
    assert again.lower.tolist() == [-math.inf, *robot.lower[1:3], -UNLIMITED, -1.0]
    assert again.upper.tolist() == [math.inf, *robot.upper[1:3], UNLIMITED, UNLIMITED]
    assert again.velocity_limit.tolist() == [UNLIMITED, *robot.velocity_limit[1:2], *[UNLIMITED] * 3]


def test_a_joint_with_equal_limits_keeps_them():
    """Readers ignore limits that are both zero."""
    robot = jtik.Robot([jtik.Joint("stuck", JointType.REVOLUTE, "base", "tip", lower=0.0, upper=0.0)])
    again = jtik.Robot.from_urdf(to_urdf(robot))
    assert (again.lower[0], again.upper[0]) == pytest.approx((0.0, 0.0), abs=1e-8)


def test_limits_for_revolute_joints_without_any():
    again = jtik.Robot.from_urdf(to_urdf(arm(), revolute_limit=3.0), tip="tip")
    assert (again.lower[0], again.upper[0]) == (-3.0, 3.0)
    assert again.lower[3] == -UNLIMITED  # a prismatic joint


def test_one_chain_of_a_tree():
    robot = jtik.Robot.builtin("panda")
    again = jtik.Robot.from_urdf(to_urdf(robot, frame="tip"), tip="tip")
    assert [joint.child for joint in again.joints] == [joint.child for joint in robot.path("tip")]
    q = robot.keyframes["home"]
    reordered = np.concatenate([q[robot.q_slice(joint)] for joint in again.joint_names])
    assert again.pose(reordered) == pytest.approx(robot.pose(q), abs=EXACT)


@pytest.mark.quick(2)
@pytest.mark.parametrize("name", ["panda", "ur5e", "jaco2", "vehicle_panda", "planar10"])
def test_pinocchio_reads_the_same_robot(name, rng):
    pinocchio = pytest.importorskip("pinocchio")
    from jtik.interop.pinocchio_model import PinocchioCorrespondence

    robot = jtik.Robot.builtin(name)
    model = pinocchio.buildModelFromXML(to_urdf(robot))
    correspondence, data = PinocchioCorrespondence(robot, model), model.createData()
    for _ in range(3):
        q = robot.random_configuration(rng)
        pinocchio.framesForwardKinematics(model, data, correspondence.theirs(q))
        for frame in robot.frame_names:
            # by its name alone, as pink does: a fixed joint must not have the name of a frame
            pose = data.oMf[model.getFrameId(frame)].homogeneous
            assert robot.pose(q, frame) == pytest.approx(pose, abs=EXACT)


def test_pinocchio_reads_limits_and_followers(rng):
    pinocchio = pytest.importorskip("pinocchio")
    robot = arm()
    model = pinocchio.buildModelFromXML(to_urdf(robot))
    number = model.joints[model.getJointId("shoulder")]
    assert (model.lowerPositionLimit[number.idx_q], model.upperPositionLimit[number.idx_q]) == (-2.0, 2.5)
    assert model.velocityLimit[number.idx_v] == 1.5
    assert model.existJointName("follower")


class TestWrongInput:
    @pytest.mark.parametrize("robot", [ball_arm(), floating_arm()], ids=["ball", "free"])
    def test_joints_that_urdf_cannot_describe(self, robot):
        with pytest.raises(jtik.ArgumentError, match="accepted: revolute, prismatic and fixed joints"):
            to_urdf(robot)

    def test_a_frame_that_does_not_exist(self):
        with pytest.raises(jtik.errors.UnknownNameError, match="frame 'top'"):
            to_urdf(arm(), frame="top")

    def test_a_chain_that_follows_another(self):
        robot = jtik.Robot(
            [
                jtik.Joint("left", JointType.REVOLUTE, "base", "l"),
                jtik.Joint("right", JointType.REVOLUTE, "base", "r", mimic=Mimic("left")),
            ]
        )
        with pytest.raises(jtik.ArgumentError, match="'right' follows 'left' elsewhere"):
            to_urdf(robot, frame="r")

    @pytest.mark.parametrize("limit", [0.0, -1.0, math.inf, math.nan])
    def test_a_limit_that_is_not_positive(self, limit):
        message = rf"^revolute_limit: given {limit}; accepted: a positive angle \[rad\], or None$"
        with pytest.raises(jtik.ArgumentError, match=message):
            to_urdf(arm(), revolute_limit=limit)


def test_the_old_name_of_the_limit_is_an_alias():
    with pytest.warns(DeprecationWarning, match=r"^to_urdf\(turn=\) is now to_urdf\(revolute_limit=\)$"):
        text = to_urdf(arm(), turn=3.0)
    assert text == to_urdf(arm(), revolute_limit=3.0)

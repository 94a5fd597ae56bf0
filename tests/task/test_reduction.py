"""The joints that a solver moves."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.robot import Joint, JointType, Mass, Mimic, Robot
from jtik_formulations import JointCentering

from ..conftest import planar, shared_solver


def shift(x, y=0.0):
    pose = np.eye(4)
    pose[:2, 3] = x, y
    return pose


@pytest.fixture(scope="module")
def gripper():
    """Three links, and on the last one a finger and a follower of it."""
    arm = planar(3).joints
    fingers = [
        Joint("finger", JointType.REVOLUTE, "tip", "finger", origin=shift(0, 0.1), lower=0.0, upper=1.0),
        Joint("other", JointType.REVOLUTE, "tip", "other", origin=shift(0, -0.1), mimic=Mimic("finger", -1.0)),
    ]
    return Robot([*arm, *fingers], planar=True, tip="tip", masses={"link1": Mass(1.0), "other": Mass(0.5, [0.1, 0, 0])})


def test_fingers_are_no_part_of_an_arms_solution(gripper):
    ik = shared_solver(gripper, jtik.FrameTask(), criteria=JointCentering())
    solution = ik.solve([1.5, 1.0], q0=[0.3, 0.4, 0.5])
    assert ik.robot.joint_names == ("joint1", "joint2", "joint3")
    assert solution.q.shape == (3,)
    assert solution.converged


def test_the_other_joints_stay_where_they_are(gripper):
    ik = shared_solver(gripper, jtik.FrameTask(), at=[0, 0, 0, 0.7])
    full = ik.full_configuration(ik.solve([1.5, 1.0], q0=[0.3, 0.4, 0.5]).q)
    assert full[3] == 0.7
    assert gripper.position(full, "tip") == pytest.approx([1.5, 1.0], abs=1e-6)
    assert ik.robot.position(full[:3], "other") == pytest.approx(gripper.position(full, "other"))


def test_a_follower_moves_its_leader(gripper):
    ik = shared_solver(gripper, jtik.FrameTask("other", "pose"))
    assert ik.robot is gripper


def test_a_joint_counts_if_it_moves_the_frame_though_not_its_origin():
    """The last joint rotates the tip about its origin: a position task keeps this joint."""
    robot = Robot([*planar(2).joints, Joint("wrist", JointType.REVOLUTE, "tip", "hand")], planar=True)
    assert shared_solver(robot, jtik.FrameTask("hand")).robot.n == 3


def test_joints_by_name_and_all(gripper):
    task = jtik.FrameTask()
    assert shared_solver(gripper, task, joints=["joint2", "joint3"]).robot.joint_names == ("joint2", "joint3")
    assert shared_solver(gripper, task, joints="all").robot is gripper


def test_several_tasks_move_what_each_of_them_moves(gripper):
    tasks = [jtik.FrameTask("link2"), jtik.FrameTask("finger", "orientation")]
    assert shared_solver(gripper, tasks).robot is gripper
    assert shared_solver(gripper, tasks[0]).robot.joint_names == ("joint1", "joint2")


def test_a_relative_task_moves_what_lies_between(gripper):
    ik = shared_solver(gripper, jtik.RelativeFrameTask("finger", "link2", "position"))
    assert ik.robot.joint_names == ("joint2", "joint3")[1:]


def test_the_centre_of_mass_moves_with_whatever_carries_a_mass(gripper):
    ik = shared_solver(gripper, jtik.CenterOfMassTask())
    assert ik.robot is gripper


def test_a_robot_that_cannot_move_is_refused():
    still = Robot([Joint("mount", JointType.FIXED, "base", "tip", origin=shift(1.0))])
    with pytest.raises(jtik.ArgumentError, match="robot"):
        jtik.InverseKinematics(still, jtik.FrameTask())


def test_joints_that_do_not_move_the_task_are_refused(gripper):
    with pytest.raises(jtik.ArgumentError, match=r"joints.*finger.*joint1"):
        jtik.InverseKinematics(gripper, jtik.FrameTask(), joints=["finger"])
    with pytest.raises(jtik.ArgumentError, match="task"):
        jtik.InverseKinematics(gripper, jtik.FrameTask("base"))
    with pytest.raises(jtik.UnknownNameError, match="joint9"):
        jtik.InverseKinematics(gripper, jtik.FrameTask(), joints=["joint1", "joint9"])
    with pytest.raises(jtik.ArgumentError, match="at"):
        jtik.InverseKinematics(gripper, jtik.FrameTask(), at=[0.0])
    with pytest.raises(jtik.ArgumentError, match=r"q0.*3 numbers for ik\.robot, or 4 for the full robot"):
        jtik.InverseKinematics(gripper, jtik.FrameTask()).solve([1.0, 1.0], q0=np.zeros(5))

"""A robot as a MuJoCo model: the same poses and velocities, and the correspondence of their numbers."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import jtik
from jtik.interop.mink import MujocoCorrespondence, to_mujoco
from jtik.robot import JointType, Mass

from ..conftest import ball_arm, dh_arm, floating_arm, planar

POSES = 1e-10
"""Two implementations of the same arithmetic."""

X = np.array([1.0, 0.0, 0.0])


def shifted(x, y=0.0, z=0.0):
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def gripper():
    """A branched tree whose q is not in the order of its bodies; one finger follows another, a third does not."""
    return jtik.Robot(
        [
            jtik.Joint("turn", JointType.REVOLUTE, "world", "palm", origin=shifted(0, 0, 0.2), lower=-1, upper=2),
            jtik.Joint("outer", JointType.REVOLUTE, "world", "post", origin=shifted(1), upper=1),
            jtik.Joint(
                "left", JointType.PRISMATIC, "palm", "finger", origin=shifted(0.1, 0.02), axis=X, lower=0, upper=0.1
            ),
            jtik.Joint(
                "right",
                JointType.PRISMATIC,
                "palm",
                "thumb",
                origin=shifted(0.1, -0.02),
                axis=-X,
                mimic=jtik.robot.Mimic("left", multiplier=-0.5, offset=0.01),
            ),
            jtik.Joint("tool", JointType.FIXED, "finger", "tip", origin=shifted(0.03)),
        ],
        name="gripper",
        base="world",
        tip="tip",
        masses={"palm": Mass(2.0, [0.01, 0, 0])},
        shapes={
            "finger": [jtik.Capsule(np.zeros(3), np.array([0.03, 0, 0]), 0.01)],
            "palm": [jtik.Sphere([0, 0, 0], 0.05)],
        },
    )


ROBOTS = {
    "planar": lambda: planar(5),
    "dh": lambda: dh_arm(7),
    "ball": ball_arm,
    "floating": floating_arm,
    "gripper": gripper,
    "panda": lambda: jtik.Robot.builtin("panda"),
    "vehicle": lambda: jtik.Robot.builtin("vehicle_panda"),
}


@pytest.mark.quick(3)
@pytest.mark.parametrize("name", ROBOTS)
def test_every_frame_is_a_body_at_the_same_pose_with_the_same_jacobian(name, rng):
    robot = ROBOTS[name]()
    model = to_mujoco(robot)
    correspondence, data = MujocoCorrespondence(robot, model), mujoco.MjData(model)
    for _ in range(3):
        q = robot.random_configuration(rng)
        data.qpos[:] = correspondence.qpos(q)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        for frame in robot.frame_names:
            body = data.body(frame)
            pose = robot.pose(q, frame)
            assert pose[:3, 3] == pytest.approx(body.xpos, abs=POSES)
            assert pose[:3, :3] == pytest.approx(body.xmat.reshape(3, 3), abs=POSES)
            J = np.zeros((6, model.nv))
            mujoco.mj_jacBody(model, data, J[:3], J[3:], body.id)
            assert J @ correspondence.moves == pytest.approx(robot.jacobian(q, frame), abs=POSES)


@pytest.mark.parametrize("name", ROBOTS)
def test_numbers_are_converted_both_ways(name, rng):
    robot = ROBOTS[name]()
    model = to_mujoco(robot)
    correspondence = MujocoCorrespondence(robot, model)
    q, v = robot.random_configuration(rng), rng.standard_normal(robot.n)
    assert correspondence.q(correspondence.qpos(q)) == pytest.approx(q, abs=0)
    assert correspondence.velocity(correspondence.moves @ v) == pytest.approx(v, abs=0)
    moved = correspondence.qpos(q)
    mujoco.mj_integratePos(model, moved, correspondence.moves @ v, 1.0)
    assert moved == pytest.approx(correspondence.qpos(robot.integrate(q, v)), abs=POSES)
    assert correspondence.follows @ correspondence.moves == pytest.approx(
        np.zeros((len(correspondence.follows), robot.n)), abs=0
    )


def test_a_model_without_joints_corresponds_to_a_robot_without():
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body name='post'><geom size='.1'/></body></worldbody></mujoco>"
    )
    correspondence = MujocoCorrespondence(jtik.Robot.from_mujoco(model), model)
    assert correspondence.qpos(np.zeros(0)).shape == (0,)
    assert correspondence.moves.shape == correspondence.follows.shape == (0, 0)


def test_limits_masses_and_solids_are_kept():
    model = to_mujoco(gripper(), obstacles=[jtik.Sphere([1, 0, 1], 0.2), jtik.Circle([0, 2], 0.1)])
    assert model.joint("turn").range == pytest.approx([-1, 2])
    assert model.joint("outer").range[1] == 1
    assert model.joint("left").limited == 1
    assert model.body("palm").mass == pytest.approx(2.0)
    assert model.body("palm").ipos == pytest.approx([0.01, 0, 0])
    assert model.body("finger").mass < 1e-6
    assert model.geom("finger solid0").size[:2] == pytest.approx([0.01, 0.015])
    assert model.geom("obstacle0").size[0] == 0.2
    assert [model.body(f"obstacle{i}").mocapid >= 0 for i in (0, 1)] == [True, True]
    assert model.neq == 1
    assert len(MujocoCorrespondence(gripper(), model).follows) == 1


def test_the_model_a_robot_was_read_from_corresponds_too(rng):
    """Also for joints without names, and for a subset, whose other joints keep their positions."""
    xml = """<mujoco><worldbody><body name="a"><joint axis="0 0 1"/><joint name="up" type="slide" axis="0 0 1"/>
      <geom size=".1"/><body name="b" pos="1 0 0"><joint name="elbow" axis="0 1 0" ref="0.3"/><geom size=".1"/></body>
      </body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    robot = jtik.Robot.from_mujoco(model)
    q = rng.uniform(-1, 1, 3)
    assert MujocoCorrespondence(robot, model).qpos(q) == pytest.approx(q, abs=0)
    part = robot.subset(["elbow"])
    assert MujocoCorrespondence(part, model, rest=q).qpos(np.array([0.7])) == pytest.approx([*q[:2], 0.7], abs=0)


class TestWrongInput:
    def test_a_model_of_another_robot(self):
        with pytest.raises(jtik.ArgumentError, match="joint 'joint1'"):
            MujocoCorrespondence(planar(3), to_mujoco(gripper()))

    def test_a_free_joint_in_the_middle(self):
        robot = jtik.Robot(
            [
                jtik.Joint("mast", JointType.REVOLUTE, "base", "top"),
                jtik.Joint("float", JointType.FREE, "top", "kite"),
            ]
        )
        with pytest.raises(jtik.ArgumentError, match="free joint 'float' on 'top'"):
            to_mujoco(robot)

    def test_a_frame_called_world(self):
        robot = jtik.Robot([jtik.Joint("j", JointType.REVOLUTE, "base", "world")])
        with pytest.raises(jtik.ArgumentError, match="for the base only"):
            to_mujoco(robot)


def test_a_half_space_is_a_plane_with_its_normal():
    wall = jtik.HalfSpace([0.5, 1.0, 2.0], [1.0, 2.0, -0.5])
    model = to_mujoco(gripper(), obstacles=[wall])
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    (plane,) = np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE)
    assert data.geom_xmat[plane].reshape(3, 3)[:, 2] == pytest.approx(wall.normal, abs=1e-12)
    assert (data.geom_xpos[plane] - wall.point) @ wall.normal == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(
    "obstacle", [jtik.Box.at((0, 0), (1, 1)), jtik.Capsule((0, 0), (1, 0), 0.1), jtik.HalfSpace((0, 0), (0, 1))]
)
def test_obstacles_of_the_plane_other_than_circles_are_no_geoms(obstacle):
    with pytest.raises(jtik.ArgumentError, match="in space"):
        to_mujoco(gripper(), obstacles=[obstacle])

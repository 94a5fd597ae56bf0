"""Tools and bases: the same robot with one more frame; masses, shapes and keyframes stay."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jtik
from jtik import Robot, Sphere
from jtik.robot import Mass

EXACT = 1e-12


def pose(*rotvec, at=(0.1, -0.2, 0.3)):
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.from_rotvec(rotvec).as_matrix(), at
    return T


T = pose(0.3, -0.4, 0.5)
PANDA = Robot.builtin("panda")


@pytest.mark.parametrize("robot", [PANDA, PANDA.subset(["panda_joint2", "panda_joint4"], at=PANDA.home)])
def test_a_tool_is_the_tip_at_its_pose(robot):
    tooled = robot.with_tool(T, mass=1.5, shapes=[Sphere((0, 0, 0), 0.1)])
    q = robot.random_configuration(1)
    assert (tooled.tip, tooled.joint_names, tooled.nq) == ("tool", robot.joint_names, robot.nq)
    assert tooled.pose(q) == pytest.approx(robot.pose(q) @ T, abs=EXACT)
    assert tooled.masses["tool"].mass == 1.5
    assert len(tooled.shapes["tool"]) == 1
    assert set(tooled.masses) == {*robot.masses, "tool"}
    assert set(tooled.shapes) == {*robot.shapes, "tool"}
    assert tooled.keyframes.keys() == robot.keyframes.keys()
    assert np.array_equal(tooled.home, robot.home)
    assert (tooled.full is tooled) == (robot.full is robot)
    again = pickle.loads(pickle.dumps(tooled))
    assert np.array_equal(again.pose(q), tooled.pose(q))


def test_a_tool_goes_on_any_frame_with_any_name_and_tools_follow_each_other():
    robot = PANDA.with_tool(T, name="gripper", frame="panda_link4").with_tool(T, mass=Mass(2.0, np.array([0, 0, 0.1])))
    q = PANDA.home
    assert robot.pose(q, "gripper") == pytest.approx(PANDA.pose(q, "panda_link4") @ T, abs=EXACT)
    assert robot.pose(q) == pytest.approx(robot.pose(q, "gripper") @ T, abs=EXACT)
    assert robot.masses["tool"].center.tolist() == [0, 0, 0.1]
    seven = [0.1, -0.2, 0.3, *np.roll(Rotation.from_rotvec([0.3, -0.4, 0.5]).as_quat(), 1)]
    assert PANDA.with_tool(seven).pose(q) == pytest.approx(PANDA.pose(q) @ T, abs=EXACT)


@pytest.mark.parametrize("robot", [PANDA, PANDA.subset(["panda_joint2", "panda_joint4"], at=PANDA.home)])
def test_a_base_carries_everything(robot):
    based = robot.with_base(T)
    q = robot.random_configuration(2)
    assert (based.base, based.tip, based.joint_names) == ("world", robot.tip, robot.joint_names)
    for frame in robot.frame_names:
        assert based.pose(q, frame) == pytest.approx(T @ robot.pose(q, frame), abs=EXACT)
    assert based.keyframes.keys() == robot.keyframes.keys()
    assert based.shapes.keys() == robot.shapes.keys()
    if robot.masses:
        moved = T @ [*robot.center_of_mass(q), 1.0]
        assert based.center_of_mass(q) == pytest.approx(moved[:3], abs=EXACT)
    ik = jtik.InverseKinematics(based, jtik.FrameTask())
    assert ik.solve(based.position(q), q0=robot.home).converged
    assert based.with_base(T).base == "world (2)"


def test_a_planar_robot_stays_in_its_plane():
    flat = pose(0, 0, 0.4, at=(1.0, 2.0, 0.0))
    robot = Robot.planar(3).with_base(flat).with_tool(pose(0, 0, 0, at=(0.5, 0, 0)))
    assert robot.position([0.0, 0.0, 0.0]) == pytest.approx([1 + 3.5 * np.cos(0.4), 2 + 3.5 * np.sin(0.4)])
    with pytest.raises(jtik.ArgumentError, match="planar"):
        Robot.planar(3).with_base(T)


@pytest.mark.parametrize(
    ("call", "complaint"),
    [
        (lambda: PANDA.with_tool("x"), "pose: given x; accepted: a pose"),
        (lambda: PANDA.with_base(None), "pose: given None; accepted: a pose"),
        (lambda: PANDA.with_base(2 * np.eye(4)), "pose: given"),
        (lambda: PANDA.with_tool(T, name="panda_link4"), "name: given panda_link4; accepted: a name of its own"),
        (lambda: PANDA.with_tool(T, mass=-1.0), "mass: given -1"),
        (lambda: PANDA.with_tool(T, shapes=["x"]), "shapes"),
    ],
)
def test_what_cannot_be_used_is_refused(call, complaint):
    with pytest.raises(jtik.ArgumentError, match=complaint):
        call()
    with pytest.raises(jtik.UnknownNameError, match="did you mean 'panda_link4'"):
        PANDA.with_tool(T, frame="panda_lnk4")


def test_a_urdf_on_a_planar_base():
    joint = '<joint name="a" type="continuous"><parent link="car"/><child link="arm"/><origin xyz="0.5 0 0"/></joint>'
    text = f'<robot name="r"><link name="car"/><link name="arm"/>{joint}</robot>'
    robot = Robot.from_urdf(text, planar_base=True)
    assert robot.joint_names == ("planar_base_x", "planar_base_y", "planar_base_heading", "a")
    assert robot.base == "world"
    q = [1.0, 2.0, 0.3, 0.7]
    expected = pose(0, 0, 0.3, at=(1.0, 2.0, 0.0)) @ Robot.from_urdf(text).pose([0.7])
    assert robot.pose(q) == pytest.approx(expected, abs=EXACT)
    with pytest.raises(jtik.ArgumentError, match="planar_base: given True together with free_base=True"):
        Robot.from_urdf(text, planar_base=True, free_base=True)


@pytest.mark.parametrize("name", ["panda", "ur5e"])
@pytest.mark.parametrize("tool", ["tool", "tip"])
def test_with_a_tool_tip_means_the_tool_on_built_in_arms_too(name, tool):
    arm = Robot.builtin(name)
    robot = arm.with_tool((0, 0, 0.1, 1, 0, 0, 0), name=tool)
    q = arm.random_configuration(3)
    assert robot.pose(q, "tip") == pytest.approx(robot.pose(q))
    assert robot.pose(q, "flange") == pytest.approx(arm.pose(q))
    assert robot.pose(q)[:3, 3] == pytest.approx(arm.pose(q)[:3, 3] + 0.1 * arm.pose(q)[:3, 2])
    again = robot.with_tool((0, 0, 0.1, 1, 0, 0, 0), name="second")
    assert again.pose(q, "tip")[:3, 3] == pytest.approx(arm.pose(q)[:3, 3] + 0.2 * arm.pose(q)[:3, 2])


def test_tools_and_bases_of_a_subset_of_a_subset():
    arm, mount = Robot.builtin("panda"), np.eye(4)
    mount[:3, 3] = 0.1, 0.2, 0.3
    part = arm.subset(arm.joint_names[:6]).subset(arm.joint_names[:5])
    q = part.random_configuration(1)
    assert part.with_tool(mount).pose(q) == pytest.approx(part.pose(q) @ mount)
    assert part.with_base(mount).pose(q) == pytest.approx(mount @ part.pose(q))

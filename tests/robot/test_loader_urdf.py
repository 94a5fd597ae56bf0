"""URDF descriptions: the robot has what the file states. The kinematics of full robots is tested in tests/cross."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jtik
from jtik import JointType, Robot

EXACT = 1e-12
"""Rounding of some dozens of operations on numbers of order one."""


def joint(name, kind, parent, child, inside=""):
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{inside}</joint>'


def urdf(*joints, links="", name="arm"):
    """A URDF of these joints and of the links base, a, b, c ..., as many as there are joints."""
    names = ["base", *"abcdefgh"[: len(joints)]]
    bare = "".join(f'<link name="{link}"/>' for link in names if f'name="{link}"' not in links)
    return f'<robot name="{name}">{bare}{links}{"".join(joints)}</robot>'


LIMIT = '<limit lower="-1" upper="2" velocity="3" effort="5"/>'
SKEW = '<origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/><axis xyz="1 2 2"/>'
ONE = joint("one", "revolute", "base", "a", SKEW + LIMIT)


def skew(angle):
    T = np.eye(4)
    T[:3, :3] = (
        Rotation.from_euler("xyz", [0.4, 0.5, 0.6]) * Rotation.from_rotvec(angle * np.array([1, 2, 2]) / 3)
    ).as_matrix()
    T[:3, 3] = 0.1, 0.2, 0.3
    return T


def test_a_joint_has_its_origin_axis_and_limits():
    robot = Robot.from_urdf(urdf(ONE))
    assert (robot.name, robot.base, robot.frame_names, robot.tip) == ("arm", "base", ("base", "a"), "a")
    assert robot.joint_names == ("one",)
    assert (robot.lower[0], robot.upper[0], robot.velocity_limit[0]) == (-1.0, 2.0, 3.0)
    assert robot.pose([0.7], "a") == pytest.approx(skew(0.7), abs=EXACT)


def test_fixed_links_are_frames_and_fixed_joints_keep_their_names():
    robot = Robot.from_urdf(urdf(ONE, joint("weld", "fixed", "a", "b", '<origin xyz="0 0 1"/>')))
    assert [joint.name for joint in robot.joints] == ["one", "weld"]
    assert robot.joints[1].type is JointType.FIXED
    assert robot.frame_names == ("base", "a", "b")


@pytest.mark.parametrize(
    ("kind", "limit", "bounds"),
    [
        ("revolute", LIMIT, (-1.0, 2.0, 3.0)),
        ("prismatic", '<limit upper="0.5" velocity="0.1"/>', (0.0, 0.5, 0.1)),
        ("revolute", '<limit lower="0.5" upper="0.5" velocity="inf"/>', (0.5, 0.5, math.inf)),
        ("revolute", '<limit lower="-inf" upper="1"/>', (-math.inf, 1.0, math.inf)),
        ("continuous", LIMIT, (-math.inf, math.inf, 3.0)),
        ("continuous", "", (-math.inf, math.inf, math.inf)),
        ("revolute", '<limit lower="0" upper="0" effort="0" velocity="0"/>', (-math.inf, math.inf, math.inf)),
        ("revolute", '<limit lower="0" upper="0" effort="7" velocity="2"/>', (0.0, 0.0, 2.0)),
        ("revolute", '<limit effort="7" velocity="2"/>', (-math.inf, math.inf, 2.0)),
        ("revolute", "", (-math.inf, math.inf, math.inf)),
    ],
)
def test_limits_are_read_and_zeros_without_an_effort_count_as_none(kind, limit, bounds):
    robot = Robot.from_urdf(urdf(joint("one", kind, "base", "a", limit)))
    assert (robot.lower[0], robot.upper[0], robot.velocity_limit[0]) == bounds


def test_mimic_joints_follow_the_first_leader_within_the_limits_of_all():
    text = urdf(
        joint("two", "revolute", "a", "b", LIMIT + '<mimic joint="one" multiplier="-2" offset="0.1"/>'),
        joint("three", "prismatic", "b", "c", LIMIT + '<mimic joint="two" multiplier="0.5"/>'),
        joint("stuck", "revolute", "c", "d", SKEW + '<mimic joint="one" multiplier="0" offset="0.3"/>'),
        ONE,
    )
    with pytest.warns(UserWarning, match="joint 'one' moves from -0.95 to 0.55, not -1 to 2: 'two' would leave its"):
        robot = Robot.from_urdf(text)
    assert robot.joint_names == ("one",)
    assert (robot.lower[0], robot.upper[0], robot.velocity_limit[0]) == pytest.approx((-0.95, 0.55, 1.5), abs=EXACT)
    joints = {joint.name: joint for joint in robot.joints}
    assert joints["two"].mimic == jtik.robot.Mimic("one", -2.0, 0.1)
    assert joints["three"].mimic == jtik.robot.Mimic("one", -1.0, 0.05)
    assert joints["stuck"].type is JointType.FIXED
    assert joints["stuck"].origin == pytest.approx(skew(0.3), abs=EXACT)


def test_a_mimic_joint_whose_leader_does_not_exist_stays_independent_with_a_warning():
    text = urdf(ONE, joint("two", "revolute", "a", "b", LIMIT + '<mimic joint="won"/>'))
    with pytest.warns(UserWarning, match="joint 'two' stays independent: it mimics 'won', which is not a revolute"):
        robot = Robot.from_urdf(text)
    assert robot.joint_names == ("one", "two")


def test_a_joint_that_mimics_itself_stays_independent_with_a_warning():
    text = urdf(joint("one", "revolute", "base", "a", LIMIT + '<mimic joint="one"/>'))
    with pytest.warns(UserWarning, match="joint 'one' does not follow 'one': it follows another joint already, or"):
        assert Robot.from_urdf(text).joint_names == ("one",)


def test_floating_joints_are_free_from_their_origin_anywhere_in_the_tree():
    robot = Robot.from_urdf(urdf(ONE, joint("loose", "floating", "a", "b", SKEW)))
    assert (robot.nq, robot.n) == (8, 7)
    q = np.array([0.2, 0.1, -0.2, 0.3, 0.5, 0.5, -0.5, 0.5])
    moved = np.eye(4)
    moved[:3, :3], moved[:3, 3] = Rotation.from_quat([0.5, -0.5, 0.5, 0.5]).as_matrix(), q[1:4]
    assert robot.pose(q, "b") == pytest.approx(skew(0.2) @ skew(0.0) @ moved, abs=EXACT)


def test_a_planar_joint_is_two_prismatic_joints_and_a_revolute_one():
    robot = Robot.from_urdf(urdf(joint("plane", "planar", "base", "a", '<axis xyz="0 0 1"/>')))
    assert robot.joint_names == ("plane_TX", "plane_TY", "plane_RZ")
    T = robot.pose([1.0, 2.0, 0.3], "a")
    assert T[:3, 3] == pytest.approx([1.0, 2.0, 0.0], abs=EXACT)
    assert T[:3, :3] == pytest.approx(Rotation.from_rotvec([0, 0, 0.3]).as_matrix(), abs=EXACT)


def test_a_free_base_carries_the_root_link():
    robot = Robot.from_urdf(urdf(ONE), free_base=True)
    assert robot.joint_names == ("free_base", "one")
    assert robot.frame_names == ("world", "base", "a")
    assert (robot.nq, robot.n) == (8, 7)
    assert robot.pose([1, 2, 3, 1, 0, 0, 0, 0.7], "a")[:3, 3] == pytest.approx([1.1, 2.2, 3.3], abs=EXACT)


def test_a_root_called_world_is_the_base_like_any_other():
    text = urdf(ONE).replace('"base"', '"world"')
    assert Robot.from_urdf(text).frame_names == ("world", "a")
    assert Robot.from_urdf(text, free_base=True).frame_names == ("world (2)", "world", "a")


def test_a_robot_that_cannot_move_loads_and_moves_on_a_free_base():
    text = urdf(joint("weld", "fixed", "base", "a", '<origin xyz="0 0 1"/>'))
    still = Robot.from_urdf(text)
    assert (still.n, still.nq, still.tip) == (0, 0, "a")
    assert still.pose([], "a")[:3, 3].tolist() == [0.0, 0.0, 1.0]
    assert still.jacobian([], "a").shape == (6, 0)
    assert Robot.from_urdf(text, free_base=True).n == 6
    lone = Robot.from_urdf('<robot name="r"><link name="body"/></robot>')
    assert (lone.frame_names, lone.tip) == (("body",), "body")
    with pytest.raises(jtik.ArgumentError, match="none of which moves"):
        still.subset([])


def inertial(mass, xyz="0 0 0", moments='ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"'):
    return f'<inertial><origin xyz="{xyz}"/><mass value="{mass}"/><inertia {moments}/></inertial>'


@pytest.mark.filterwarnings("ignore:.*link 'a' has an inertia with a negative principal moment")
@pytest.mark.parametrize("moments", ['ixx="1" iyy="1" izz="1"', 'ixx="-1" iyy="0" izz="0"', 'ixx="1" iyy="1" izz="9"'])
def test_masses_are_kept_whatever_the_inertia(moments):
    rest = f'{moments} ixy="0" ixz="0" iyz="0"'
    links = f'<link name="base">{inertial(4)}</link><link name="a">{inertial(2.5, "0.1 0.2 0.3", rest)}</link>'
    robot = Robot.from_urdf(urdf(ONE, links=links))
    assert {frame: mass.mass for frame, mass in robot.masses.items()} == {"base": 4.0, "a": 2.5}
    assert robot.masses["a"].center == pytest.approx([0.1, 0.2, 0.3], abs=EXACT)


def test_links_without_inertia_have_no_mass_even_with_geometry():
    links = '<link name="a"><collision><geometry><sphere radius="1"/></geometry></collision></link>'
    assert not Robot.from_urdf(urdf(ONE, links=links)).masses


@pytest.mark.parametrize(
    ("names", "tip"),
    [
        (["arm", "hand", "tool0", "finger"], "tool0"),
        (["arm", "left_tcp", "tool"], "left_tcp"),
        (["arm", "EE_link", "finger"], "EE_link"),
        (["arm", "stool", "committee"], "committee"),
    ],
)
def test_the_tip_has_the_name_of_a_tool_else_it_ends_the_longest_chain(names, tip):
    joints = [joint(f"j{k}", "revolute", ["base", *names][k], name, LIMIT) for k, name in enumerate(names)]
    links = "".join(f'<link name="{name}"/>' for name in ["base", *names])
    assert Robot.from_urdf(f'<robot name="r">{links}{"".join(joints)}</robot>').tip == tip


def test_coupled_fingers_are_not_the_tip():
    arm = [
        ONE,
        joint("flange", "fixed", "a", "b"),
        joint("left", "prismatic", "b", "c", LIMIT),
        joint("right", "prismatic", "b", "d", LIMIT + '<mimic joint="left"/>'),
    ]
    assert Robot.from_urdf(urdf(*arm)).tip == "b"
    assert Robot.from_urdf(urdf(*arm), tip="d").tip == "d"
    hand = [joint(name, "prismatic", "base", link, LIMIT) for name, link in (("left", "a"), ("right", "b"))]
    hand[1] = hand[1].replace("</joint>", '<mimic joint="left"/></joint>')
    assert Robot.from_urdf(urdf(*hand)).tip == "a"


def test_files_with_undeclared_prefixes_and_loose_comments_are_read(tmp_path):
    text = urdf(ONE).replace("</robot>", "<!-- a -- b --><xacro:include/></robot>")
    path = tmp_path / "arm.urdf"
    path.write_text('<?xml version="1.0" encoding="utf-8"?>\n' + text)
    assert Robot.from_urdf(path).n == Robot.from_urdf(text).n == Robot.from_urdf("\n" + path.read_text()).n == 1


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("<robot", "the URDF text given: line 1: not XML: unclosed token"),
        ("<html/>", "not URDF: its outermost element is <html>, where <robot> is accepted"),
        ("<mujoco/>", "not URDF: .*; an MJCF is read by Robot.from_mjcf"),
        ("<robot/>", "not a robot: it has no link"),
        ("no_such_file.urdf", r"no_such_file\.urdf: No such file or directory; accepted"),
        (urdf(joint("j", "helical", "base", "a")), "joint 'j': unknown type 'helical'; accepted: revolute, continuous"),
        (urdf(joint("j", "revolute", "base", "z")), "joint 'j': its child 'z' is not a link of the file"),
        (urdf('<joint name="j" type="fixed"><child link="a"/></joint>'), "joint 'j': its parent '' is not a link"),
        (urdf(ONE, joint("one", "fixed", "a", "b")), "joint 'one': the name of two joints"),
        (urdf(ONE, joint("", "fixed", "a", "b")), "a <joint>: it has no name"),
        (urdf(ONE, links='<link name="a"/><link name="a"/>'), "link 'a': the name of two links"),
        (urdf(ONE, joint("two", "fixed", "base", "a")), "link 'a': moved by the joints 'one' and 'two'"),
        (urdf(ONE, links='<link name="x"/>'), "not a tree: the links 'base', 'x' have no parent"),
        ('<robot><link name="a"/>' + joint("j", "fixed", "a", "a") + "</robot>", "not a tree: every link is a child"),
        (urdf(ONE, joint("two", "fixed", "a", "base")), "link 'a': not a tree: it is its own ancestor"),
        (urdf(ONE, joint("x", "fixed", "b", "c"), joint("y", "fixed", "c", "b")), "not a tree: it is its own ancestor"),
        (urdf(joint("j", "fixed", "base", "world"), links='<link name="world"/>').replace('<link name="a"/>', ""),
         "link 'world': only the root"),
        (urdf(joint("j", "revolute", "base", "a", '<limit lower="inf" upper="inf"/>')),
         "joint 'j': its limits are lower inf, upper inf; accepted: a range with numbers in it"),
        (urdf(joint("j", "revolute", "base", "a", '<limit lower="nan"/>')), "joint 'j': lower='nan' in <limit>"),
        (urdf(joint("j", "revolute", "base", "a", '<limit velocity="nan"/>')), "joint 'j': velocity='nan' in <limit>"),
        (urdf(joint("j", "revolute", "base", "a", '<limit lower="low"/>')), "joint 'j': lower='low' in <limit> is no"),
        (urdf(ONE, joint("j", "revolute", "a", "b", '<mimic joint="one" offset="inf"/>')), "joint 'j': offset='inf'"),
        (urdf(joint("j", "revolute", "base", "a", '<axis xyz="0 0 0"/>')), "MuJoCo refuses it: .*axis.*'j'"),
        (urdf(joint("j", "fixed", "base", "a", '<origin xyz="0 nan 0"/>')),
         "joint 'j': xyz='0 nan 0' in <origin>; accepted: three numbers"),
        (urdf(joint("j", "fixed", "base", "a", '<origin rpy="0 1"/>')), "joint 'j': rpy='0 1' in <origin>; accepted"),
    ],
)  # fmt: skip
def test_a_file_that_is_not_a_robot_is_refused_with_the_element(text, complaint):
    with pytest.raises(jtik.RobotFileError, match=complaint):
        Robot.from_urdf(text)


def test_an_error_names_the_file_and_keeps_its_parts(tmp_path):
    path = tmp_path / "bad.urdf"
    path.write_text(urdf(joint("j", "helical", "base", "a")))
    with pytest.raises(jtik.RobotFileError) as caught:
        Robot.from_urdf(path)
    assert (caught.value.file, caught.value.element) == (str(path), "joint 'j'")
    assert str(caught.value).startswith(f"{path}: joint 'j': unknown type")
    assert isinstance(caught.value, ValueError)

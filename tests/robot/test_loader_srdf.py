"""SRDF beside a URDF: disabled collisions, states as keyframes, and files that are wrong."""

from __future__ import annotations

import numpy as np
import pytest

import jtik

URDF = """<robot name="r">
  <link name="base"/><link name="arm"/><link name="hand"/><link name="thumb"/><link name="finger"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="0.5" upper="2" velocity="1" effort="1"/></joint>
  <joint name="wrist" type="continuous"><parent link="arm"/><child link="hand"/><origin xyz="1 0 0"/></joint>
  <joint name="grip" type="prismatic"><parent link="hand"/><child link="finger"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.1" velocity="1" effort="1"/></joint>
  <joint name="follow" type="prismatic"><parent link="hand"/><child link="thumb"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.1" velocity="1" effort="1"/><mimic joint="grip"/></joint>
</robot>"""

SRDF = """<?xml version="1.0"?><robot name="r">
  <group name="arm"><joint name="shoulder"/><joint name="wrist"/></group>
  <group name="gripper"><joint name="grip"/></group>
  <group_state name="ready" group="arm">
    <joint name="wrist" value="0.3"/><joint name="shoulder" value="1"/></group_state>
  <group_state name="ready" group="gripper">
    <joint name="grip" value="0.05"/><joint name="follow" value="0.07"/></group_state>
  <group_state name="open" group="gripper"><joint name="grip" value="0.1"/></group_state>
  <disable_collisions link1="hand" link2="base" reason="Never"/>
  <disable_collisions link1="arm" link2="hand"/>
</robot>"""


def load(srdf, **options):
    return jtik.Robot.from_urdf(URDF, srdf=srdf, **options)


def srdf(*elements):
    return f'<robot name="r">{"".join(elements)}</robot>'


def disabled(first, second, extra=""):
    return f'<disable_collisions link1="{first}" link2="{second}" {extra}/>'


def state(name, extra="", **positions):
    joints = "".join(f'<joint name="{joint}" value="{value}"/>' for joint, value in positions.items())
    return f'<group_state name="{name}" {extra}>{joints}</group_state>'


class TestDisabledCollisions:
    def test_they_are_pairs_of_links_with_the_reason_written(self):
        assert load(SRDF).disabled_collisions == {("base", "hand"): "Never", ("arm", "hand"): ""}

    def test_without_a_file_there_are_none(self):
        assert jtik.Robot.from_urdf(URDF).disabled_collisions == {}

    def test_a_link_disabled_by_default_with_one_pair_enabled(self):
        robot = load(srdf('<disable_default_collisions link="hand"/>', '<enable_collisions link1="arm" link2="hand"/>'))
        expected = {("base", "hand"), ("hand", "thumb"), ("hand", "finger")}
        assert {frozenset(pair) for pair in robot.disabled_collisions} == {frozenset(pair) for pair in expected}
        assert set(robot.disabled_collisions.values()) == {"by default"}

    def test_the_path_of_a_file(self, tmp_path):
        (tmp_path / "r.srdf").write_text(SRDF)
        for path in (tmp_path / "r.srdf", str(tmp_path / "r.srdf")):
            assert len(load(path).disabled_collisions) == 2

    def test_links_that_the_robot_does_not_have_are_reported(self):
        with pytest.warns(UserWarning, match="names links that the robot does not have: foot, toe"):
            robot = load(srdf(disabled("arm", "hand"), disabled("foot", "toe"), disabled("arm", "toe")))
        assert list(robot.disabled_collisions) == [("arm", "hand")]
        assert "foot, toe" in robot.ignored[-1]

    def test_a_tool_and_a_base_keep_them(self):
        robot = load(SRDF).with_tool(np.eye(4)).with_base(np.eye(4))
        assert robot.disabled_collisions == load(SRDF).disabled_collisions


class TestStates:
    def test_they_are_keyframes_with_other_joints_at_neutral(self):
        robot = load(SRDF)
        assert set(robot.keyframes) == {"ready", "open"}
        assert robot.keyframes["ready"].tolist() == [1.0, 0.3, 0.05]
        assert robot.keyframes["open"].tolist() == [0.5, 0.0, 0.1]

    def test_two_states_of_one_name_that_contradict_have_two_names(self):
        robot = load(srdf(state("a", 'group="x"', wrist=1), state("a", 'group="y"', wrist=2, grip=0.1)))
        assert {name: q[1] for name, q in robot.keyframes.items()} == {"a": 1.0, "a (y)": 2.0}

    def test_a_group_is_not_needed(self):
        assert load(srdf(state("a", wrist=1))).keyframes["a"].tolist() == [0.5, 1.0, 0.0]

    def test_home_is_where_a_solve_starts(self):
        assert load(srdf(state("home", wrist=1))).home.tolist() == [0.5, 1.0, 0.0]

    def test_the_pose_of_a_free_base_has_its_quaternion_last(self):
        pose = "1 2 3 0 0 0.6 0.8"
        robot = load(srdf(state("standing", root_joint=pose, wrist=1)), free_base=True)
        assert robot.keyframes["standing"].tolist() == [1, 2, 3, 0.8, 0, 0, 0.6, 0.5, 1, 0]

    def test_joints_that_the_robot_does_not_have_are_reported(self):
        with pytest.warns(UserWarning, match="names joints that the robot does not have: root_joint, knee"):
            robot = load(srdf(state("a", root_joint="0 0 0 0 0 0 1", wrist=1, knee=1)))
        assert robot.keyframes["a"][1] == 1


WRONG = {
    "no name": ('<group_state group="arm"/>', r"group_state: it has no name"),
    "no value": (
        '<group_state name="a"><joint name="wrist"/></group_state>',
        r"group_state 'a': a <joint> without name or value",
    ),
    "no number": (state("a", wrist="much"), r"group_state 'a': joint 'wrist' has the value 'much'; accepted: finite"),
    "not finite": (state("a", wrist="nan"), r"group_state 'a': joint 'wrist' has the value 'nan'; accepted: finite"),
    "empty": (state("a", wrist=" "), r"group_state 'a': joint 'wrist' has the value ' '; accepted: finite"),
    "two numbers": (state("a", wrist="1 2"), r"group_state 'a': joint 'wrist' has 2 numbers, where 1 are accepted"),
    "one link": ('<disable_collisions link1="arm"/>', r"disable_collisions 'arm': it has no link2"),
    "the same link": (disabled("arm", "arm"), r"disable_collisions 'arm' 'arm': the link 'arm' twice"),
    "a default without link": ("<disable_default_collisions/>", r"disable_default_collisions: it has no link"),
    "another robot's": (disabled("foot", "toe"), r"the robot has none of its links and joints, such as 'foot'"),
    "a URDF": (URDF, r"not SRDF: it has links or joints of its own"),
    "an MJCF": ("<mujoco/>", r"not SRDF: its outermost element is <mujoco>"),
    "no XML": ("<robot", r"line 1: not XML"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_file_is_named_with_the_element(case, tmp_path):
    text, message = WRONG[case]
    path = tmp_path / "wrong.srdf"
    path.write_text(text if text.startswith(("<robot", "<mujoco")) else srdf(text))
    with pytest.raises(jtik.RobotFileError, match=message) as caught:
        load(path)
    assert caught.value.file == str(path)


def test_a_zero_quaternion_is_refused():
    with pytest.raises(jtik.RobotFileError, match="'base' has a zero quaternion|'root' has a zero quaternion"):
        load(srdf(state("a", root="0 0 0 0 0 0 0")), free_base=True)


def test_a_file_that_does_not_exist():
    with pytest.raises(jtik.RobotFileError, match="No such file.*or SRDF text"):
        load("/a folder/that is none.srdf")


def test_what_is_no_path_is_refused():
    with pytest.raises(jtik.ArgumentError, match="srdf: given 3; accepted: the path of a SRDF file, or SRDF text"):
        load(3)

"""Followers of a URDF stay within their own limits, and the tip of a linkage is not that of a hand."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik import Robot


def joint(name, kind, parent, child, limits=None, mimic=""):
    low, high = limits or (-3, 3)
    inside = f'<parent link="{parent}"/><child link="{child}"/><origin xyz="0.5 0 0"/><axis xyz="0 0 1"/>'
    inside += f'<limit lower="{low}" upper="{high}" effort="1" velocity="1"/>' if kind != "fixed" else ""
    return f'<joint name="{name}" type="{kind}">{inside}{mimic}</joint>'


def follows(leader, multiplier=1, offset=0):
    return f'<mimic joint="{leader}" multiplier="{multiplier}" offset="{offset}"/>'


def urdf(*joints):
    text = "".join(joints)
    names = dict.fromkeys(part.split('"')[0] for part in text.split(' link="')[1:])
    return f'<robot name="r">{"".join(f"<link name={name!r}/>" for name in names)}{text}</robot>'


class TestLimitsOfFollowers:
    @pytest.mark.parametrize(
        ("limits", "mimic", "expected"),
        [
            ((-0.5, 0.5), follows("a"), (-0.5, 0.5)),
            ((-0.5, 0.5), follows("a", -2), (-0.25, 0.25)),
            ((-0.5, 1.0), follows("a", -1), (-1.0, 0.5)),
            ((0.0, 1.0), follows("a", 2, 0.5), (-0.25, 0.25)),
        ],
    )
    def test_they_reduce_those_of_the_leader_with_a_warning(self, limits, mimic, expected):
        text = urdf(joint("a", "revolute", "base", "x"), joint("b", "revolute", "x", "y", limits, mimic))
        with pytest.warns(UserWarning, match=r"joint 'a' moves from .*, not -3 to 3: 'b' would leave its limits"):
            robot = Robot.from_urdf(text)
        assert (robot.lower[0], robot.upper[0]) == pytest.approx(expected)
        assert robot.ignored == ()
        ik = jtik.InverseKinematics(robot, jtik.FrameTask("y"))
        ratio, offset = (robot.joints[1].mimic.multiplier, robot.joints[1].mimic.offset)
        for seed in range(5):
            goal = np.random.default_rng(seed).uniform(-1, 1, 3)
            follower = ratio * ik.solve(goal).q[0] + offset
            assert limits[0] - 1e-9 <= follower <= limits[1] + 1e-9

    @pytest.mark.parametrize(("limits", "mimic"), [((0, 1), follows("a", -1)), ((2, 3), follows("a", 1))])
    def test_those_that_would_leave_no_range_are_dropped_and_listed(self, limits, mimic):
        text = urdf(joint("a", "revolute", "base", "x", (0, 1)), joint("b", "revolute", "x", "y", limits, mimic))
        with pytest.warns(UserWarning, match="joint 'b': its limits, .* are not kept: following 'a'"):
            robot = Robot.from_urdf(text)
        assert (robot.lower[0], robot.upper[0]) == (0.0, 1.0)
        assert len(robot.ignored) == 1

    def test_a_rounding_error_is_not_reported(self):
        text = urdf(
            joint("a", "revolute", "base", "x", (0, 0.8757)),
            joint("b", "revolute", "x", "y", (-0.87569999999, 0), follows("a", -1)),
        )
        assert Robot.from_urdf(text).upper[0] == pytest.approx(0.8757)


class TestTip:
    def test_a_palletiser_whose_wrist_follows_its_arm_ends_at_the_wrist(self):
        chain = [
            joint("turn", "revolute", "base", "column"),
            joint("swing", "revolute", "column", "arm"),
            joint("level", "revolute", "arm", "wrist", None, follows("swing", -1)),
        ]
        assert Robot.from_urdf(urdf(*chain)).tip == "wrist"
        rod = joint("rod", "revolute", "column", "rod", None, follows("swing"))
        wrist = joint("spin", "revolute", "wrist", "plate")
        assert Robot.from_urdf(urdf(*chain, rod, wrist)).tip == "plate"
        assert Robot.from_urdf(urdf(*chain, rod, joint("flange", "fixed", "wrist", "tool0"))).tip == "tool0"

    def test_a_telescope_below_an_arm_is_no_finger(self):
        robot = Robot.from_urdf(
            urdf(
                joint("lift", "prismatic", "base", "first"),
                joint("lift2", "prismatic", "first", "second", None, follows("lift")),
                joint("shoulder", "revolute", "second", "upper"),
                joint("elbow", "revolute", "upper", "lower"),
            )
        )
        assert robot.tip == "lower"

    @pytest.mark.parametrize(
        "name", ["tool0", "left_tcp", "ee_link", "end_effector", "hand", "left_hand_link", "gripper"]
    )
    def test_a_named_frame_is_taken_before_the_guess_about_fingers(self, name):
        fingers = [
            joint("left", "prismatic", name, "left_finger_tip"),
            joint("right", "prismatic", name, "right_finger_tip", None, follows("left")),
        ]
        arm = [joint("a", "revolute", "base", "x"), joint("b", "revolute", "x", "y"), joint("m", "fixed", "y", name)]
        assert Robot.from_urdf(urdf(*arm, joint("c", "fixed", "y", "hand_camera"), *fingers)).tip == name

    def test_tip_means_the_tip_on_any_robot(self):
        robot = Robot.from_urdf(urdf(joint("a", "revolute", "base", "x"), joint("b", "revolute", "x", "flange")))
        q = [0.3, -0.4]
        assert robot.frame("tip") == robot.frame(None) == "flange"
        assert np.array_equal(robot.pose(q, "tip"), robot.pose(q))
        for task in (jtik.FrameTask(), jtik.FrameTask("tip")):
            assert jtik.InverseKinematics(robot, task).solve(robot.position(q)).converged
        named = Robot.from_urdf(urdf(joint("a", "revolute", "base", "tip"), joint("b", "revolute", "tip", "hand")))
        assert (named.tip, named.frame("tip")) == ("hand", "tip")

    def test_an_unknown_frame_is_answered_with_the_tip_and_the_nearest_names(self):
        robot = Robot.from_urdf(urdf(joint("a", "revolute", "base", "link1"), joint("b", "revolute", "link1", "link2")))
        with pytest.raises(
            jtik.UnknownNameError, match="did you mean 'link2' or 'link1'.*; the tip is 'link2' [(]known"
        ):
            robot.pose([0, 0], "lnk2")

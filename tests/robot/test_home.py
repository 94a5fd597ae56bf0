"""The home configuration of a robot, and the neutral configuration that it comes from."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import jtik
from jtik import Joint, JointType, Robot
from jtik.robot import Mimic


def joint(name, kind, lower=-math.inf, upper=math.inf, mimic=None):
    return Joint(name, kind, "base", f"link {name}", lower=lower, upper=upper, mimic=mimic)


def alone(kind, lower, upper):
    return Robot([joint("only", kind, lower, upper)]).home.tolist()


class TestWithoutAKeyframe:
    @pytest.mark.parametrize(
        ("lower", "upper", "expected"),
        [
            (-2.0, 3.0, 0.0),  # far from both limits
            (-1.01, 4.0, 0.0),  # just farther than a fifth of the range
            (-0.99, 4.0, 1.505),
            (-4.0, 0.99, -1.505),
            (0.0, 3.0, 1.5),  # at a limit
            (-3.0, 0.0, -1.5),
            (1.0, 2.0, 1.5),  # clamped to a limit
            (0.3, 0.3, 0.3),
            (-0.1, 0.1, 0.0),
            (-math.inf, math.inf, 0.0),
        ],
    )
    def test_a_joint_near_a_limit_is_in_the_middle_of_its_range(self, lower, upper, expected):
        for kind in (JointType.REVOLUTE, JointType.PRISMATIC):
            width = 1.0 if kind is JointType.REVOLUTE else 0.3  # prismatic: a range below 2 m
            assert alone(kind, width * lower, width * upper) == pytest.approx([width * expected], abs=1e-15)

    def test_one_limit_or_a_long_range_counts_as_the_range_of_a_random_configuration(self):
        assert alone(JointType.REVOLUTE, 0.0, math.inf) == [math.pi]
        assert alone(JointType.REVOLUTE, -math.inf, 0.5) == [0.5 - math.pi]
        assert alone(JointType.REVOLUTE, -2.0, math.inf) == [0.0]
        assert alone(JointType.PRISMATIC, 0.0, math.inf) == [1.0]
        assert alone(JointType.PRISMATIC, -math.inf, 0.3) == [-0.7]
        assert alone(JointType.PRISMATIC, -0.5, math.inf) == [0.0]
        assert alone(JointType.PRISMATIC, 0.0, 1e300) == [1.0]
        for kind in (JointType.REVOLUTE, JointType.PRISMATIC):
            robot = Robot([joint("only", kind, 0.25)])
            drawn = [robot.random_configuration(seed)[0] for seed in range(200)]
            assert robot.home[0] == pytest.approx((min(drawn) + max(drawn)) / 2, rel=0.05)

    def test_a_straight_arm_without_limits_stays_straight(self):
        assert Robot.planar(4).home.tolist() == [0.0] * 4

    def test_quaternions_and_free_bases_stay_neutral(self):
        robot = Robot(
            [joint("float", JointType.FREE), joint("ball", JointType.BALL), joint("a", JointType.REVOLUTE, 0.0, 1.0)]
        )
        assert robot.home.tolist() == [*robot.neutral[:11], 0.5]

    def test_a_follower_narrows_the_range_of_its_leader(self):
        follower = joint("follower", JointType.REVOLUTE, 0.0, 1.0, mimic=Mimic("leader", multiplier=2.0))
        assert Robot([joint("leader", JointType.REVOLUTE, -1.0, 4.0), follower]).home.tolist() == [0.25]

    def test_it_is_read_only_and_computed_once(self):
        robot = Robot.planar(2, lower=0.0, upper=1.0)
        with pytest.raises(ValueError, match="read-only"):
            robot.home[0] = 1.0
        assert robot.home is robot.home
        with pytest.raises(AttributeError, match="home"):
            robot.home = robot.neutral

    def test_a_subset_has_that_of_its_joints(self):
        robot = Robot.planar(4, lower=[0, -1, 0, -1], upper=[2, 1, 1, 0])
        part = robot.subset(["joint2", "joint3", "joint4"])
        for same in (part, pickle.loads(pickle.dumps(part)), part.subset(["joint3"])):
            assert same.home.tolist() == same.reduced(same.full.home).tolist()
        assert part.home.tolist() == [0.0, 0.5, -0.5]


class TestTheKeyframe:
    def test_home_is_the_keyframe_of_that_name(self):
        panda = Robot.builtin("panda")
        assert panda.home is panda.keyframes["home"]
        part = panda.subset(["panda_joint2", "panda_joint6"])
        for same in (part, pickle.loads(pickle.dumps(part))):
            assert same.home.tolist() == panda.keyframes["home"][[1, 5]].tolist()

    def test_others_are_not(self):
        robot = Robot.planar(2, lower=0.0, upper=1.0)
        assert Robot(robot.joints, keyframes={"ready": [0.1, 0.2]}, planar=True).home.tolist() == [0.5, 0.5]


class TestTheNeutralConfiguration:
    LIMITED = Robot.planar(3, lower=-2.0, upper=2.0)

    @pytest.mark.parametrize("neutral", [[0.1, -0.2, 0.3], {"joint1": 0.1, "joint2": -0.2, "joint3": 0.3}])
    def test_it_can_be_given_in_any_form_of_a_configuration(self, neutral):
        robot = Robot(self.LIMITED.joints, neutral=neutral)
        assert robot.neutral.tolist() == robot.home.tolist() == [0.1, -0.2, 0.3]
        assert robot.configuration({"joint2": 1.0}).tolist() == [0.1, 1.0, 0.3]

    def test_it_is_clamped_to_the_limits(self):
        robot = Robot(self.LIMITED.joints, neutral=[3.0, -3.0, 0.3])
        assert robot.neutral.tolist() == [2.0, -2.0, 0.3]
        assert robot.home.tolist() == [0.0, 0.0, 0.3]

    def test_a_subset_is_locked_there_and_keeps_it(self):
        robot = Robot(self.LIMITED.joints, neutral=[0.4, -0.5, 0.6])
        part = robot.subset(["joint3", "joint1"])
        inner = part.subset(["joint3"])
        for same in (part, pickle.loads(pickle.dumps(part))):
            assert same.neutral.tolist() == [0.4, 0.6]
            assert same.full_configuration([1.0, 1.1]).tolist() == [1.0, -0.5, 1.1]
            assert same.pose(same.neutral) == pytest.approx(robot.pose(robot.neutral), abs=1e-14)
        assert inner.neutral.tolist() == [0.6]
        assert pickle.loads(pickle.dumps(robot)).neutral.tolist() == robot.neutral.tolist()

    @pytest.mark.parametrize("neutral", [[0.1], [0.1, np.nan, 0.2], {"joint1": [1.0, 2.0]}])
    def test_what_is_no_configuration_is_refused(self, neutral):
        with pytest.raises(jtik.ArgumentError, match="neutral"):
            Robot(self.LIMITED.joints, neutral=neutral)
        with pytest.raises(jtik.UnknownNameError, match="joint in neutral"):
            Robot(self.LIMITED.joints, neutral={"elbow": 1.0})

"""The forms in which a configuration is accepted, and the errors for others."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import jtik
from jtik.errors import ArgumentError, ImmutableError, UnknownNameError
from jtik.robot import Robot

from ..conftest import floating_arm

ARM = Robot.planar(5)
KEPT = ["joint2", "joint4"]
AT = np.array([0.1, 0.2, 0.3, 0.4, 0.5])
PART = ARM.subset(KEPT, at=AT)
FINGER = PART.subset(["joint4"], at=[0.7, 0.8])


class TestNumbers:
    def test_an_array_is_copied(self):
        q = np.array([1.0, 2.0])
        given = PART.configuration(q)
        assert given.tolist() == [1.0, 2.0]
        given[0] = 9.0
        assert q[0] == 1.0

    @pytest.mark.parametrize("q", [[1, 2], (1.0, 2.0), np.array([1, 2], dtype=np.float32), range(1, 3)])
    def test_anything_array_like(self, q):
        given = PART.configuration(q)
        assert given.tolist() == [1.0, 2.0]
        assert given.dtype == np.float64

    @pytest.mark.parametrize("value", [np.nan, np.inf])
    def test_not_finite(self, value):
        with pytest.raises(ArgumentError, match="^q0: given (nan|inf) at index 1; accepted: finite numbers"):
            PART.configuration(np.array([0.0, value]), argument="q0")

    def test_finite_numbers_whose_sum_overflows(self):
        q = np.full(2, 1.7e308)
        assert PART.configuration(q).tolist() == q.tolist()

    def test_a_wrong_length_of_a_robot_that_is_not_reduced(self):
        with pytest.raises(ArgumentError, match=r"^q: given shape \(3,\); accepted: finite numbers of shape \(5,\)$"):
            ARM.configuration([0.0] * 3)

    def test_a_ragged_list(self):
        for robot in (ARM, PART):
            with pytest.raises(ArgumentError, match="^q: given a ragged list; accepted: finite numbers of shape"):
                robot.configuration([[1.0], [1.0, 2.0]])


class TestOfTheFullRobot:
    def test_numbers_of_the_full_robot_are_reduced(self):
        assert PART.configuration([10, 11, 12, 13, 14]).tolist() == [11.0, 13.0]

    def test_a_subset_of_a_subset_accepts_all_lengths(self):
        assert FINGER.configuration([1.0]).tolist() == [1.0]
        assert FINGER.configuration([1.0, 2.0]).tolist() == [2.0]
        assert FINGER.configuration([10, 11, 12, 13, 14]).tolist() == [13.0]

    def test_a_wrong_length_names_both_lengths_and_ik_robot(self):
        accepted = "2 numbers for ik.robot, or 5 for the full robot, or a dict by joint name"
        with pytest.raises(ArgumentError, match=rf"^q0: given shape \(3,\); accepted: {accepted}$"):
            PART.configuration([0.0] * 3, argument="q0")
        with pytest.raises(ArgumentError, match=rf"^q: given shape \(1, 2\); accepted: {accepted}$"):
            PART.configuration([[0.0, 0.0]])
        with pytest.raises(ArgumentError, match="accepted: 1 number for ik.robot, or 2 or 5 for the full robot"):
            FINGER.configuration([0.0] * 3)

    def test_nan_in_the_full_robots_numbers_names_the_argument(self):
        with pytest.raises(ArgumentError, match="^q0: given nan at index 0"):
            PART.configuration([np.nan, 0, 0, 0, 0], argument="q0")

    def test_an_equal_length_is_not_ambiguous(self):
        same = ARM.subset(ARM.joint_names)
        assert same.full is ARM
        assert same.configuration(AT).tolist() == same.reduced(AT).tolist() == AT.tolist()

    def test_quaternions(self, mixed):
        part = mixed.subset(["shoulder", "elbow"])
        q = mixed.random_configuration(3)
        expected = np.concatenate([q[mixed.q_slice("shoulder")], q[mixed.q_slice("elbow")]])
        assert part.configuration(q).tolist() == expected.tolist()
        q[mixed.q_slice("shoulder")] = 0.0
        with pytest.raises(ArgumentError, match="^q: given a zero quaternion for joint 'shoulder'; accepted: quater"):
            part.configuration(q)

    @pytest.mark.parametrize("norm", [1e-200, 1e-3, 3.0, 1e200])
    def test_quaternions_of_any_norm_are_normalised(self, mixed, norm):
        q, where = mixed.random_configuration(3), mixed.q_slice("shoulder")
        scaled = q.copy()
        scaled[where] *= norm
        given = scaled.copy()
        for found in (mixed.configuration(scaled), mixed.configuration({"shoulder": scaled[where]})):
            assert found[where] == pytest.approx(q[where], abs=1e-15)
        assert scaled.tolist() == given.tolist()
        nearly = q * (1 + 1e-15)
        assert mixed.configuration(nearly).tolist() == nearly.tolist()

    def test_a_solve_without_a_step_returns_unit_quaternions(self, mixed):
        q, where = mixed.random_configuration(3), mixed.q_slice("shoulder")
        q[where] *= 3
        ik = jtik.InverseKinematics(mixed, jtik.FrameTask("tool", "pose"), joints="all", limits=False)
        solution = ik.solve(mixed.pose(q), q0=q)
        assert solution.iterations == 0
        assert np.linalg.norm(solution.q[where]) == pytest.approx(1, abs=1e-15)

    def test_every_method_with_numbers_accepts_them(self):
        q = np.array([10.0, 11, 12, 13, 14])
        own = [11.0, 13.0]
        for name in ("pose", "position", "jacobian", "tangent"):
            assert getattr(PART, name)(q).tolist() == getattr(PART, name)(own).tolist()
        assert PART.integrate(q, [0.5, 0.5]).tolist() == [11.5, 13.5]
        assert PART.difference(q, [0.0, 0.0]).tolist() == [-11.0, -13.0]


class TestByName:
    def test_joints_not_named_are_at_neutral(self, mixed):
        q = mixed.configuration({"boom": 0.3, "elbow": [0.5], "shoulder": [0, 1, 0, 0]})
        expected = mixed.neutral.copy()
        expected[mixed.q_slice("boom")] = 0.3
        expected[mixed.q_slice("elbow")] = 0.5
        expected[mixed.q_slice("shoulder")] = [0, 1, 0, 0]
        assert q.tolist() == expected.tolist()
        assert mixed.configuration({}).tolist() == mixed.neutral.tolist()

    def test_locked_joints_of_the_full_robot_are_ignored(self):
        assert PART.configuration({"joint1": 9.0, "joint4": 1.0}).tolist() == [0.0, 1.0]
        assert FINGER.configuration({"joint1": 9.0, "joint2": 8.0, "joint4": 1.0}).tolist() == [1.0]

    @pytest.mark.parametrize("robot", [ARM, PART, FINGER])
    def test_an_unknown_name_lists_the_known_ones(self, robot):
        with pytest.raises(UnknownNameError) as caught:
            robot.configuration({"joint6": 0.0}, argument="q0")
        known = "(known: joint1, joint2, joint3, joint4, joint5)"
        assert str(caught.value) == f"unknown joint in q0 'joint6'; did you mean 'joint5'? {known}"

    def test_a_joint_without_a_position_of_its_own_is_unknown(self, gripper):
        with pytest.raises(UnknownNameError, match=r"^unknown joint in q 'right' \(known: lift, left\)$"):
            gripper.configuration({"right": 0.0})

    def test_wrong_values_name_the_joint(self, mixed):
        with pytest.raises(ArgumentError, match=r"^q\['boom'\]: given shape \(2,\); accepted: .* shape \(1,\)$"):
            mixed.configuration({"boom": [0.0, 1.0]})
        with pytest.raises(ArgumentError, match=r"^q\['shoulder'\]: given shape \(3,\); accepted: .* shape \(4,\)$"):
            mixed.configuration({"shoulder": [0.0, 1.0, 0.0]})
        with pytest.raises(ArgumentError, match=r"^q\['elbow'\]: given nan; accepted: one finite number$"):
            mixed.configuration({"elbow": np.nan})
        with pytest.raises(ArgumentError, match="^q: given a zero quaternion for joint 'shoulder'"):
            mixed.configuration({"shoulder": [0.0] * 4})

    def test_kinematics_and_subset_and_keyframes_accept_it(self):
        assert ARM.pose({"joint1": 0.3}).tolist() == ARM.pose([0.3, 0, 0, 0, 0]).tolist()
        locked = ARM.subset(["joint1"], at={"joint2": 0.7})
        assert locked.position([0.0]) == pytest.approx(ARM.position([0, 0.7, 0, 0, 0]))
        named = Robot(ARM.joints, keyframes={"up": {"joint1": 1.5}})
        assert named.keyframes["up"].tolist() == [1.5, 0, 0, 0, 0]


class TestFullAndReduced:
    def test_a_robot_that_is_not_reduced_is_its_own_full_robot(self):
        assert ARM.full is ARM
        assert ARM.full_configuration(AT).tolist() == ARM.reduced(AT).tolist() == AT.tolist()

    def test_the_locked_joints_stay_where_they_are_locked(self):
        assert PART.full is ARM
        full = PART.full_configuration([1.0, 2.0])
        assert full.tolist() == [0.1, 1.0, 0.3, 2.0, 0.5]
        assert PART.pose([1.0, 2.0]) == pytest.approx(ARM.pose(full), abs=1e-14)

    def test_reduced_undoes_full_configuration(self, robot):
        for name in robot.joint_names:
            part = robot.subset([name], at=robot.random_configuration(1))
            own = part.random_configuration(2)
            assert part.reduced(part.full_configuration(own)).tolist() == own.tolist()

    def test_of_a_subset_of_a_subset_the_full_robot_is_the_one_it_was_made_from(self):
        assert FINGER.full is PART
        assert FINGER.full_configuration([3.0]).tolist() == [0.7, 3.0]
        assert PART.full_configuration(FINGER.full_configuration([3.0])).tolist() == [0.1, 0.7, 0.3, 3.0, 0.5]

    def test_reduced_accepts_numbers_of_the_full_robot_only(self):
        assert PART.reduced({"joint4": 2.0}).tolist() == [0.0, 2.0]
        with pytest.raises(ArgumentError, match=r"^q: given shape \(2,\); accepted: finite numbers of shape \(5,\)$"):
            PART.reduced([1.0, 2.0])

    def test_full_configuration_does_not_change_the_locked_one(self):
        PART.full_configuration([1.0, 2.0])[:] = 9.0
        assert PART.full_configuration([0.0, 0.0]).tolist() == [0.1, 0.0, 0.3, 0.0, 0.5]

    def test_full_is_read_only(self):
        with pytest.raises(ImmutableError, match="'full' cannot be changed; build a new one instead"):
            PART.full = ARM

    @pytest.mark.parametrize("again", [lambda robot: pickle.loads(pickle.dumps(robot)), copy.copy, copy.deepcopy])
    def test_a_copy_keeps_the_full_robot_and_the_locked_configuration(self, again):
        for robot in (PART, FINGER):
            other = again(robot)
            assert other.joint_names == robot.joint_names
            assert other.full.joint_names == robot.full.joint_names
            own = np.linspace(0.2, 0.4, robot.nq)
            assert other.full_configuration(own).tolist() == robot.full_configuration(own).tolist()
            assert other.pose(own).tolist() == robot.pose(own).tolist()

    def test_keyframes_of_a_subset_are_those_of_its_joints(self):
        panda = jtik.Robot.builtin("panda")
        part = panda.subset(["panda_joint2", "panda_joint6"])
        home = panda.keyframes["home"]
        assert part.keyframes["home"].tolist() == [home[1], home[5]]
        assert pickle.loads(pickle.dumps(part)).keyframes["home"].tolist() == [home[1], home[5]]


class TestJointValues:
    def test_a_number_is_that_of_all_entries(self):
        assert PART.joint_values(2, default=1.0).tolist() == [2.0, 2.0]

    def test_numbers_of_the_robot_and_of_those_it_was_made_from(self):
        assert FINGER.joint_values([7], default=1.0).tolist() == [7.0]
        assert FINGER.joint_values([6, 7], default=1.0).tolist() == [7.0]
        assert FINGER.joint_values([1, 2, 3, 4, 5], default=1.0).tolist() == [4.0]

    def test_names_leave_the_others_at_the_default(self):
        assert PART.joint_values({"joint4": 3, "joint1": 9}, default=[0.5, 0.6]).tolist() == [0.5, 3.0]
        assert PART.joint_values({"joint2": 3}, default=1.0).tolist() == [3.0, 1.0]

    def test_the_default_is_not_changed(self):
        default = np.array([0.5, 0.6])
        PART.joint_values({"joint2": 3}, default=default)
        assert default.tolist() == [0.5, 0.6]

    def test_a_quaternion_of_zeros_is_a_value_like_any_other(self):
        floating = floating_arm()
        assert floating.joint_values(np.zeros(floating.nq), default=1.0).tolist() == [0.0] * floating.nq

    def test_wrong_length(self):
        text = (
            r"^stiffness: given shape \(3,\); accepted: 1 number for ik.robot, or 2 or 5 for the full robot, "
            "one number for all of them, or a dict by joint name$"
        )
        with pytest.raises(ArgumentError, match=text):
            FINGER.joint_values([1, 2, 3], default=1.0, argument="stiffness")

    @pytest.mark.parametrize("values", [np.nan, [1.0, np.inf], [[1.0], [2.0, 3.0]], "high", None, {"joint2": np.nan}])
    def test_what_is_no_number(self, values):
        with pytest.raises(
            ArgumentError, match=r"^stiffness: given .*; accepted: 2 numbers for ik.robot, or 5|^stiffness\['"
        ):
            PART.joint_values(values, default=1.0, argument="stiffness")

    def test_unknown_joint(self):
        with pytest.raises(UnknownNameError, match="^unknown joint in stiffness 'elbow'"):
            PART.joint_values({"elbow": 1.0}, default=1.0, argument="stiffness")

    def test_a_ragged_value_of_a_joint(self):
        for read in (PART.configuration, lambda given: PART.joint_values(given, default=1.0)):
            with pytest.raises(ArgumentError, match=r"\['joint2'\]: given a ragged list"):
                read({"joint2": [1.0, [2.0]]})

    @pytest.mark.parametrize("default", [None, np.nan, "x", "12", [1.0], 1j, [[1.0], [2.0, 3.0]]])
    def test_a_default_that_is_no_number_for_each_entry(self, default):
        with pytest.raises(ArgumentError, match="^default: given"):
            PART.joint_values({"joint2": 1.0}, default=default)


class TestVelocityValues:
    def test_numbers_of_the_robot_and_of_those_it_was_made_from(self):
        assert FINGER.velocity_values([7], default=1.0).tolist() == [7.0]
        assert FINGER.velocity_values([6, 7], default=1.0).tolist() == [7.0]
        assert FINGER.velocity_values([1, 2, 3, 4, 5], default=1.0).tolist() == [4.0]

    def test_names_leave_the_others_at_the_default(self):
        default = np.array([0.5, 0.6])
        assert PART.velocity_values({"joint4": 3, "joint1": 9}, default=default).tolist() == [0.5, 3.0]
        assert default.tolist() == [0.5, 0.6]

    def test_a_joint_has_as_many_as_its_velocity(self):
        floating = floating_arm()
        found = floating.velocity_values({"float": [1, 2, 3, 4, 5, 6]}, default=0.0)
        assert found.tolist() == [1, 2, 3, 4, 5, 6, 0, 0, 0]
        assert floating.velocity_values({"float": 2}, default=0.0).tolist() == [2] * 6 + [0] * 3
        with pytest.raises(
            ArgumentError, match=r"^values\['float'\]: given shape \(7,\); accepted: finite numbers of shape \(6,\)"
        ):
            floating.velocity_values({"float": np.zeros(7)}, default=0.0)

    @pytest.mark.parametrize("values", [1.0, None, [1.0, 2.0, 3.0], "high", [1.0, np.inf]])
    def test_what_is_accepted(self, values):
        text = (
            r"^weights: given .*; accepted: 2 numbers for ik.robot, or 5 for the full robot, or a dict by joint name$"
        )
        with pytest.raises(ArgumentError, match=text):
            PART.velocity_values(values, default=1.0, argument="weights")

    def test_unknown_joint(self):
        with pytest.raises(UnknownNameError, match="^unknown joint in weights 'elbow'"):
            PART.velocity_values({"elbow": 1.0}, default=1.0, argument="weights")

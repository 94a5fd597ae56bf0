"""Coordinates in which all joints weigh the same, and how weights are read."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik.robot import UNWEIGHTED, WeightedCoordinates
from jtik.robot.joint_weights import LARGEST_RATIO, read_weights
from jtik.symbolic import numbers

from ..conftest import ball_arm, floating_arm, planar

W = np.array([8.0, 2.0, 18.0])
BY = WeightedCoordinates.of(W)
Z, G = casadi.SX([1.0, -2.0, 3.0]), casadi.SX([4.0, 0.5, -1.0])
J = casadi.SX(np.arange(6.0).reshape(2, 3) + 1)


def number(expression):
    return numbers(casadi.SX(expression)).squeeze()


class TestCoordinates:
    def test_their_square_is_weighted_relative_to_the_lightest_joint(self):
        dq = number(BY.to_joints(Z))
        assert np.sum(W / 2 * dq**2) == pytest.approx(1 + 4 + 9)
        assert (BY.scale <= 1).all()
        assert BY.weights == pytest.approx(W / 2)

    def test_there_and_back(self):
        assert number(BY.from_joints(BY.to_joints(Z))) == pytest.approx(number(Z))
        assert number(BY.gradient_by_joints(BY.gradient(G))) == pytest.approx(number(G))
        assert number(BY.jacobian_by_joints(BY.jacobian(J))) == pytest.approx(number(J))
        assert [BY.entry(j, 6.0) for j in range(3)] == pytest.approx([12.0, 6.0, 18.0])

    def test_derivatives_are_those_of_the_chain_rule(self):
        """J dq = (J by z) z, and a quadratic function keeps its value."""
        assert number(BY.jacobian(J) @ Z) == pytest.approx(number(J @ BY.to_joints(Z)))
        assert number(BY.gradient(G).T @ Z) == pytest.approx(number(G.T @ BY.to_joints(Z)))
        dq = BY.to_joints(Z)
        assert number(Z.T @ BY.hessian(J.T @ J) @ Z) == pytest.approx(number(dq.T @ J.T @ J @ dq))

    @pytest.mark.parametrize("weights", [None, np.ones(3), np.full(3, 7.3)])
    def test_equal_weights_change_no_expression(self, weights):
        by = WeightedCoordinates.of(weights)
        assert by.scale is None
        assert by.weights is None
        for change in (by.to_joints, by.from_joints, by.gradient, by.gradient_by_joints):
            assert change(Z) is Z
        for change in (by.jacobian, by.jacobian_by_joints, by.hessian):
            assert change(J) is J
        assert UNWEIGHTED.entry(0, 2.0) == 2.0


class TestRead:
    def test_none(self):
        assert read_weights(planar(3), None) is None

    def test_numbers_and_names(self):
        assert read_weights(planar(3), (1, 2, 3)).tolist() == [1, 2, 3]
        assert read_weights(planar(3), {"joint2": 5}).tolist() == [1, 5, 1]

    def test_what_comes_in_is_copied(self):
        given = np.array([1.0, 2.0, 3.0])
        found = read_weights(planar(3), given)
        given[:] = 9.0
        assert found.tolist() == [1, 2, 3]

    def test_one_weight_is_for_all_entries_of_a_joint(self):
        assert read_weights(ball_arm(), {"shoulder": 4.0, "lift": 9.0}).tolist() == [4, 4, 4, 1, 9, 1, 1, 1]
        assert read_weights(ball_arm(), {"wrist": [2, 3, 4]}).tolist() == [1, 1, 1, 1, 1, 2, 3, 4]
        assert read_weights(floating_arm(), {"float": 6.0}).tolist() == [6] * 6 + [1] * 3

    def test_numbers_of_the_robot_that_it_was_made_from(self):
        """The order is that of the full robot's velocity, where a ball joint has 3 entries and not 4."""
        part = ball_arm().subset(["lift", "wrist"])
        assert read_weights(part, np.arange(1.0, 9.0)).tolist() == [5, 6, 7, 8]
        assert read_weights(part, {"shoulder": 50.0, "lift": 2.0}).tolist() == [2, 1, 1, 1]
        assert read_weights(part.subset(["wrist"]), np.arange(1.0, 9.0)).tolist() == [6, 7, 8]
        assert read_weights(part.subset(["wrist"]), np.arange(1.0, 5.0)).tolist() == [2, 3, 4]

    @pytest.mark.parametrize(
        "weights",
        [
            3.0,
            True,
            "heavy",
            [1.0, 2.0],
            [1.0, 2.0, 3.0, 4.0],
            [1.0, 0.0, 1.0],
            [1.0, -1.0, 1.0],
            [1.0, np.nan, 1.0],
            [1.0, np.inf, 1.0],
            [[1.0, 2.0, 3.0]],
            ["a", "b", "c"],
            [True, True, True],
            np.array([True, True, True]),
            {"joint1": True},
            {"joint1": -2.0},
            {"joint1": 0.0},
            {"joint1": [1.0, 2.0]},
            {"joint1": "heavy"},
            {"joint1": None},
            {"joint1": np.inf},
        ],
    )
    def test_what_is_no_weight(self, weights):
        with pytest.raises(jtik.ArgumentError, match=r"^weights.*accepted: (?!.*one number for all)"):
            jtik.InverseKinematics(planar(3), jtik.FrameTask("tip", "position"), weights=weights)

    def test_a_joint_that_does_not_exist(self):
        with pytest.raises(jtik.UnknownNameError, match="joint in weights 'elbow'.*joint1"):
            jtik.InverseKinematics(planar(3), jtik.FrameTask("tip", "position"), weights={"elbow": 2.0})

    def test_weights_too_far_apart(self):
        assert read_weights(planar(2), [1.0, LARGEST_RATIO]) is not None
        with pytest.raises(jtik.ArgumentError, match="at most 1e\\+08 times the smallest; joints= leaves out"):
            read_weights(planar(2), [1.0, 1.1 * LARGEST_RATIO])

"""A result that explains itself."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import EXACT, dh_arm, planar, planar_jacobian, planar_points, shared_solver


def solve(robot, target, q0, kind="position", **options):
    criteria = options.pop("criteria", None)
    return shared_solver(robot, jtik.FrameTask("tip", kind), criteria=criteria).solve(target, q0=q0, **options)


@pytest.fixture(scope="module")
def solution():
    criteria = 2.0 * JointCentering() + 0.3 * ObstacleAvoidance(jtik.Point((2.0, 3.0)))
    return solve(planar(5), (2.5, 1.5), [0.6, 0.3, -0.2, 0.5, 0.4], criteria=criteria)


class TestFigures:
    def test_error_and_its_norms(self, solution):
        e = planar_points(solution.q)[-1] - (2.5, 1.5)
        assert solution.error == pytest.approx(e, abs=EXACT)
        assert solution.position_error == pytest.approx(np.linalg.norm(e), abs=EXACT)
        assert solution.orientation_error == 0

    def test_jacobian_and_condition(self, solution):
        J = planar_jacobian(solution.q)
        assert solution.jacobian == pytest.approx(J, abs=EXACT)
        assert solution.condition == pytest.approx(np.linalg.cond(J), rel=1e-10)

    def test_criteria_are_weighted_values_and_add_up(self, solution):
        springs = solution.q @ solution.q
        obstacle = -0.3 * np.log(np.linalg.norm(planar_points(solution.q) - (2, 3), axis=1)).sum()
        assert solution.criteria["joint_centering"] == pytest.approx(springs, rel=EXACT)
        assert solution.criteria["obstacle_avoidance"] == pytest.approx(obstacle, rel=1e-10)
        assert solution.cost == pytest.approx(springs + obstacle, rel=1e-10)

    def test_null_space_residual_is_what_the_task_leaves_of_the_gradient(self, solution):
        J, g = solution.jacobian, solution.gradient
        assert solution.null_space_residual == pytest.approx(np.linalg.norm(g - np.linalg.pinv(J) @ J @ g), abs=1e-9)
        assert solution.null_space_residual <= 1e-6 * max(1, np.linalg.norm(g))

    def test_seconds_are_wall_time(self, solution):
        assert 0 < solution.seconds < 10

    def test_it_cannot_change(self, solution):
        with pytest.raises(dataclasses.FrozenInstanceError):
            solution.q = None


class TestCondition:
    def test_is_infinite_at_a_singular_pose(self):
        assert solve(planar(3), (3.5, 0.0), [0.0] * 3).condition == np.inf

    def test_grows_towards_one(self):
        conditions = [
            solve(planar(2), planar_points(q)[-1], q).condition for q in ([0.3, 1.0], [0.3, 1e-2], [0.3, 1e-6])
        ]
        assert conditions == sorted(conditions)
        assert conditions[-1] > 1e6


class TestRepr:
    def test_says_what_happened_in_a_few_lines(self):
        text = repr(solve(planar(3), (1.0, 1.5), [0.3, 0.2, 0.4], criteria=JointCentering()))
        assert text.startswith("Solution: converged: on target")
        for word in (
            "q ",
            "error",
            " m",
            " rad",
            "iterations",
            "ms",
            "condition",
            "H ",
            "joint_centering",
            "null-space",
        ):
            assert word in text
        assert len(text.splitlines()) <= 8

    def test_leaves_out_what_is_not_there(self):
        text = repr(solve(planar(3), (1.0, 1.5), [0.3, 0.2, 0.4]))
        assert "H  " not in text
        assert "limit" not in text
        assert "escape" not in text

    def test_counts_iterations(self):
        solution = solve(planar(3), (1.0, 1.5), [0.3, 0.2, 0.4])
        assert re.search(rf"iterations +{solution.iterations} in", repr(solution))

    @pytest.mark.parametrize("n", [1, 2, 7, 40])
    def test_any_size_of_robot(self, n):
        q0 = np.full(n, 0.2)
        assert "converged" in repr(solve(planar(n), planar_points(q0)[-1], q0))

    def test_a_pose(self):
        robot = dh_arm(6, 1)
        q = np.full(6, 0.3)
        text = repr(solve(robot, robot.pose(q), q + 0.1, kind="pose"))
        assert "converged" in text


class TestTruth:
    def test_it_is_true_where_what_was_asked_for_was_achieved(self):
        ik = shared_solver(planar(3), jtik.FrameTask(), criteria=JointCentering())
        solved, failed = ik.solve((1.0, 1.5), q0=[0.3, 0.2, 0.4]), ik.solve((9.0, 0.0), q0=[0.3, 0.2, 0.4])
        assert bool(solved) is solved.converged is True
        assert bool(failed) is failed.converged is False


def test_look_is_the_old_name_of_inspect(solution):
    with pytest.warns(DeprecationWarning, match=r"^Solution\.look is deprecated: use inspect$"):
        assert solution.look is solution.inspect

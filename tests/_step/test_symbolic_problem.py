"""The symbolic problem: residual, criterion and distances against closed forms, derivatives against differences."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import DIFFERENCES, ball_arm, dh_arm, differences, floating_arm, planar, planar_jacobian, planar_points
from .conftest import problem_of

ROBOTS = {"planar": lambda: planar(4), "dh": dh_arm, "ball": ball_arm, "floating": floating_arm}
KP = np.array([[2.0, 0.3], [0.3, 1.0]])
SECOND = 1e-5
"""Differences of derivatives that are exact to rounding: truncation 1e-10 times fourth derivatives up to 1e5."""


@jtik.criterion
def reach(q, robot):
    """Squared distance of the tip from the base; for every robot."""
    p = robot.position(q, "tip")
    return p.T @ p


def column(function, *arguments):
    return np.array(function(*arguments)).ravel()


class TestRows:
    def test_the_residual_is_the_error_weighted_by_the_root_of_the_stiffness(self, rng):
        problem = problem_of(planar(3), jtik.FrameTask(stiffness=KP))
        q, target = rng.uniform(-1, 1, 3), np.array([1.0, 2.0])
        e = planar_points(q)[-1] - target
        assert problem.factor @ problem.factor.T == pytest.approx(KP)
        assert column(problem.error, q, target) == pytest.approx(e)
        r = column(problem.residual, q, target)
        assert r @ r == pytest.approx(e @ KP @ e)
        assert np.array(problem.error_jacobian(q, target)) == pytest.approx(planar_jacobian(q))
        assert np.array(problem.residual_jacobian(q, target)) == pytest.approx(problem.factor.T @ planar_jacobian(q))

    @pytest.mark.parametrize("name", ROBOTS)
    def test_the_jacobian_is_with_respect_to_the_velocity(self, name, rng):
        robot = ROBOTS[name]()
        problem = problem_of(robot, jtik.FrameTask(kind="pose"))
        target = problem.tasks.read_target(robot.pose(robot.random_configuration(rng)))
        q = robot.random_configuration(rng)
        found = np.array(problem.residual_jacobian(q, target))
        assert found == pytest.approx(
            differences(lambda at: column(problem.residual, at, target), robot, q), abs=DIFFERENCES
        )

    def test_levels_and_units_of_the_rows(self):
        tasks = [jtik.FrameTask("tip", "pose", priority=1), jtik.FrameTask("link1")]
        problem = problem_of(planar(3), tasks)
        assert (problem.m, problem.linear) == (5, (True, True, False, True, True))
        assert problem.levels == ((3, 4), (0, 1, 2))

    def test_joints_with_a_limit_have_both_indices(self):
        assert problem_of(ball_arm()).bounded == ((5, 4),)  # after the four numbers of the shoulder, and the elbow
        assert problem_of(planar(3)).bounded == ()


class TestCriterion:
    def test_it_is_the_weighted_sum_of_its_values(self, rng):
        problem = problem_of(planar(3), criteria=2.0 * JointCentering() + 0.5 * reach)
        q, parameters = rng.uniform(-1, 1, 3), problem.terms.parameters.memory
        expected = [2.0 * JointCentering()(q, planar(3)), 0.5 * np.sum(planar_points(q)[-1] ** 2)]
        assert column(problem.values, q, parameters) == pytest.approx(expected)
        assert float(problem.criterion(q, parameters)) == pytest.approx(sum(expected))
        assert problem.has_criterion
        assert not problem_of(planar(3)).has_criterion

    @pytest.mark.parametrize("name", ROBOTS)
    def test_the_report_has_the_gradient_with_respect_to_the_velocity(self, name, rng):
        robot = ROBOTS[name]()
        problem = problem_of(robot, criteria=reach)
        q, target, p = robot.random_configuration(rng), np.zeros(robot.dimension), problem.terms.parameters.memory
        error, J, values, gradient, residual, weighted = map(np.array, problem.report()(q, target, p))
        expected = differences(lambda at: [float(problem.criterion(at, p))], robot, q)
        assert gradient.ravel() == pytest.approx(expected.ravel(), abs=DIFFERENCES)
        assert error.ravel() == pytest.approx(robot.position(q))
        assert residual.tolist() == error.tolist()
        assert weighted.tolist() == J.tolist()
        assert values.item() == pytest.approx(np.sum(robot.position(q) ** 2))


class TestSecondDerivatives:
    @pytest.mark.parametrize("name", ROBOTS)
    def test_the_curvature_of_V_is_the_derivative_of_its_gradient_at_a_stationary_point(self, name, rng):
        """On the target dV/dv is zero, and its derivative along velocities is the Hessian."""
        robot = ROBOTS[name]()
        problem = problem_of(robot, criteria=reach)
        q, p = robot.random_configuration(rng), problem.terms.parameters.memory
        target = robot.position(q)
        size, first, second, gradient = map(np.array, problem.curvature()(q, target, p))

        def gradient_at(at):
            J = np.array(problem.residual_jacobian(at, target))
            return J.T @ column(problem.residual, at, target)

        assert first.ravel() == pytest.approx(0, abs=1e-12)
        assert second == pytest.approx(differences(gradient_at, robot, q), abs=SECOND)
        assert size.item() == pytest.approx(0, abs=1e-12)
        assert gradient.ravel() == pytest.approx(np.array(problem.report()(q, target, p)[3]).ravel())

    def test_the_hessian_is_that_of_the_lagrangian(self, rng):
        problem, robot = problem_of(planar(3), criteria=reach), planar(3)
        q, target, p, multipliers = (
            rng.uniform(-1, 1, 3),
            np.zeros(2),
            problem.terms.parameters.memory,
            np.array([2, 3]),
        )
        report = problem.report()

        def gradient_at(at):
            return np.array(report(at, target, p)[3]).ravel() + planar_jacobian(at).T @ multipliers

        found = np.array(problem.hessian()(q, target, p, multipliers))
        assert found == pytest.approx(differences(gradient_at, robot, q), abs=SECOND)


class TestClearances:
    field = ObstacleAvoidance([jtik.Circle((2.0, 1.0), 0.4), jtik.Circle((1.0, -1.0), 0.25)])

    def problem(self, **options):
        clearance = jtik.Clearance(self.field, safe=0.1, margin=0.05, influence=0.7, gain=0.8, **options)
        return problem_of(planar(2), clearances=[clearance])

    def test_distances_are_those_of_the_bodies_to_the_circles(self, rng):
        problem, q = self.problem(), rng.uniform(-1, 1, 2)
        centers, radii = np.array([[2.0, 1.0], [1.0, -1.0]]), np.array([0.4, 0.25])
        expected = np.linalg.norm(planar_points(q)[:, None] - centers, axis=2) - radii
        found = column(problem.measured.distances, q, problem.terms.parameters.memory)
        assert found == pytest.approx(expected.ravel())
        assert len(problem.measured.pairs) == 4
        assert all(pair.startswith("clearance: ") and " to obstacle " in pair for pair in problem.measured.pairs)

    def test_their_jacobian_and_figures(self, rng):
        problem, q = self.problem(), rng.uniform(-1, 1, 2)
        p = problem.terms.parameters.memory
        distance, J, figures = map(np.array, problem.measured.clearance(q, p))
        assert distance.ravel() == pytest.approx(column(problem.measured.distances, q, p))
        expected = differences(lambda at: column(problem.measured.distances, at, p), planar(2), q)
        assert pytest.approx(expected, abs=DIFFERENCES) == J
        for row, radius in zip(figures, [0.4, 0.25] * 2, strict=True):
            assert row == pytest.approx([0.1, 0.15, 0.7, 0.8, 0.1 + radius])

    @pytest.mark.parametrize("restore", [False, True])
    def test_each_distance_is_restored_as_its_clearance_is(self, restore):
        assert self.problem(restore=restore).measured.restored.tolist() == [restore] * 4


class TestNearJacobian:
    """The cheaper Jacobian of attempts that a restart replaces."""

    @pytest.mark.thinned
    @pytest.mark.parametrize("kind", ["position", "orientation", "pose"])
    @pytest.mark.parametrize("name", ["dh", "ball", "floating"])
    def test_it_has_the_same_gradient_and_is_the_jacobian_on_target(self, name, kind, rng):
        robot = ROBOTS[name]()
        task = jtik.FrameTask("tip", kind, stiffness=0.06 if kind == "orientation" else 2.0)
        problem = problem_of(robot, task)
        q, other = (robot.random_configuration(rng) for _ in range(2))
        for target, on_target in ((robot.pose(other), False), (robot.pose(q), True)):
            numbers = problem.tasks.read_target(target[:3, 3] if kind == "position" else target)
            near, J = (np.array(each(q, numbers)) for each in (problem.near_jacobian(), problem.residual_jacobian))
            r = column(problem.residual, q, numbers)
            assert near.T @ r == pytest.approx(J.T @ r, rel=1e-9, abs=1e-9)
            assert (np.abs(near - J).max() < 1e-7) == (on_target or kind == "position")

    def test_a_task_without_one_has_its_jacobian(self, rng):
        problem = problem_of(planar(3), jtik.FrameTask("tip", "pose"))
        q, target = rng.uniform(-1, 1, 3), np.array([1.0, 2.0, 0.3])
        assert np.array_equal(np.array(problem.near_jacobian()(q, target)), problem.residual_jacobian(q, target).full())

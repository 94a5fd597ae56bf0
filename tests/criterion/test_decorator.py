"""The decorator: a function of (q, robot) as a criterion."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik

from ..conftest import DIFFERENCES, EXACT, dh_arm, differences, planar, report_at, shared_solver
from .shared import STRATEGIES, at, link_height, solver


class TestDecorator:
    def test_a_three_line_function_is_a_criterion(self, rng):
        robot = planar(5)
        ik = solver(robot, link_height)
        q = robot.random_configuration(rng)
        expected = (robot.position(q, "link3")[1] - 0.5) ** 2
        found = at(ik, q)
        assert found.cost == pytest.approx(expected, rel=EXACT)
        assert found.gradient == pytest.approx(differences(lambda p: at(ik, p).cost, robot, q)[0], abs=DIFFERENCES)
        assert isinstance(link_height, jtik.Criterion)
        assert link_height.name == "link_height"
        assert link_height.__doc__.startswith("Squared distance of the third joint's y")

    @pytest.mark.quick(2)
    @pytest.mark.parametrize("strategy", STRATEGIES)
    def test_it_is_minimised_by_every_strategy(self, strategy):
        robot = planar(5)
        q0 = np.array([0.3, 0.4, -0.2, 0.5, 0.1])
        target = np.array([2.8, 1.6])
        without = shared_solver(robot, jtik.FrameTask(), strategy=strategy).solve(
            target, q0=q0, max_iterations=5000, position_tolerance=1e-4
        )
        solution = solver(robot, link_height, strategy).solve(
            target, q0=q0, max_iterations=5000, position_tolerance=1e-4, optimality_tolerance=1e-3
        )
        assert without.position_error <= 1e-4
        assert solution.position_error <= 1e-4
        assert robot.position(solution.q, "link3")[1] == pytest.approx(0.5, abs=5e-3)
        assert abs(robot.position(without.q, "link3")[1] - 0.5) > 0.02

    def test_numpy_functions_and_operators_can_be_traced(self, rng):
        @jtik.criterion
        def wavy(q, robot):
            return np.sin(q[0]) ** 2 + np.exp(-q[1]) + abs(q[2]) / 2 + casadi.sumsqr(robot.pose(q)[:3, 3])

        robot = dh_arm(4, 1)
        q = robot.random_configuration(rng)
        expected = np.sin(q[0]) ** 2 + np.exp(-q[1]) + abs(q[2]) / 2 + np.sum(robot.pose(q)[:3, 3] ** 2)
        assert report_at(solver(robot, wavy), q, robot.position(q)).cost == pytest.approx(expected, rel=1e-11)

    def test_a_constant_is_a_criterion_with_zero_gradient(self):
        @jtik.criterion
        def indifferent(q, robot):
            return 3.0

        found = at(solver(planar(3), indifferent), [0.1, 0.2, 0.3])
        assert found.cost == 3.0
        assert not found.gradient.any()

    def test_called_with_values_it_starts_from_them(self):
        robot, q = planar(4), np.array([0.3, 0.2, 0.1, 0.4])
        higher = link_height(height=2.0)
        assert at(solver(robot, higher), q).cost == pytest.approx((robot.position(q, "link3")[1] - 2) ** 2)
        assert solver(robot, link_height).parameters["link_height.height"] == 0.5
        assert "height=2.0" in repr(higher)
        with pytest.raises(jtik.UnknownNameError, match="width.*known: height"):
            link_height(width=1.0)

    @pytest.mark.parametrize(
        "invalid",
        [
            lambda q: q,
            lambda q, robot, extra: q,
            lambda q, robot, *, height: q,
            lambda q, robot, *more: q,
            lambda q, robot, **more: q,
            3,
        ],
    )
    def test_another_signature_is_refused(self, invalid):
        with pytest.raises(jtik.ArgumentError, match=r"f\(q, robot"):
            jtik.criterion(invalid)

"""Criteria in residual form, H = 1/2 |r|^2."""

from __future__ import annotations

import pickle
from functools import partial

import casadi
import numpy as np
import pytest

import jtik
from jtik.criterion import CriterionTerms, ResidualCriterion
from jtik.testing import check_criterion

from ..conftest import DIFFERENCES, EXACT, differences, planar
from .shared import STRATEGIES, at, solver


@jtik.criterion(residual=True)
def near_point(q, robot, *, point=(1.0, 2.0)):
    """The third joint near a point [m], and all joints near zero."""
    return casadi.vertcat(robot.position(q, "link3") - point, 0.1 * q)


@jtik.criterion
def near_point_squared(q, robot, *, point=(1.0, 2.0)):
    off = robot.position(q, "link3") - point
    return (casadi.sumsqr(off) + 0.01 * casadi.sumsqr(q)) / 2


def residual(robot, q, point=(1.0, 2.0)):
    return np.concatenate([robot.position(q, "link3") - point, 0.1 * q])


class TestResidualForm:
    def test_the_criterion_is_half_the_squared_residual(self, rng):
        robot = planar(5)
        q = robot.random_configuration(rng)
        r = residual(robot, q)
        assert near_point(q, robot) == pytest.approx(r @ r / 2, rel=EXACT)
        A = differences(lambda p: residual(robot, p), robot, q)
        assert near_point.gradient(q, robot) == pytest.approx(A.T @ r, abs=DIFFERENCES)
        assert isinstance(near_point, ResidualCriterion)
        assert near_point.name == "near_point"

    def test_parameters_and_weights_are_live(self):
        robot, q = planar(5), np.full(5, 0.2)
        ik = solver(robot, 2.0 * near_point(point=(0.0, 1.0)))
        r = residual(robot, q, (0.0, 1.0))
        assert at(ik, q).cost == pytest.approx(r @ r, rel=EXACT)
        ik.parameters["near_point.point"], ik.parameters["near_point.weight"] = (3.0, 0.0), 0.5
        r = residual(robot, q, (3.0, 0.0))
        assert at(ik, q).cost == pytest.approx(r @ r / 4, rel=EXACT)

    @pytest.mark.parametrize(
        "made",
        [
            lambda q: [q[0], 2.0, q[1] ** 2],
            lambda q: (q[0], 2, q[1] ** 2),
            lambda q: np.array([q[0], 2.0, q[1] ** 2], dtype=object),
            lambda q: casadi.horzcat(q[0], 2.0, q[1] ** 2),
        ],
    )
    def test_what_a_residual_may_be(self, made):
        criterion = jtik.criterion(residual=True)(lambda q, robot: made(q))
        assert criterion([3.0, 0.5, 0.0], planar(3)) == pytest.approx((9 + 4 + 1 / 16) / 2, rel=EXACT)

    def test_one_residual_may_be_a_scalar(self):
        assert jtik.criterion(residual=True)(lambda q, robot: q[1] - 1)([0, 0.5, 0], planar(3)) == pytest.approx(0.125)

    @pytest.mark.parametrize(
        ("given", "message"),
        [
            ("abc", "not str 'abc'"),
            (None, "not NoneType"),
            (1j, "not complex 1j"),
            ([1.0, "two"], "not str 'two'"),
            ([], r"not shape \(0, 0\)|not shape \(0, 1\)"),
            (np.eye(3), "not ndarray"),
            (casadi.SX.eye(2), r"not shape \(2, 2\); make a matrix one by casadi.vec"),
        ],
    )
    def test_what_is_no_residual_is_refused(self, given, message):
        with pytest.raises(jtik.CriterionError, match=message):
            solver(planar(3), jtik.criterion(residual=True)(lambda q, robot: given))

    def test_an_operation_that_cannot_be_traced_names_the_line(self):
        @jtik.criterion(residual=True)
        def floated(q, robot):
            return [float(q[0])]

        with pytest.raises(jtik.CriterionError, match=r"`return \[float\(q\[0\]\)\]`"):
            solver(planar(3), floated)

    def test_the_option_is_a_bool(self):
        with pytest.raises(jtik.ArgumentError, match="residual: given yes; accepted: True or False"):
            jtik.criterion(residual="yes")

    def test_options_may_say_what_is_the_default(self):
        assert jtik.criterion(residual=False)(lambda q, robot: q[0])([2.0], planar(1)) == 2.0
        assert jtik.criterion()(lambda q, robot: q[0])([2.0], planar(1)) == 2.0

    def test_other_first_values_and_pickling(self):
        robot, q = planar(4), np.full(4, 0.3)
        moved = near_point(point=(0.5, 0.5))
        assert isinstance(moved, ResidualCriterion)
        again = pickle.loads(pickle.dumps(moved))
        assert again(q, robot) == moved(q, robot) != near_point(q, robot)
        ik = pickle.loads(pickle.dumps(solver(robot, moved, "hybrid+second_order")))
        assert ik.solve([2.0, 1.0], q0=q)

    def test_it_fulfils_the_contract(self):
        check_criterion(near_point, planar(4))

    def test_the_contract_finds_a_value_that_is_not_that_of_the_residual(self):
        class Twice(ResidualCriterion):
            def residual(self, kinematics, parameters):
                return kinematics.q

            def value(self, kinematics, parameters):
                return casadi.sumsqr(kinematics.q)

        with pytest.raises(AssertionError, match="criterion 'twice' is .* and half its squared residual is"):
            check_criterion(Twice(), planar(3))


class TestSecondDerivatives:
    def test_the_gauss_newton_hessian(self, rng):
        """w A' A of each criterion in residual form, at live weights."""
        robot = planar(5)
        q = robot.random_configuration(rng)
        terms = CriterionTerms.of(robot, 2.0 * near_point - 0.5 * near_point(point=(0.0, 0.0)) + near_point_squared)
        terms.parameters["near_point.weight"] = 3.0
        parts, at_q, v = terms.least_squares(), casadi.SX.sym("q", 5), casadi.SX.sym("v", 5)
        second = parts.hessian(robot.integrate(at_q, v), v, casadi.SX(terms.parameters.memory))
        found = casadi.Function("W", [at_q, v], [second])(q, np.zeros(5)).full()
        A = differences(lambda p: residual(robot, p), robot, q)
        assert found == pytest.approx(2.5 * A.T @ A, abs=1e-6)
        others = float(parts.others(q, terms.parameters.memory))
        assert others == pytest.approx(near_point_squared(q, robot), rel=EXACT)

    def test_criteria_without_residuals_have_none(self):
        assert CriterionTerms.of(planar(3), near_point_squared).least_squares() is None

    @pytest.mark.quick(2)
    @pytest.mark.parametrize("strategy", STRATEGIES)
    def test_every_strategy_finds_a_minimum_of_it(self, strategy):
        """Task and Jacobian are those of the solver, H and its gradient written out again."""
        robot = planar(5)
        q0 = np.array([0.3, 0.4, -0.2, 0.5, 0.1])
        options = {"max_iterations": 5000, "position_tolerance": 1e-4, "optimality_tolerance": 1e-3}
        found = solver(robot, near_point, strategy).solve([2.8, 1.6], q0=q0, **options)
        expected = solver(robot, near_point_squared, strategy).solve([2.8, 1.6], q0=q0, **options)
        assert found.position_error <= 1e-4
        assert found.cost == pytest.approx(expected.cost, rel=1e-3)

    def test_second_order_uses_it_where_the_hessian_is_not_positive_definite(self):
        """The matrix of the quadratic program is N A'A N / s + I - N there, and N W N / s + I - N elsewhere."""
        robot = planar(5)
        ik = solver(robot, near_point, "hybrid+second_order")
        seen = set()
        for seed in range(12):
            q = robot.random_configuration(seed)
            point = robot.position(q, "link3") + 0.05 if seed % 2 else (1.0, 2.0)
            ik.parameters["near_point.point"] = point
            target = robot.position(q)  # on target: no task displacement
            found = at(ik, q)
            N = np.eye(5) - np.linalg.pinv(found.jacobian) @ found.jacobian
            A = differences(lambda p, x=point: residual(robot, p, x), robot, q)
            gradient = partial(_lagrangian_gradient, robot, point, found.multipliers)
            exact, gauss_newton = N @ differences(gradient, robot, q) @ N, N @ A.T @ A @ N
            lowest = np.linalg.eigvalsh(exact + 10 * (np.eye(5) - N))[0] / np.abs(exact).max()
            if abs(lowest) < 1e-3:
                continue
            seen.add(bool(lowest > 0))
            reduced = exact if lowest > 0 else gauss_newton
            free = ik.build(q, target).P - (np.eye(5) - N)
            # a pivot of the Gauss-Newton matrix that is close to zero is raised to 0.01
            tolerance = 1e-4 if lowest > 0 else 0.05
            assert free / np.abs(free).max() == pytest.approx(reduced / np.abs(reduced).max(), abs=tolerance)
        assert seen == {True, False}


def _lagrangian_gradient(robot, point, multipliers, q):
    A = differences(lambda p: residual(robot, p, point), robot, q)
    return A.T @ residual(robot, q, point) + robot.jacobian(q)[:2].T @ multipliers

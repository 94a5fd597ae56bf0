"""A criterion as numbers for other libraries: value, gradient, Hessian, and the objective that lowers it."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.interop.criterion_evaluation import CriterionNumbers, checked, convex
from jtik_formulations import JointCentering

from ..conftest import DIFFERENCES, ball_arm, dh_arm, differences, floating_arm

ROBOTS = {"dh": dh_arm, "ball": ball_arm, "floating": floating_arm}


@jtik.criterion
def place(q, robot, *, height=0.5):
    """Squared distance of the tip from a point, times its height."""
    p = robot.position(q, "tip")
    return (p[0] ** 2 + (p[1] - 0.2) ** 2) * (p[2] - height)


@pytest.mark.parametrize("name", ROBOTS)
class TestDerivatives:
    def test_the_gradient_is_with_respect_to_the_velocity(self, name, rng):
        robot = ROBOTS[name]()
        numbers, q = CriterionNumbers(2.0 * place, robot), robot.random_configuration(rng)
        expected = differences(lambda at: [numbers.value(at)], robot, q)
        assert numbers.value(q) == pytest.approx(2.0 * place(q, robot))
        assert numbers.gradient(q) == pytest.approx(expected[0], abs=DIFFERENCES)

    def test_the_hessian_is_along_integrate(self, name, rng):
        robot = ROBOTS[name]()
        numbers, q, step = CriterionNumbers(place, robot), robot.random_configuration(rng), 1e-3
        hessian = numbers.hessian(q)
        assert hessian == pytest.approx(hessian.T, abs=1e-12)
        for v in rng.normal(size=(5, robot.n)):
            ahead, behind = (numbers.value(robot.integrate(q, side * step * v)) for side in (1, -1))
            second = (ahead - 2 * numbers.value(q) + behind) / step**2
            assert v @ hessian @ v == pytest.approx(second, abs=1e-4 * (v @ v) ** 2)


def test_parameters_are_live():
    numbers, q = CriterionNumbers(place, dh_arm()), np.full(7, 0.3)
    before, fall = numbers.value(q), numbers.value(q) - _with(numbers, q, 1.5)
    assert _with(numbers, q, 0.5) == before
    assert fall == pytest.approx(dh_arm().position(q)[0] ** 2 + (dh_arm().position(q)[1] - 0.2) ** 2)


def _with(numbers, q, height):
    numbers.parameters["place.height"] = height
    return numbers.value(q)


class TestObjective:
    def test_with_the_identity_the_gradient_has_the_gain(self, rng):
        numbers, q = CriterionNumbers(place, dh_arm()), rng.normal(size=7)
        P, c = numbers.objective(q, 0.3, "identity")
        assert P.tolist() == np.eye(7).tolist()
        assert c == pytest.approx(0.3 * numbers.gradient(q))

    def test_with_the_convex_hessian_both_have_it(self, rng):
        numbers, q = CriterionNumbers(place, dh_arm()), rng.normal(size=7)
        P, c = numbers.objective(q, 0.3, "convex")
        assert pytest.approx(0.3 * convex(numbers.hessian(q))) == P
        assert c == pytest.approx(0.3 * numbers.gradient(q))

    def test_of_a_quadratic_criterion_its_minimiser_is_one_newton_step_away(self, rng):
        preferred, q = rng.normal(size=7), rng.normal(size=7)
        P, c = CriterionNumbers(JointCentering(preferred=preferred), dh_arm()).objective(q, 1.0, "convex")
        assert q - np.linalg.solve(P, c) == pytest.approx(preferred)


def test_the_closest_convex_matrix_has_no_negative_eigenvalue(rng):
    basis = np.linalg.qr(rng.normal(size=(4, 4)))[0]
    values = np.array([3.0, 1.0, -0.5, -2.0])
    expected = basis @ np.diag(np.maximum(values, 0)) @ basis.T
    assert convex(basis @ np.diag(values) @ basis.T) == pytest.approx(expected)


@pytest.mark.parametrize("gain", [0.0, -1.0, np.inf, np.nan])
def test_a_gain_is_positive_and_finite(gain):
    with pytest.raises(jtik.ArgumentError, match="gain: given .*; accepted: a positive number"):
        checked(gain, "identity")


def test_another_curvature_is_refused():
    checked(1.0, "convex")
    with pytest.raises(jtik.ArgumentError, match="curvature: given exact; accepted: 'identity' or 'convex'"):
        checked(1.0, "exact")

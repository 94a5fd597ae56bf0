"""Sums and multiples of criteria."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import EXACT, planar
from .shared import at, solver


class TestSums:
    def terms(self):
        return JointCentering(), ObstacleAvoidance(jtik.Point((2.0, 2.0)))

    def test_weights_multiply_from_either_side_and_nest(self, rng):
        robot = planar(4)
        A, B = self.terms()
        q = robot.random_configuration(rng)
        a, b = (at(solver(robot, term), q) for term in (A, B))
        for total, wa, wb in (
            (A + B, 1, 1),
            (2 * A + B * 0.5, 2, 0.5),
            (0.5 * (A + 3 * B), 0.5, 1.5),
            ((A + B) * 2 + 0.0 * A, 2, 2),
            (np.float64(0.3) * A + 2 * (B * np.int64(2)), 0.3, 4),
            (B + (A + B), 1, 2),
        ):
            found = at(solver(robot, total), q)
            assert found.cost == pytest.approx(wa * a.cost + wb * b.cost, rel=EXACT)
            assert found.gradient == pytest.approx(wa * a.gradient + wb * b.gradient, abs=1e-11)
            assert sum(found.criteria.values()) == pytest.approx(found.cost, rel=EXACT)

    def test_names_that_come_again_are_numbered(self):
        A, B = self.terms()
        ik = solver(planar(4), A + B + 2 * A + 3 * A)
        names = ["joint_centering", "obstacle_avoidance", "joint_centering_2", "joint_centering_3"]
        assert [key.split(".")[0] for key in ik.parameters if key.endswith(".weight")] == names
        assert [float(ik.parameters[f"{name}.weight"]) for name in names] == [1, 1, 2, 3]
        assert list(at(ik, [0.1] * 4).criteria) == names

    def test_a_name_with_a_number_does_not_share_parameters(self):
        """joint_centering twice and one with the name joint_centering_2 are three criteria."""
        A = JointCentering(1.0)
        C = JointCentering(5.0, name="joint_centering_2")
        ik = solver(planar(2), A + A + C)
        q = np.array([0.3, -0.2])
        assert len([key for key in ik.parameters if key.endswith(".weight")]) == 3
        assert at(ik, q).cost == pytest.approx((1 + 1 + 5) * q @ q / 2)
        assert len(at(ik, q).criteria) == 3

    def test_equally_named_criteria_keep_parameters_of_their_own(self, rng):
        robot = planar(3)
        ik = solver(robot, JointCentering() + JointCentering(2.0, np.ones(3)))
        q = robot.random_configuration(rng)
        assert at(ik, q).cost == pytest.approx(q @ q / 2 + (q - 1) @ (q - 1))
        ik.parameters["joint_centering_2.preferred"] = np.zeros(3)
        assert at(ik, q).cost == pytest.approx(3 * q @ q / 2)

    @pytest.mark.parametrize("weight", [np.nan, np.inf, "heavy", "3", None, 1j, [1.0, 2.0], np.ones(2)])
    def test_a_weight_is_one_finite_number(self, weight):
        for multiply in (lambda: JointCentering() * weight, lambda: weight * JointCentering()):
            with pytest.raises(jtik.ArgumentError, match="weight: given .*; accepted: one finite number"):
                multiply()

    def test_a_product_of_two_criteria_is_refused(self):
        with pytest.raises(jtik.ArgumentError, match=r"weight: given JointCentering\(\); accepted: one finite"):
            JointCentering() * JointCentering()

    def test_a_weight_that_overflows_is_refused(self):
        with pytest.raises(jtik.ArgumentError, match="weight: given inf"):
            1e200 * (1e200 * JointCentering())

    @pytest.mark.parametrize("zero", [0, 0.0, -0.0, np.int64(0)])
    def test_division_by_zero_is_refused(self, zero):
        with pytest.raises(jtik.ArgumentError, match="^divisor: given .*; accepted: a finite number other than 0$"):
            JointCentering() / zero

    @pytest.mark.parametrize("divisor", [np.nan, np.inf, "half", [2.0]])
    def test_a_divisor_is_one_finite_number(self, divisor):
        with pytest.raises(jtik.ArgumentError, match="divisor: given .*; accepted: a finite number other than 0"):
            JointCentering() / divisor

    def test_the_builtin_sum_adds_criteria_and_sums(self, rng):
        A, B = self.terms()
        assert sum([A, B]) == A + B
        assert sum([2 * A, B, A + B]) == 2 * A + B + A + B
        assert sum([]) == 0

    def test_differences_and_quotients(self):
        A, B = self.terms()
        assert [weight for weight, _ in (A - B).terms] == [1, -1]
        assert (A - B).terms == (A + -1 * B).terms
        assert ((A + B) / 2).terms == ((0.5, A), (0.5, B))
        assert (A / 3).terms == ((1 / 3, A),)
        assert (-A).terms == ((-1, A),)
        assert (-(A - 2 * B)).terms == ((-1, A), (2, B))
        assert (A - (A - B)).terms == ((1, A), (-1, A), (1, B))
        assert (0 - A).terms == (-A).terms
        assert (A - 0).terms == (A + 0).terms == (0 + A).terms == ((1, A),)

    def test_numpy_numbers_on_either_side(self):
        A, _ = self.terms()
        for two in (np.float32(2), np.int64(2), np.array(2.0)):
            assert (two * A).terms == (A * two).terms == ((2, A),)
        assert (A / np.float64(2)).terms == ((0.5, A),)

    def test_a_plus_sign_changes_nothing(self):
        assert repr(+JointCentering()) == "JointCentering()"
        assert repr(+(2 * JointCentering())) == "2.0 * JointCentering()"

    def test_a_difference_has_the_difference_of_values_and_gradients(self, rng):
        robot = planar(4)
        A, B = self.terms()
        q = robot.random_configuration(rng)
        a, b, both = (at(solver(robot, term), q) for term in (A, B, A / 4 - 3 * B))
        assert both.cost == pytest.approx(a.cost / 4 - 3 * b.cost, rel=1e-11)
        assert both.gradient == pytest.approx(a.gradient / 4 - 3 * b.gradient, abs=1e-11)

    def test_a_negative_weight_maximises(self):
        """Of the two postures that reach the target, the one where the elbow is high minimises -H."""

        @jtik.criterion
        def height(q, robot):
            return robot.position(q, "link2")[1]

        robot, target, q0 = planar(3), (1.6, 0.2), [0.3, 0.2, -0.4]
        low, high = (
            robot.position(solver(robot, each).solve(target, q0=q0, max_iterations=500).q, "link2")[1]
            for each in (height, -height)
        )
        assert high > low + 0.5

    def test_a_live_weight_takes_any_finite_number(self):
        robot, q = planar(4), np.array([0.3, 0.2, 0.1, 0.4])
        ik = solver(robot, JointCentering())
        ik.parameters["joint_centering.weight"] = -2.0
        assert at(ik, q).cost == pytest.approx(-q @ q)

    def test_a_sum_with_something_else_is_a_type_error(self):
        A, _ = self.terms()
        for invalid in (lambda: A + 1.0, lambda: 1.0 + A, lambda: A - 1, lambda: 1 - A, lambda: A + "joint_centering"):
            with pytest.raises(TypeError, match="unsupported operand|concatenate"):
                invalid()

    def test_none_and_weight_zero_have_no_gradient(self):
        robot, q0, target = planar(4), np.array([0.4, 0.3, 0.2, 0.1]), (2.0, 2.0)
        bare = solver(robot, None).solve(target, q0=q0)
        assert bare.cost == 0
        assert bare.criteria == {}
        assert bare.gradient.tolist() == [0] * 4
        weightless = solver(robot, 0 * JointCentering()).solve(target, q0=q0)
        assert weightless.converged
        assert weightless.q == pytest.approx(bare.q, abs=1e-5)

"""criterion(q, robot) is the value of a criterion, criterion.gradient(q, robot) its gradient."""

from __future__ import annotations

import copy
import gc
import pickle
import weakref
from dataclasses import dataclass

import casadi
import numpy as np
import pytest

import jtik
from jtik.criterion import evaluation
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import DIFFERENCES, EXACT, ball_arm, dh_arm, differences, floating_arm, planar
from .shared import at, link_height, solver

CIRCLE = jtik.Circle((2.0, 2.0), 0.3)
Q = np.array([0.3, 0.2, 0.1, 0.4])


class TestNumbers:
    @pytest.mark.parametrize("make", [lambda: planar(4), lambda: dh_arm(5, 1), ball_arm, floating_arm])
    def test_value_and_gradient_agree_with_closed_form_and_differences(self, make, rng):
        robot = make()
        stiffness = rng.uniform(0.5, 2.0, robot.nq)
        criterion = JointCentering(stiffness)
        for _ in range(5):
            q = robot.random_configuration(rng)
            away = (q - robot.neutral)[robot.scalar_q]
            value, gradient = criterion(q, robot), criterion.gradient(q, robot)
            assert type(value) is float
            assert value == pytest.approx(stiffness[robot.scalar_q] @ away**2 / 2, rel=EXACT)
            assert gradient.shape == (robot.n,)
            numeric = differences(lambda p: criterion(p, robot), robot, q)[0]
            assert gradient == pytest.approx(numeric, abs=DIFFERENCES)

    def test_a_function_criterion(self):
        robot = planar(4)
        expected = (robot.position(Q, "link3")[1] - 0.5) ** 2
        assert link_height(Q, robot) == pytest.approx(expected, rel=EXACT)
        numeric = differences(lambda p: link_height(p, robot), robot, Q)[0]
        assert link_height.gradient(Q, robot) == pytest.approx(numeric, abs=DIFFERENCES)

    def test_lists_are_configurations_too(self):
        assert JointCentering()([0.3, 0.2, 0.1, 0.4], planar(4)) == pytest.approx(Q @ Q / 2)

    def test_a_sum_is_the_weighted_sum(self):
        robot = planar(4)
        A, B = JointCentering(), ObstacleAvoidance(CIRCLE)
        total = 2 * A - B / 2 + link_height
        expected = 2 * A(Q, robot) - B(Q, robot) / 2 + link_height(Q, robot)
        assert total(Q, robot) == pytest.approx(expected, rel=EXACT)
        expected_gradient = 2 * A.gradient(Q, robot) - B.gradient(Q, robot) / 2 + link_height.gradient(Q, robot)
        assert total.gradient(Q, robot) == pytest.approx(expected_gradient, abs=1e-11)

    def test_the_value_is_the_cost_that_a_solver_reports(self):
        total = 2 * JointCentering() + 0.3 * ObstacleAvoidance([CIRCLE, jtik.Point((1.0, -2.0))], bodies="both")
        found = at(solver(planar(4), total), Q)
        assert total(Q, planar(4)) == pytest.approx(found.cost, rel=EXACT)
        assert total.gradient(Q, planar(4)) == pytest.approx(found.gradient, abs=1e-11)

    def test_an_empty_sum_is_zero(self):
        empty = jtik.CriterionSum(())
        assert empty(Q, planar(4)) == 0.0
        assert empty.gradient(Q, planar(4)).tolist() == [0] * 4

    def test_a_constant_has_a_zero_gradient(self):
        constant = jtik.criterion(lambda q, robot: 3.0)
        assert constant(Q, planar(4)) == 3.0
        assert constant.gradient(Q, planar(4)).tolist() == [0] * 4


class TestParameters:
    def test_values_by_name(self):
        robot = planar(4)
        assert JointCentering()(Q, robot, stiffness=3.0) == pytest.approx(3 * Q @ Q / 2)
        preferred = np.array([0.1, 0.2, 0.3, 0.4])
        criterion = JointCentering()
        assert criterion(Q, robot, preferred=preferred) == JointCentering(preferred=preferred)(Q, robot)
        assert criterion.gradient(Q, robot, preferred=preferred) == pytest.approx(Q - preferred)
        assert criterion(Q, robot) == pytest.approx(Q @ Q / 2)  # the first values are back

    def test_of_a_function_criterion(self):
        robot = planar(4)
        assert link_height(Q, robot, height=2.0) == link_height(height=2.0)(Q, robot)
        assert link_height(Q, robot, height=2.0) != link_height(Q, robot)
        assert isinstance(link_height(height=2.0), jtik.Criterion)

    def test_of_a_sum_by_full_names(self):
        robot = planar(4)
        A = JointCentering()
        total = A + A - link_height
        values = {"joint_centering_2.stiffness": 3.0, "joint_centering.weight": 0.0, "link_height.height": 1.0}
        expected = 3 * Q @ Q / 2 - link_height(Q, robot, height=1.0)
        assert total(Q, robot, **values) == pytest.approx(expected, rel=EXACT)

    def test_an_unknown_name_lists_the_names(self):
        robot = planar(4)
        with pytest.raises(jtik.UnknownNameError, match="parameter 'stifness'; did you mean 'stiffness'"):
            JointCentering()(Q, robot, stifness=1.0)
        with pytest.raises(jtik.UnknownNameError, match=r"known: joint_centering.weight, joint_centering.stiffness"):
            (2 * JointCentering())(Q, robot, stiffness=1.0)
        with pytest.raises(jtik.UnknownNameError, match="known: height"):
            link_height(Q, robot, width=1.0)

    @pytest.mark.parametrize("value", [np.nan, "stiff", [1.0, 2.0], None])
    def test_a_value_that_cannot_be_used_is_refused(self, value):
        with pytest.raises(jtik.ArgumentError, match=r"^stiffness: given .*; accepted: 4 numbers for ik.robot, one"):
            JointCentering()(Q, planar(4), stiffness=value)

    def test_a_weight_that_cannot_be_used_is_refused(self):
        with pytest.raises(jtik.ArgumentError, match=r"^joint_centering.weight: given nan; accepted: one finite"):
            (2 * JointCentering())(Q, planar(4), **{"joint_centering.weight": np.nan})


class TestInvalidInput:
    @pytest.mark.parametrize("gradient", [False, True])
    @pytest.mark.parametrize("criterion", [JointCentering(), 2 * JointCentering()])
    @pytest.mark.parametrize(
        ("q", "message"),
        [
            ([0.1, 0.2], r"q: given shape \(2,\); accepted: finite numbers of shape \(4,\)"),
            ([0.1, np.nan, 0.2, 0.3], "q: given nan at index 1"),
            ("home", "q: given"),
            (casadi.SX.sym("q", 3), r"q: given an expression of shape \(3, 1\); accepted: shape \(4, 1\)"),
        ],
    )
    def test_q(self, criterion, gradient, q, message):
        with pytest.raises(jtik.ArgumentError, match=message):
            (criterion.gradient if gradient else criterion)(q, planar(4))

    def test_the_robot(self):
        message = r"robot: given arm; accepted: a jtik.Robot, as in criterion\(q, robot\)"
        for criterion in (JointCentering(), 2 * JointCentering(), link_height):
            for evaluate in (criterion, criterion.gradient):
                with pytest.raises(jtik.ArgumentError, match=message):
                    evaluate(Q, "arm")

    def test_a_function_criterion_without_robot_or_without_q(self):
        accepted = r"accepted: link_height\(q, robot\) for the value, link_height\(parameter=...\) for other first"
        with pytest.raises(jtik.ArgumentError, match=f"robot: given nothing; {accepted}"):
            link_height(Q)
        with pytest.raises(jtik.ArgumentError, match=f"q: given nothing; {accepted}"):
            link_height(robot=planar(4))

    def test_what_cannot_be_traced(self):
        with pytest.raises(jtik.CriterionError, match="must return a scalar"):
            jtik.criterion(lambda q, robot: q)(Q, planar(4))


class TestExpressions:
    def test_criteria_are_made_of_criteria(self):
        centering = JointCentering()

        @jtik.criterion
        def composed(q, robot, *, height=0.1, weight_of=2.0):
            gradient = centering.gradient(q, robot)
            own = link_height(q, robot, height=height)
            return weight_of * centering(q, robot) + own + gradient.T @ gradient + (0.5 * centering)(q, robot)

        robot = planar(4)
        expected = 2.5 * Q @ Q / 2 + link_height(Q, robot, height=0.1) + Q @ Q
        assert composed(Q, robot) == pytest.approx(expected, rel=EXACT)
        numeric = differences(lambda p: composed(p, robot), robot, Q)[0]
        assert composed.gradient(Q, robot) == pytest.approx(numeric, abs=DIFFERENCES)
        ik = solver(robot, composed)
        ik.parameters["composed.height"] = 1.0
        assert at(ik, Q).cost == pytest.approx(composed(Q, robot, height=1.0), rel=EXACT)

    @pytest.mark.parametrize("kind", [casadi.SX, casadi.MX])
    def test_a_symbolic_q_gives_expressions(self, kind):
        robot, q = planar(4), kind.sym("q", 4)
        for criterion in (link_height, 2 * JointCentering() - link_height):
            H, gradient = criterion(q, robot), criterion.gradient(q, robot)
            assert H.shape == (1, 1)
            assert gradient.shape == (4, 1)
            both = casadi.Function("both", [q], [H, gradient])
            assert float(both(Q)[0]) == pytest.approx(criterion(Q, robot), rel=EXACT)
            assert both(Q)[1].full()[:, 0] == pytest.approx(criterion.gradient(Q, robot), abs=EXACT)

    def test_parameters_may_be_symbolic(self):
        robot, k = planar(4), casadi.SX.sym("k")
        H = JointCentering()(Q, robot, stiffness=k)
        assert float(casadi.Function("H", [k], [H])(3.0)) == pytest.approx(3 * Q @ Q / 2)
        weighted = (2 * JointCentering())(Q, robot, **{"joint_centering.weight": k})
        assert float(casadi.Function("H", [k], [weighted])(3.0)) == pytest.approx(3 * Q @ Q / 2)
        with pytest.raises(jtik.ArgumentError, match=r"stiffness: given an expression of shape \(2, 1\)"):
            JointCentering()(Q, robot, stiffness=casadi.SX.sym("k", 2))

    def test_an_empty_sum_of_symbols_is_zero(self):
        q = casadi.SX.sym("q", 4)
        assert jtik.CriterionSum(())(q, planar(4)).is_zero()
        assert jtik.CriterionSum(()).gradient(q, planar(4)).shape == (4, 1)


class TestCache:
    """The compiled functions are kept for a criterion and a robot, and go with either of them."""

    def entries(self, robot):
        return evaluation._cache.get(robot, {})

    def test_a_second_call_compiles_nothing(self, monkeypatch):
        robot, criterion = planar(4), JointCentering()
        criterion(Q, robot), criterion.gradient(Q, robot)
        monkeypatch.setattr(evaluation, "function", None)
        criterion(2 * Q, robot, stiffness=2.0), criterion.gradient(2 * Q, robot)

    def test_another_robot_and_another_criterion_have_their_own(self):
        criterion = JointCentering(2.0)
        assert criterion(Q, planar(4)) == pytest.approx(Q @ Q)
        assert criterion(Q[:3], planar(3)) == pytest.approx(Q[:3] @ Q[:3])
        assert JointCentering()(Q, planar(4)) == pytest.approx(Q @ Q / 2)

    def test_an_entry_goes_with_its_criterion(self):
        robot = jtik.Robot.planar(4)
        criterion = JointCentering()
        criterion(Q, robot)
        assert len(self.entries(robot)) == 1
        del criterion
        gc.collect()
        assert len(self.entries(robot)) == 0

    @pytest.mark.slow
    def test_an_entry_goes_with_its_robot(self):
        robot, criterion = jtik.Robot.planar(4), JointCentering()
        criterion(Q, robot), criterion.gradient(Q, robot)
        gone = weakref.ref(robot)
        gc.collect()
        before = len(evaluation._cache)
        del robot
        gc.collect()
        assert gone() is None
        assert len(evaluation._cache) == before - 1

    def test_parameters_of_another_size_are_compiled_anew(self):
        class Growing(jtik.Criterion):
            size = 1

            def parameters(self, robot):
                return {"a": np.ones(self.size)}

            def value(self, kinematics, parameters):
                return casadi.sumsqr(parameters["a"]) + kinematics.q[0]

        criterion = Growing()
        assert criterion(Q, planar(4)) == pytest.approx(1.3)
        criterion.size = 3
        assert criterion(Q, planar(4)) == pytest.approx(3.3)

    def test_a_criterion_that_cannot_be_hashed(self):
        @dataclass
        class Plain(jtik.Criterion):
            aim: float

            def value(self, kinematics, parameters):
                return (kinematics.q[0] - self.aim) ** 2

        assert Plain(0.1)(Q, planar(4)) == pytest.approx(0.04)
        assert Plain(0.2)(Q, planar(4)) == pytest.approx(0.01)

    def test_an_evaluated_criterion_is_copied_and_pickled(self):
        criterion = JointCentering(2.0)
        criterion(Q, planar(4))
        for copied in (pickle.loads(pickle.dumps(criterion)), copy.deepcopy(criterion)):
            assert copied(Q, planar(4)) == criterion(Q, planar(4))

"""The contract harness finds what is wrong with a plugin and says so."""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi
import numpy as np
import pytest

import jtik
from jtik.strategy import Evaluation, StrategyError, TaskDisplacement
from jtik.testing import check_criterion, check_strategy, example_criterion
from jtik_formulations import Newton, ProjectedGradient

from ..conftest import planar

Hybrid = jtik.strategies["hybrid"]


class Fine(jtik.Criterion):
    name = "fine"

    def parameters(self, robot):
        return {"aim": 0.3}

    def value(self, kinematics, parameters):
        return (kinematics.q[0] - parameters["aim"]) ** 2


class Unpicklable(Fine):
    def __reduce__(self):
        raise TypeError("no")


class Forgetful(Fine):
    factor = 1.0

    def __init__(self):
        self.factor = 2.0

    def __getstate__(self):
        return {}

    def value(self, kinematics, parameters):
        return self.factor * super().value(kinematics, parameters)


class TestCriteria:
    def complaint(self, criterion, error=AssertionError):
        with pytest.raises(error) as caught:
            check_criterion(criterion, planar(3), samples=5)
        return str(caught.value)

    def test_a_correct_criterion_passes(self):
        check_criterion(Fine(), planar(3))
        check_criterion(jtik.criterion(lambda q, robot: q[0] ** 2), planar(3), samples=3, rng=np.random.default_rng(1))

    def test_an_object_that_is_no_criterion(self):
        assert "must be a jtik.Criterion" in self.complaint("fine")

    def test_no_name(self):
        class Nameless(Fine):
            name = ""

        assert "must have a name" in self.complaint(Nameless())

    def test_a_parameter_that_is_never_read(self):
        class Frozen(Fine):
            def value(self, kinematics, parameters):
                return (kinematics.q[0] - 0.3) ** 2

        text = self.complaint(Frozen())
        assert "never reads its parameter 'frozen.aim'; use the expression in `parameters`, not its first value" in text

    def test_parameters_that_change_from_call_to_call(self):
        class Restless(Fine):
            calls = 0

            def parameters(self, robot):
                self.calls += 1
                return {"aim": float(self.calls)}

        assert "starts at 1.0 and at 2.0" in self.complaint(Restless())

    def test_a_parameter_called_weight(self):
        class Heavy(Fine):
            def parameters(self, robot):
                return {"weight": 1.0}

        expected = "must not name a parameter 'weight'; accepted: any text but 'weight'"
        assert expected in self.complaint(Heavy())

    def test_a_value_that_is_not_finite_somewhere(self):
        class Rooted(Fine):
            def value(self, kinematics, parameters):
                return casadi.sqrt(kinematics.q[0] - parameters["aim"])

        assert "not finite" in self.complaint(Rooted())

    def test_a_gradient_that_is_not_finite_somewhere(self):
        class Cusp(Fine):
            def value(self, kinematics, parameters):
                return casadi.norm_2(kinematics.q[:2]) + parameters["aim"]

        with pytest.raises(AssertionError, match="gradient of criterion 'cusp' is"):
            check_criterion(Cusp(), planar(3), samples=[np.zeros(3)])

    def test_a_gradient_that_is_not_that_of_the_value(self):
        """The derivative of a discontinuous value does not contain its steps."""

        class Stairs(Fine):
            def value(self, kinematics, parameters):
                return casadi.sumsqr(kinematics.q) + casadi.floor(1e9 * kinematics.q[0]) / 1e9 + parameters["aim"]

        assert "by differences" in self.complaint(Stairs())

    def test_second_derivatives_that_are_not_those_of_the_gradient(self):
        class Misled(casadi.Callback):
            """1 - cos q0, whose gradient is right and says that its own derivative is 3."""

            def __init__(self, order):
                casadi.Callback.__init__(self)
                self.order, self.after = order, None
                self.construct(f"misled{order}", {})

            def eval(self, arguments):
                q0 = float(arguments[0])
                return [(1 - np.cos(q0), np.sin(q0), 3.0)[self.order]]

            def has_jacobian(self):
                return self.order < 2

            def get_n_in(self):
                return 1 + (self.order > 0)

            def get_sparsity_in(self, i):
                return casadi.Sparsity.dense(1, 1)

            def get_jacobian(self, name, inputs, outputs, options):
                self.after = Slope(name, self.order + 1)
                return self.after

        class Slope(Misled):
            def __init__(self, name, order):
                casadi.Callback.__init__(self)
                self.order, self.after = order, None
                self.construct(name, {"is_diff_in": [True] + [False] * order})

            def get_n_in(self):
                return 1 + self.order

            def get_n_out(self):
                return self.order

            def get_sparsity_out(self, i):
                return casadi.Sparsity.dense(1, 1)

            def eval(self, arguments):
                return [*super().eval(arguments), *[0.0] * (self.order - 1)]

        bent = Misled(0)

        @jtik.criterion
        def misled(q, robot):
            return bent(q[0])

        assert "second derivatives of criterion 'misled' along velocity 0" in self.complaint(misled)

    def test_a_value_that_fails_at_the_limits_only(self):
        @jtik.criterion
        def barrier(q, robot):
            return -casadi.sum1(casadi.log(2 - q))

        robot = jtik.Robot.planar(3, lower=-2, upper=2)
        with pytest.raises(AssertionError, match=r"is inf at q = \[2"):
            check_criterion(barrier, robot, samples=0)

    def test_a_one_sided_square_passes_where_it_begins(self):
        check_criterion(jtik.criterion(lambda q, robot: casadi.fmax(q[0], 0) ** 2), planar(3), samples=3)

    def test_an_object_that_cannot_be_pickled(self):
        assert "cannot be pickled" in self.complaint(Unpicklable())

    def test_an_object_that_is_another_after_it_was_pickled(self):
        assert "after it was pickled" in self.complaint(Forgetful())

    def test_a_vector_is_refused_as_a_user_would_meet_it(self):
        class Wide(Fine):
            def value(self, kinematics, parameters):
                return kinematics.q * parameters["aim"]

        assert "scalar" in self.complaint(Wide(), jtik.CriterionError)

    def test_examples_come_from_defaults_obstacles_or_the_class(self):
        class Needs(Fine):
            def __init__(self, wish):
                self.wish = wish

        class Offers(Needs):
            @classmethod
            def example(cls, robot):
                return cls(wish=robot.n)

        assert isinstance(example_criterion(Fine, planar(3)), Fine)
        assert example_criterion(Offers, planar(3)).wish == 3
        with pytest.raises(jtik.ArgumentError, match=r"Needs.*\['wish'\].*example\(robot\)"):
            example_criterion(Needs, planar(3))


class Changed(jtik.Strategy):
    """Hybrid's update with one thing changed."""

    def __init__(self, change=lambda update: {}, first=lambda state: state):
        self._change, self._first = change, first

    def initial_state(self, shape):
        return self._first(dict(Hybrid().initial_state(shape)))

    def update(self, model, state):
        update = Hybrid().update(model, state)
        return replace(update, **self._change(update))


class TestStrategies:
    def complaint(self, strategy, error=AssertionError, **options):
        with pytest.raises(error) as caught:
            check_strategy(strategy, samples=1, **options)
        return str(caught.value)

    @pytest.mark.slow
    def test_a_correct_strategy_passes(self):
        check_strategy(Changed(), samples=1, monotone=True)

    def test_an_unknown_name(self):
        with pytest.raises(jtik.UnknownNameError):
            check_strategy("hybird")

    def test_a_field_of_the_wrong_shape_is_the_solvers_own_error(self):
        text = self.complaint(Changed(lambda update: {"null_space": update.null_space[:2]}), StrategyError)
        assert "Changed.update returned null_space of shape (2, 1)" in text

    def test_a_strategy_that_does_not_move(self):
        assert "does not reach a target" in self.complaint(Changed(lambda update: {"accepted": 0 * update.accepted}))

    @pytest.mark.parametrize("kind", ["Composition", "Update"])
    def test_a_displacement_of_the_wrong_sign(self, kind):
        class Backwards(Newton):
            def full_step(self, model, state):
                return TaskDisplacement(-super().full_step(model, state).dq)

        def reverse(update):
            return {"dq": -update.dq, "candidate": None, "accepted": 1}

        text = self.complaint(Backwards() if kind == "Composition" else Changed(reverse))
        assert "proposes a displacement of the wrong sign" in text
        assert "dq is added to q, and -dq is what brings the target nearer" in text

    def test_a_null_space_displacement_of_the_wrong_sign(self):
        class Upwards(ProjectedGradient):
            def propose(self, model, state, task_dq):
                found = super().propose(model, state, task_dq)
                return replace(found, dq=-found.dq, decrease=-found.decrease)

        text = self.complaint(Newton(secondary=Upwards()))
        assert "does not lower H" in text
        assert "its sign must be that of -(I - J+ J) grad H" in text

    @pytest.mark.parametrize("acceptance", ["always", "task"])
    def test_a_null_space_displacement_of_the_wrong_sign_that_keeps_it_from_the_target(self, acceptance):
        class Upwards(ProjectedGradient):
            def propose(self, model, state, task_dq):
                found = super().propose(model, state, task_dq)
                return replace(found, dq=-found.dq)

        @dataclass(frozen=True, kw_only=True)
        class Climbing(Newton):
            def acceptance(self):
                return acceptance

        text = self.complaint(Climbing(secondary=Upwards()), max_iterations=1000)
        assert "raises H from " in text or "does not lower H" in text
        assert "its sign must be that of -(I - J+ J) grad H" in text

    def test_a_predicted_decrease_of_the_wrong_sign(self):
        @dataclass(frozen=True, kw_only=True)
        class Pessimist(type(jtik.strategies["weighted_qp"]())):
            def propose(self, model, state):
                found = super().propose(model, state)
                return replace(found, predicted_decrease=-found.predicted_decrease)

        text = self.complaint(Pessimist())
        assert "does not reach a target and refuses every step" in text
        assert "the sign of the decrease that it predicts, or of its merit function, may be wrong" in text

    def test_a_strategy_that_leaves_the_limits(self):
        class Drifting(Changed):
            """Newton's step and a drift in the null space, both without regard to limits."""

            def update(self, model, state):
                rows = model.row_space
                drift = rows.split(casadi.SX.ones(model.robot.n)).null
                dq = rows.least_squares(-model.here.residual).vector + 0.5 * drift
                q = model.robot.integrate(model.here.q, dq)
                candidate = Evaluation(q, model.residual(q), 0, dq)
                return replace(super().update(model, state), dq=dq, candidate=candidate, accepted=1)

        assert "leaves the joint limits" in self.complaint(Drifting())

    def test_a_strategy_whose_steps_are_not_finite(self):
        def poison(update):
            return {"candidate": replace(update.candidate, q=update.candidate.q * np.nan), "accepted": 1}

        assert "not finite" in self.complaint(Changed(poison))

    def test_a_claim_that_is_not_kept(self):
        newton = Newton(q_limit=np.inf, backtracking=False)
        with pytest.raises(AssertionError, match="lets V rise"):
            check_strategy(newton, samples=10, monotone=True)

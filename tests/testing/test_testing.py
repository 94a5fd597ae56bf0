"""The contract harness finds what is wrong with a plugin and says so."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik.strategy import Update
from jtik.testing import check_criterion, check_strategy, example_criterion

from ..conftest import planar

Hybrid = jtik.strategies["hybrid"]


class Fine(jtik.Criterion):
    name = "fine"

    def parameters(self, robot):
        return {"aim": 0.3}

    def value(self, kinematics, parameters):
        return (kinematics.q[0] - parameters["aim"]) ** 2


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


class Bent(jtik.Strategy):
    """Hybrid's law with one thing bent."""

    def __init__(self, bend=lambda update: {}, first=lambda state: state):
        self._bend, self._first = bend, first

    def initial_state(self, shape):
        return self._first(dict(Hybrid().initial_state(shape)))

    def update(self, model, state):
        update = Hybrid().update(model, state)
        fields = {name: getattr(update, name) for name in update.__dataclass_fields__}
        return Update(**{**fields, **self._bend(update)})


class TestStrategies:
    def complaint(self, strategy, error=AssertionError, **options):
        with pytest.raises(error) as caught:
            check_strategy(strategy, samples=1, **options)
        return str(caught.value)

    def test_a_sound_one_passes_by_name_and_as_an_object(self):
        check_strategy("hybrid", samples=1)
        check_strategy(Bent(), samples=1, monotone=True)

    def test_an_unknown_name(self):
        with pytest.raises(jtik.UnknownNameError):
            check_strategy("hybird")

    def test_a_state_that_changes_its_names(self):
        def forget(update):
            return {"state": {name: value for name, value in update.state.items() if name != "radius"}}

        assert "the state begins with names" in self.complaint(Bent(forget))

    def test_a_state_that_changes_its_sizes(self):
        def grow(update):
            return {"state": {**update.state, "radius": casadi.SX.zeros(2)}}

        assert "the state begins with names" in self.complaint(Bent(grow))

    @pytest.mark.parametrize("value", [np.nan, 1.0, np.zeros((1, 1))])
    def test_a_first_state_that_is_no_finite_vector(self, value):
        text = self.complaint(Bent(first=lambda state: {**state, "radius": np.array(value)}))
        assert "state 'radius' must start as a finite one-dimensional array" in text

    def test_a_term_of_another_size(self):
        assert "null_term must have shape" in self.complaint(Bent(lambda update: {"null_term": update.null_term[:2]}))

    def test_what_is_no_update(self):
        class Empty(Bent):
            def update(self, model, state):
                return None

        assert "must return an Update" in self.complaint(Empty())

    def test_a_law_that_goes_nowhere(self):
        assert "does not reach a target" in self.complaint(Bent(lambda update: {"accepted": 0 * update.accepted}))

    def test_a_law_that_leaves_the_limits(self):
        class Drifting(Bent):
            """Newton's step and a drift in the null space, both deaf to limits."""

            def update(self, model, state):
                drift = model.rows.split(casadi.SX.ones(model.robot.n)).null
                term = model.rows.least_squares(model.here.residual).vector - 0.5 * drift
                q = model.robot.integrate(model.here.q, -term)
                point = type(super().update(model, state).point)(q, model.residual(q), 0)
                return Update(**{**vars(super().update(model, state)), "point": point, "accepted": 1})

        assert "leaves the joint limits" in self.complaint(Drifting())

    def test_a_law_whose_steps_are_not_finite(self):
        def poison(update):
            q = update.point.q * np.nan
            return {"point": type(update.point)(q, update.point.residual, update.point.H), "accepted": 1}

        assert "not finite" in self.complaint(Bent(poison))

    def test_a_law_that_claims_what_it_does_not_keep(self):
        newton = jtik.strategies["newton"](q_limit=np.inf, backtracking=False)
        with pytest.raises(AssertionError, match="lets V rise"):
            check_strategy(newton, samples=10, monotone=True)
        check_strategy(jtik.strategies["newton"](), samples=1, monotone=True)

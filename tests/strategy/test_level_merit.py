"""The exact penalty of several levels as a merit function, on linear tasks: what it accepts, its weights, its state."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.strategy import LevelMerit, NullSpaceDisplacement, Proposal, Shape
from jtik.strategy.merit import penalty_falls

from .conftest import numbers, quadratic_model

LEVELS = ((0, 1), (2,))


def verdict_on(J, r, dq, *, levels=LEVELS, weights=None, penalty=0.0, null=None, **options):
    """The verdict on the task displacement dq (n,), beside a null-space displacement (n,)."""
    model = quadratic_model(J, r, levels=levels, **options)
    null = np.zeros(len(dq)) if null is None else null
    proposal = Proposal(
        casadi.SX(dq + null),
        task=casadi.SX(dq),
        null_space=NullSpaceDisplacement(casadi.SX(null)).completed(model),
    )
    state = {"weights": casadi.SX(np.zeros(len(r)) if weights is None else weights), "penalty": casadi.SX(penalty)}
    return LevelMerit().verdict(model, state, proposal, model.candidate(proposal.dq))


def accepted(*arguments, **options):
    return bool(numbers(verdict_on(*arguments, **options).accepted))


def test_the_first_state_has_a_weight_for_every_row():
    first = LevelMerit().initial_state(Shape(4, 4, 3, True))
    assert {name: value.tolist() for name, value in first.items()} == {"weights": [0, 0, 0], "penalty": [0]}


class TestOneLevel:
    levels = ((0, 1, 2),)

    def test_it_is_the_norm_of_the_residual(self, rng):
        J, r = rng.normal(size=(3, 5)), rng.normal(size=3)
        newton = -np.linalg.pinv(J) @ r
        for share, expected in ((1.0, True), (0.01, True), (1.9, True), (2.1, False), (-0.1, False)):
            assert accepted(J, r, share * newton, levels=self.levels) is expected

    def test_ratio_of_a_linear_task(self, rng):
        J, r = rng.normal(size=(3, 5)), rng.normal(size=3)
        found = verdict_on(J, r, -0.25 * np.linalg.pinv(J) @ r, levels=self.levels)
        assert numbers(found.ratio) == pytest.approx(1.0)
        assert found.progress is None  # that of V
        assert numbers(found.predicted_decrease) == pytest.approx((1 - 0.75**2) * r @ r / 2)


class TestTwoLevels:
    def test_progress_is_relative_to_the_penalty_function(self, rng):
        """A step that removes a quarter of every error removes a quarter of F, whatever the weights."""
        J, r = rng.normal(size=(3, 5)), rng.normal(size=3)
        assert numbers(verdict_on(J, r, -0.25 * np.linalg.pinv(J) @ r).progress) == pytest.approx(0.25)

    @pytest.mark.slow
    def test_a_step_that_worsens_the_lower_level_for_the_higher_is_accepted(self, rng):
        """The shortest step of the higher level alone, where it increases the error of the lower one."""
        cases = 0
        for _ in range(60):
            J, r = rng.normal(size=(3, 4)), rng.normal(size=3)
            dq = -np.linalg.pinv(J[:2]) @ r[:2]
            cases += abs(r[2] + J[2] @ dq) > abs(r[2])
            assert accepted(J, r, dq)
        assert cases > 6

    def test_a_step_that_takes_the_higher_level_off_its_target_for_the_lower_is_refused(self, rng):
        """The displacement lies in the row space of the higher level, and lowers the error of the lower one."""
        cases = 0
        for _ in range(60):
            J, r = rng.normal(size=(3, 4)), np.array([0.0, 0.0, rng.normal()])
            dq = 0.1 * np.linalg.pinv(J[:2]) @ rng.normal(size=2)
            cases += abs(r[2] + J[2] @ dq) < abs(r[2])
            assert not accepted(J, r, dq)
        assert cases > 6

    def test_weights_are_one_below_and_at_least_half_of_those_before_above(self, rng):
        J, r = rng.normal(size=(3, 4)), rng.normal(size=3)
        dq = -np.linalg.pinv(J) @ r
        weights = numbers(verdict_on(J, r, dq).state["weights"])
        assert (weights[0] > 0, weights[1:].tolist()) == (True, [1.0, 0.0])
        assert numbers(verdict_on(J, r, dq, weights=[1e3, 1, 0]).state["weights"])[0] == 500

    def test_the_weight_exceeds_the_multiplier_of_the_level_above(self, rng):
        """The lower level's error with the higher level kept has the multiplier (J1')+ J2' sign(r2)."""
        for _ in range(20):
            J, r = rng.normal(size=(3, 4)), rng.normal(size=3)
            multiplier = np.linalg.norm(np.linalg.pinv(J[:2]).T @ J[2]) / (1 + 1e-3)  # it is damped slightly
            assert numbers(verdict_on(J, r, np.zeros(4)).state["weights"])[0] > 1.4 * multiplier


class TestWithCriterion:
    def options(self, **changes):
        return {"gradient": np.array([0.0, 0, 0, 1.0]), "levels": ((0, 1),), "near_target": 1, **changes}

    def test_near_the_target_a_null_space_step_that_lowers_H_is_accepted(self):
        J, r, null = np.eye(2, 4), np.zeros(2), np.array([0.0, 0, 0, -0.5])
        assert accepted(J, r, np.zeros(4), null=null, **self.options())
        assert not accepted(J, r, np.zeros(4), null=-null, **self.options())

    def test_far_from_the_target_only_the_task_counts(self):
        J, r = np.eye(2, 4), np.array([0.3, 0.0])
        newton, up = np.array([-0.3, 0, 0, 0]), np.array([0.0, 0, 0, 0.5])
        assert accepted(J, r, newton, null=up, **self.options(near_target=0))
        assert not accepted(J, r, np.zeros(4), null=-up, **self.options(near_target=0))

    def test_a_step_out_of_the_neighbourhood_is_refused(self):
        J, r = np.eye(2, 4), np.array([0.3, 0.0])
        assert accepted(J, r, np.array([-0.1, 0, 0, 0]), **self.options())
        assert not accepted(J, r, np.array([-0.1, 0, 0, 0]), **self.options(neighbourhood=0.1))

    def test_at_the_optimum_rounding_is_accepted(self):
        """As by (M5) of merit.md: otherwise the rounding of r would decide on the target."""
        for levels in (((0, 1),), ((0,), (1,))):
            assert accepted(np.eye(2, 4), np.zeros(2), np.zeros(4), **self.options(levels=levels))

    @pytest.mark.slow
    def test_with_one_level_it_is_the_penalty_of_a_composition(self, rng):
        answers = []
        for _ in range(60):
            J, r, g = rng.normal(size=(2, 4)), 0.1 * rng.normal(size=2), rng.normal(size=4)
            dq = rng.uniform(-0.5, 1.5) * -np.linalg.pinv(J) @ r
            options = self.options(gradient=g, neighbourhood=0.5)
            verdict = verdict_on(J, r, dq, **options)
            model = quadratic_model(J, r, **options)
            reduction = np.linalg.norm(r) - np.linalg.norm(r + J @ dq)
            mu = verdict.state["penalty"]
            expected = penalty_falls(model, mu, model.candidate(casadi.SX(dq)), -g @ dq, reduction)
            answers.append(bool(numbers(verdict.accepted)))
            assert answers[-1] == bool(numbers(expected))
        assert 6 < sum(answers) < 54

"""Compositions: both parts joined within the limits, the three kinds of acceptance, states and figures of a step."""

from __future__ import annotations

from dataclasses import dataclass

import casadi
import numpy as np
import pytest

from jtik.strategy import (
    Composition,
    NullSpaceDisplacement,
    SecondaryTerm,
    Shape,
    TaskDisplacement,
    TaskStep,
    acceptance_beside,
)

from .conftest import numbers, quadratic_model

J = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""The third joint is free."""

R = np.array([0.3, -0.4])
G = np.array([0.0, 0.0, 1.0])
NEWTON = np.append(-R, 0.0)
DOWN = np.array([0.0, 0.0, -0.5])


@dataclass(frozen=True)
class Given(TaskStep):
    """A task step whose displacement is given, and that counts what is accepted of it."""

    dq: object

    def initial_state(self, shape):
        return {"task": np.zeros(1)}

    def propose(self, model, state):
        return TaskDisplacement(casadi.SX(self.dq), alpha=0.7)

    def adapt(self, model, state, task, outcome):
        return {"task": state["task"] + outcome.accepted, "shorten": outcome.shorten_task, "ratio": outcome.ratio}


@dataclass(frozen=True)
class Null(SecondaryTerm):
    """A secondary term whose displacement is given, and that counts what is accepted of it."""

    dq: object
    bounds_itself: bool = False
    task_scale: float = 1.0
    within_limits: bool = False

    def initial_state(self, shape):
        return {"null": np.zeros(1)}

    def propose(self, model, state, task_dq):
        return NullSpaceDisplacement(
            casadi.SX(self.dq), beta=0.2, task_scale=self.task_scale, within_limits=self.within_limits
        )

    def adapt(self, model, state, null_space, outcome):
        return {"null": state["null"] + outcome.accepted, "shorten_null": outcome.shorten_null_space}


@dataclass(frozen=True)
class Pair(Composition):
    step: TaskStep
    secondary: SecondaryTerm
    rule: str = "merit"

    def task_step(self):
        return self.step

    def secondary_term(self):
        return self.secondary

    def acceptance(self):
        return self.rule


def updated(task=NEWTON, null=DOWN, rule="merit", *, criterion=True, penalty=0.0, term=None, **options):
    """The update of a model with R, J and G."""
    model = quadratic_model(J, R, gradient=G if criterion else None, **options)
    names = ("task", "null", "shorten", "ratio", "shorten_null")
    state = {name: casadi.SX(0.0) for name in names} | {"penalty": casadi.SX(penalty)}
    return Pair(Given(task), Null(null, **(term or {})), rule).update(model, state)


def accepted(*arguments, **options):
    return bool(numbers(updated(*arguments, **options).accepted))


@pytest.mark.parametrize(
    ("backtracking", "bounds_itself", "rule"),
    [(True, False, "merit"), (True, True, "task"), (False, False, "always"), (False, True, "always")],
)
def test_the_usual_acceptance(backtracking, bounds_itself, rule):
    assert acceptance_beside(backtracking, Null(DOWN, bounds_itself=bounds_itself)) == rule


class TestState:
    def test_it_is_that_of_both_parts_the_penalty_weight_and_the_allowance(self):
        pair = Pair(Given(NEWTON), Null(DOWN))
        assert set(pair.initial_state(Shape(3, 3, 2, True))) == {"task", "null", "penalty", "allowance"}
        assert set(pair.initial_state(Shape(3, 3, 2, True, timed=True))) == {"task", "null", "penalty"}
        assert set(pair.initial_state(Shape(3, 3, 2, False))) == {"task"}
        assert set(pair.initial_state(Shape(3, 3, 2, False, True))) == {"task", "null"}

    def test_both_parts_learn_the_outcome(self):
        after = updated().state
        assert (numbers(after["task"]), numbers(after["null"])) == (1, 1)
        assert numbers(after["ratio"]) == pytest.approx(1.0)  # the task is linear
        after = updated(-NEWTON).state
        assert (numbers(after["task"]), numbers(after["null"])) == (0, 0)

    @pytest.mark.parametrize(("null", "longer"), [(0.4 * G, False), (0.6 * G, True)])
    def test_the_longer_part_is_to_be_shortened(self, null, longer):
        after = updated(-NEWTON, null).state  # |NEWTON| = 0.5
        assert (bool(numbers(after["shorten"])), bool(numbers(after["shorten_null"]))) == (not longer, longer)


class TestDisplacement:
    def test_it_is_the_sum(self):
        update = updated()
        assert numbers(update.dq) == pytest.approx(NEWTON + DOWN)
        assert numbers(update.null_space) == pytest.approx(DOWN)
        assert numbers(update.wanted) == pytest.approx(NEWTON + DOWN)

    def test_without_a_criterion_it_is_the_task_displacement(self):
        assert numbers(updated(criterion=False).dq) == pytest.approx(NEWTON)

    def test_the_null_space_part_is_shortened_as_a_whole_into_the_limits(self):
        """The task part takes 0.3 of the 0.5 of the first joint; the null-space part wants 0.4 more."""
        null = np.array([-0.4, 0.0, 1.0])
        limits = np.array([-0.5, -9.0, -9.0]), np.full(3, 9.0)
        update = updated(null=null, limits=limits)
        assert numbers(update.null_space) == pytest.approx(0.5 * null)
        assert numbers(update.wanted) == pytest.approx(NEWTON + null)

    def test_a_term_that_respects_the_limits_itself_is_left_alone(self):
        null = np.array([-0.4, 0.0, 1.0])
        limits = np.array([-0.5, -9.0, -9.0]), np.full(3, 9.0)
        update = updated(null=null, limits=limits, term={"within_limits": True})
        assert numbers(update.null_space) == pytest.approx(null)

    def test_a_term_may_take_a_share_of_the_task(self):
        assert numbers(updated(term={"task_scale": 0.25}).dq) == pytest.approx(0.25 * NEWTON + DOWN)

    def test_figures_of_a_trace(self):
        figures = {name: numbers(value) for name, value in updated().figures.items()}
        expected = {"alpha": 0.7, "beta": 0.2, "V2": 0.125, "predicted_decrease": 0.125}
        assert figures == pytest.approx(expected)


class TestMerit:
    def test_away_from_the_target_V_must_fall_by_the_whole_step(self):
        spoiling = np.array([0.6, -0.8, 0.0])  # takes back twice of what the task part gains
        assert accepted(near_target=0)
        assert not accepted(null=spoiling, near_target=0)

    def test_away_from_the_target_H_does_not_count(self):
        assert accepted(null=-DOWN, near_target=0)

    def test_near_the_target_the_exact_penalty_must_fall(self):
        rest = np.zeros(3)
        assert accepted(rest, near_target=1)
        assert not accepted(rest, -DOWN, near_target=1)

    @pytest.mark.parametrize(("side", "penalty"), [(1, 12.0), (-1, 0.1 * 3 / np.sqrt(2))])
    def test_the_penalty_weight_covers_what_the_task_part_costs_the_criterion(self, side, penalty):
        """The task part changes H by 3 and |r| by 0.5; where H rises, half of mu times 0.5 covers the rise."""
        task = NEWTON + np.array([0.0, 0.0, 1.0])
        model = quadratic_model(J, R, gradient=np.array([0.0, 0.0, 3.0 * side]), hessian=np.zeros((3, 3)))
        names = ("task", "null", "penalty", "shorten", "ratio", "shorten_null")
        state = {name: casadi.SX(0.0) for name in names}
        after = Pair(Given(task), Null(np.zeros(3))).update(model, state).state
        assert numbers(after["penalty"]) == pytest.approx(penalty)

    def test_without_a_criterion_V_must_fall(self):
        assert accepted(criterion=False)
        assert not accepted(-NEWTON, criterion=False)
        assert not accepted(np.zeros(3), criterion=False)


class TestTask:
    def test_the_task_part_alone_decides(self):
        assert accepted(null=np.array([0.6, -0.8, 0.0]), rule="task")
        assert not accepted(-NEWTON, rule="task")

    def test_near_the_target_it_may_stay_there(self):
        assert accepted(np.zeros(3), rule="task", near_target=1)
        assert not accepted(np.zeros(3), rule="task", near_target=0)


def test_always_takes_every_step():
    assert accepted(-NEWTON, -DOWN, rule="always")
    pair = Pair(Given(NEWTON), Null(DOWN), "always")
    assert (pair.evaluates_candidate(True), pair.evaluates_candidate(False)) == (True, False)
    assert Pair(Given(NEWTON), Null(DOWN), "merit").evaluates_candidate(False)

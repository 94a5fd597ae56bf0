"""A mistake of a strategy ends in a StrategyError when the solver is built; its message says what to change."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

import casadi
import numpy as np
import pytest

import jtik
from jtik.strategy import (
    Composition,
    LevelMerit,
    NullSpaceDisplacement,
    Programmed,
    Proposal,
    SecondaryTerm,
    Strategy,
    StrategyError,
    TaskDisplacement,
    TaskStep,
    Update,
)
from jtik_formulations import JointCentering, ProjectedGradient

from ..conftest import planar


class Free(Strategy):
    """A strategy whose update is given."""

    def __init__(self, update, first=None):
        self._update, self._first = update, first or {}

    def __repr__(self):
        return "Free()"

    def initial_state(self, shape):
        return self._first

    def update(self, model, state):
        return self._update(model, state)


@dataclass(frozen=True)
class Step(TaskStep):
    answer: object

    def propose(self, model, state):
        return self.answer(model) if callable(self.answer) else self.answer


@dataclass(frozen=True)
class Composed(Composition):
    """A composition whose parts are given."""

    answer: object
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    def __repr__(self):
        return "Composed()"

    def task_step(self):
        return Step(self.answer)

    def secondary_term(self):
        return self.secondary

    def acceptance(self):
        return "merit"


@dataclass(frozen=True)
class Proposing(Programmed):
    """A programmed strategy whose proposal is given."""

    answer: object

    def __repr__(self):
        return "Proposing()"

    def propose(self, model, state):
        return self.answer(model)

    def merit(self):
        return LevelMerit()

    def uses_qp(self, has_criterion):
        return False


def newton(model):
    return model.row_space.least_squares(-model.here.residual).vector


def message(strategy, criteria=None):
    with pytest.raises(StrategyError) as caught:
        jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=strategy, criteria=criteria)
    error = caught.value
    assert error.strategy == repr(strategy)
    assert error.method in str(error)
    assert isinstance(error, jtik.JtikError)
    return str(error)


def test_a_displacement_is_enough():
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=Free(lambda model, state: Update(newton(model))))
    assert ik.solve([1.0, 1.5], q0=[0.3, 0.4, 0.5]).converged
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=Proposing(lambda model: Proposal(newton(model))))
    assert ik.solve([1.0, 1.5], q0=[0.3, 0.4, 0.5]).converged
    ik = jtik.InverseKinematics(
        planar(3), jtik.FrameTask(), strategy=Composed(lambda model: TaskDisplacement(newton(model)))
    )
    assert ik.solve([1.0, 1.5], q0=[0.3, 0.4, 0.5]).converged


@pytest.mark.parametrize(
    ("update", "text"),
    [
        (lambda model, state: None, "Free.update returned None; accepted: an Update"),
        (lambda model, state: newton(model), "Free.update returned SX"),
        (
            lambda model, state: Update(newton(model)[:2]),
            "Free.update returned dq of shape (2, 1); accepted: dq as an expression of shape (3, 1)",
        ),
        (lambda model, state: Update(newton(model).T), "Free.update returned dq of shape (1, 3)"),
        (
            lambda model, state: Update("far"),
            "Free.update returned dq = str 'far'; accepted: dq as an expression of shape (3, 1)",
        ),
        (lambda model, state: Update(None), "Free.update returned dq = None"),
        (
            lambda model, state: Update(newton(model), accepted=newton(model)),
            "returned accepted of shape (3, 1); accepted: accepted as a scalar expression",
        ),
        (lambda model, state: Update(newton(model), null_space=casadi.SX(2, 1)), "null_space of shape (2, 1)"),
        (lambda model, state: Update(newton(model), wanted=casadi.SX(4, 1)), "returned wanted of shape (4, 1)"),
        (
            lambda model, state: Update(newton(model), figures={"gain": newton(model)}),
            "returned figure 'gain' of shape",
        ),
        (
            lambda model, state: Update(newton(model), candidate=model.candidate(2 * newton(model))),
            "returned a candidate that was evaluated for another displacement; accepted: model.candidate(dq)",
        ),
        (lambda model, state: Update(newton(model), candidate=newton(model)), "what model.candidate(dq) returns"),
        (
            lambda model, state: Update(newton(model), state={"radius": 1}),
            "returned a state with names and sizes {'radius': 1}; accepted: those of initial_state, {}",
        ),
        (
            lambda model, state: Update(state["radius"] * newton(model)),
            "state has no entry 'radius'; accepted: one of the states that initial_state returns: []",
        ),
        (lambda model, state: Update(math.sin(model.here.q[0]) * newton(model)), "Free.update raised TypeError"),
        (lambda model, state: Update(np.linalg.pinv(model.J) @ model.here.residual), "Free.update raised"),
        (lambda model, state: Update(model.full_J), "raised AttributeError: 'LocalModel' object has no attribute"),
        (lambda model, state: Update(newton(model) if model.here.V > 1 else -newton(model)), "Free.update raised"),
    ],
)
def test_an_update(update, text):
    found = message(Free(update))
    assert found.startswith("strategy Free(): ")
    assert text in found


def test_what_was_raised_names_the_line():
    def update(model, state):
        return Update(model.nothing)

    assert "in `return Update(model.nothing)` (line" in message(Free(update))


@pytest.mark.parametrize("first", [{"radius": 1.0}, {"radius": [np.nan]}, {"radius": np.zeros((1, 1))}, {1: [0.0]}])
def test_a_first_state(first):
    text = message(Free(lambda model, state: Update(newton(model)), first))
    assert "Free.initial_state returned state" in text
    assert "accepted: names with finite one-dimensional arrays" in text


def test_a_first_state_that_is_no_mapping():
    assert "Free.initial_state returned list" in message(Free(lambda model, state: Update(newton(model)), [1.0]))


@pytest.mark.parametrize(
    ("answer", "text"),
    [
        (None, "Step.propose returned None; accepted: a TaskDisplacement"),
        (lambda model: newton(model), "Step.propose returned SX"),
        (lambda model: TaskDisplacement(newton(model)[1:]), "Step.propose returned dq of shape (2, 1)"),
        (lambda model: TaskDisplacement(math.sqrt(model.here.V)), "Step.propose raised TypeError"),
    ],
)
def test_a_task_step(answer, text):
    assert text in message(Composed(answer))


def test_state_that_adapt_does_not_return_is_kept():
    """A step that is halved from the second update on, whose part of the state nobody adapts."""

    class Kept(Step):
        def initial_state(self, shape):
            return {"share": np.full(1, 0.5)}

        def propose(self, model, state):
            return TaskDisplacement(state["share"] * newton(model))

    class Halved(Composed):
        def task_step(self):
            return Kept(None)

    class Proposes(Proposing):
        def own_state(self, shape):
            return {"share": np.full(1, 0.5)}

        def propose(self, model, state):
            return Proposal(state["share"] * newton(model))

    for strategy in (Halved(None), Proposes(None)):
        ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=strategy)
        errors = ik.solve([1.0, 1.5], q0=[0.3, 0.4, 0.5], max_iterations=8, trace=True).trace.error
        assert errors[-1] / errors[-2] == pytest.approx(0.5, rel=1e-2)


def test_a_secondary_term():
    class Wrong(ProjectedGradient):
        def propose(self, model, state, task_dq):
            return NullSpaceDisplacement(task_dq[:1])

    strategy = Composed(lambda model: TaskDisplacement(newton(model)), Wrong())
    assert "Wrong.propose returned dq of shape (1, 1)" in message(strategy, JointCentering())


@pytest.mark.parametrize(
    ("answer", "text"),
    [
        (lambda model: None, "Proposing.propose returned None; accepted: a Proposal"),
        (lambda model: Proposal(newton(model)[:1]), "Proposing.propose returned dq of shape (1, 1)"),
        (
            lambda model: Proposal(newton(model), task=newton(model).T),
            "Proposing.propose returned task of shape (1, 3)",
        ),
        (lambda model: Proposal(newton(model), wanted=0), "Proposing.propose returned wanted of shape (1, 1)"),
    ],
)
def test_a_proposal(answer, text):
    assert text in message(Proposing(answer))


def test_a_quadratic_program_of_a_strategy_that_uses_none():
    def update(model, state):
        n = model.robot.n
        program = jtik.qp.QuadraticProgram(casadi.SX.eye(n), casadi.SX.ones(n), *model.box, name="mine")
        return Update(model.solve(program).x)

    with pytest.raises(
        jtik.JtikError, match=re.escape("quadratic program 'mine' of a strategy whose uses_qp() is False")
    ):
        jtik.InverseKinematics(planar(3, lower=-1.0, upper=1.0), jtik.FrameTask(), strategy=Free(update))


class TestFormerNames:
    def test_methods_of_a_strategy(self):
        with pytest.warns(DeprecationWarning, match=re.escape("Old.judges is now called evaluates_candidate")):

            class Old(Free):
                def judges(self, has_criterion):
                    return False

        assert Old(None).evaluates_candidate(True) is False

    def test_methods_of_a_secondary_term(self):
        with pytest.warns(DeprecationWarning, match=re.escape("Old.solves_programs is now called uses_qp")):

            class Old(ProjectedGradient):
                def solves_programs(self):
                    return True

        assert Old().uses_qp()

    def test_a_task_move_is_subtracted(self):
        with pytest.warns(DeprecationWarning, match="TaskMove is now called TaskDisplacement, whose dq is added to q"):
            move = jtik.strategy.TaskMove
        found = move(casadi.SX([1.0, -2.0]), casadi.SX([3.0]), 5**0.5)
        assert np.array(casadi.DM(found.dq)).ravel().tolist() == [-1.0, 2.0]
        assert float(found.image) == -3.0

    def test_a_null_move_is_subtracted(self):
        with pytest.warns(DeprecationWarning, match="NullMove is now called NullSpaceDisplacement"):
            move = jtik.strategy.NullMove
        found = move(casadi.SX([1.0]), 1, 2, 3, unsteady=4, keeps_limits=True)
        assert (float(found.dq), found.stationarity_residual, found.within_limits) == (-1.0, 4, True)

    def test_a_point(self):
        with pytest.warns(DeprecationWarning, match="Point is now called Evaluation"):
            assert jtik.strategy.Point is jtik.strategy.Evaluation

    def test_a_name_that_never_was(self):
        with pytest.raises(AttributeError, match="no attribute 'Nothing'"):
            _ = jtik.strategy.Nothing


def test_the_error_travels_to_another_process():
    import pickle

    error = StrategyError("Mine()", "Mine.update", "returned None", "an Update")
    again = pickle.loads(pickle.dumps(error))
    assert str(again) == str(error)

"""Every field and every method of a strategy is checked when the solver is built, with a message that names it."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import casadi
import numpy as np
import pytest

import jtik
from jtik.qp import QuadraticProgram
from jtik.strategy import (
    AdaptiveDamping,
    Composition,
    Merit,
    NullSpaceDisplacement,
    Programmed,
    Proposal,
    SecondaryTerm,
    Strategy,
    StrategyError,
    TaskDisplacement,
    TaskStep,
    Update,
    Verdict,
)
from jtik.symbolic import identity
from jtik_formulations import JointCentering, ProjectedGradient

from ..conftest import planar

FOREIGN = casadi.SX.sym("foreign", 3)
WRONG = {
    "a text": "x",
    "two rows": casadi.SX.zeros(2, 1),
    "a dict with a number": {1: 2},
    "a function": len,
    "MX": casadi.MX(1),
}
"""What no field accepts."""


def newton(model):
    return model.row_space.least_squares(-model.here.residual).vector


def given(answer, *arguments):
    """The answer, or what it returns for these arguments."""
    return answer(*arguments) if callable(answer) else answer


class Free(Strategy):
    """A strategy whose update is given, and whose other methods are those of ``methods``."""

    def __init__(self, update=lambda model: Update(newton(model)), first=None, **methods):
        self._update, self._first = update, first or {}
        for name, method in methods.items():
            setattr(self, name, method)

    def __repr__(self):
        return "Free()"

    def initial_state(self, shape):
        return self._first

    def update(self, model, state):
        return self._update(model)


@dataclass(frozen=True)
class Step(TaskStep):
    proposal: object = lambda model: TaskDisplacement(newton(model))
    first: object = None
    after: object = None

    def initial_state(self, shape):
        return self.first or {}

    def propose(self, model, state):
        return given(self.proposal, model)

    def adapt(self, model, state, task, outcome):
        return {} if self.after is None else given(self.after, model)


@dataclass(frozen=True)
class Term(SecondaryTerm):
    proposal: object = lambda model: NullSpaceDisplacement(-0.1 * model.null_gradient)
    corrected: object = None

    def propose(self, model, state, task_dq):
        return given(self.proposal, model)

    def correct(self, model, dq):
        return dq if self.corrected is None else given(self.corrected, model)


@dataclass(frozen=True)
class Composed(Composition):
    step: object = Step()
    term: object = ProjectedGradient()
    accepts: object = "merit"

    def __repr__(self):
        return "Composed()"

    def task_step(self):
        return self.step

    def secondary_term(self):
        return self.term

    def acceptance(self):
        return self.accepts


@dataclass(frozen=True)
class Decrease(Merit):
    outcome: object = lambda model, candidate: Verdict(candidate.V < model.here.V)

    def verdict(self, model, state, proposal, candidate):
        return given(self.outcome, model, candidate)


@dataclass(frozen=True)
class Proposing(Programmed):
    proposal: object = lambda model: Proposal(newton(model))
    chosen_merit: object = Decrease()
    shortened: object = None
    term: object = None

    def __repr__(self):
        return "Proposing()"

    def propose(self, model, state):
        return given(self.proposal, model)

    def merit(self):
        return given(self.chosen_merit)

    def shortening(self):
        return self.shortened

    def secondary_term(self):
        return self.term


def message(strategy, *, criteria=None):
    with pytest.raises(StrategyError) as caught:
        jtik.InverseKinematics(planar(3, lower=-2.0, upper=2.0), jtik.FrameTask(), strategy=strategy, criteria=criteria)
    return str(caught.value)


@pytest.mark.thinned
@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
@pytest.mark.parametrize("name", [field.name for field in fields(Update)])
def test_a_field_of_an_update(name, wrong):
    text = message(Free(lambda model: Update(**{"dq": newton(model), name: wrong})))
    assert text.startswith("strategy Free(): Free.update returned ")
    assert name.rstrip("s") in text
    assert "accepted: " in text


@pytest.mark.thinned
@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
@pytest.mark.parametrize("name", [field.name for field in fields(TaskDisplacement)])
def test_a_field_of_a_task_displacement(name, wrong):
    if name == "image" and wrong is WRONG["two rows"]:
        pytest.skip("an image has two rows")
    text = message(Composed(Step(lambda model: TaskDisplacement(**{"dq": newton(model), name: wrong}))))
    assert f"Step.propose returned {name}" in text


@pytest.mark.thinned
@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
@pytest.mark.parametrize("name", [field.name for field in fields(NullSpaceDisplacement)])
def test_a_field_of_a_null_space_displacement(name, wrong):
    term = Term(lambda model: NullSpaceDisplacement(**{"dq": model.null_gradient, name: wrong}))
    assert f"Term.propose returned {name}" in message(Composed(term=term), criteria=JointCentering())


@pytest.mark.thinned
@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
@pytest.mark.parametrize("name", [field.name for field in fields(Proposal)])
def test_a_field_of_a_proposal(name, wrong):
    if name == "state" and wrong is WRONG["a dict with a number"]:
        pytest.skip("any mapping is passed on to adapt")
    text = message(Proposing(lambda model: Proposal(**{"dq": newton(model), name: wrong})))
    assert f"Proposing.propose returned {name}" in text


@pytest.mark.thinned
@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
@pytest.mark.parametrize("name", [field.name for field in fields(Verdict)])
def test_a_field_of_a_verdict(name, wrong):
    text = message(Proposing(chosen_merit=Decrease(lambda model, candidate: Verdict(**{"accepted": 1, name: wrong}))))
    assert f"Decrease.verdict returned {'a state' if wrong == {1: 2} and name == 'state' else name}" in text


def test_a_field_inside_a_proposal_has_its_whole_name():
    text = message(
        Proposing(lambda model: Proposal(newton(model), null_space=NullSpaceDisplacement(newton(model), "x")))
    )
    assert "Proposing.propose returned null_space.length = str 'x'; accepted: null_space.length as a scalar" in text


@pytest.mark.parametrize(
    ("strategy", "text"),
    [
        (Composed(step=None), "Composed.task_step returned None; accepted: a TaskStep"),
        (Composed(term=None), "Composed.secondary_term returned None; accepted: a SecondaryTerm"),
        (Composed(term=Step()), "Composed.secondary_term returned Step"),
        (
            Composed(accepts="maybe"),
            "Composed.acceptance returned str 'maybe'; accepted: 'merit' or 'task' or 'always'",
        ),
        (Composed(accepts=None), "Composed.acceptance returned None"),
        (Composed(Step(first=[1.0])), "Step.initial_state returned list [1.0]; accepted: a Mapping"),
        (Composed(Step(after=[1.0])), "Step.adapt returned list [1.0]; accepted: a Mapping"),
        (Composed(Step(after={"gain": 1.0})), "Step.adapt returned a state with the name str 'gain'; accepted: states"),
        (Composed(Step(first={"g": [1.0]}, after={"g": None})), "Step.adapt returned state 'g' = None"),
        (
            Composed(Step(first={"g": [1.0]}, after=lambda model: {"g": newton(model)})),
            "Step.adapt returned state 'g' of",
        ),
        (Composed(term=Term(corrected="x")), "Term.correct returned dq = str 'x'"),
        (Composed(term=Term(corrected=lambda model: newton(model).T)), "Term.correct returned dq of shape (1, 3)"),
        (Proposing(chosen_merit=1), "Proposing.merit returned int 1; accepted: Merit, or None"),
        (Proposing(chosen_merit=lambda: 1 / 0), "Proposing.merit raised ZeroDivisionError: division by zero in `"),
        (Proposing(chosen_merit=Decrease(None)), "Decrease.verdict returned None; accepted: a Verdict"),
        (
            Proposing(shortened=0.5),
            "Proposing.shortening returned float 0.5; accepted: AdaptiveDamping or Backtracking",
        ),
        (Proposing(term="qp"), "Proposing.secondary_term returned str 'qp'; accepted: SecondaryTerm, or None"),
        (Free(uses_qp=lambda has_criterion: None), "Free.uses_qp returned None; accepted: True or False"),
        (Free(uses_qp=lambda: True), "Free.uses_qp raised TypeError"),
        (Free(uses_qp=True), "Free.uses_qp raised TypeError: 'bool' object is not callable"),
        (Free(evaluates_candidate=lambda has_criterion: 1), "Free.evaluates_candidate returned int 1"),
        (Free(update=None), "Free.update raised TypeError: 'NoneType' object is not callable"),
    ],
)
def test_a_method(strategy, text):
    assert text in message(strategy, criteria=JointCentering())


@pytest.mark.parametrize(
    ("state", "text"),
    [
        ("x", "Free.update returned state = str 'x'; accepted: a Mapping"),
        ({"radius": None}, "Free.update returned state 'radius' = None"),
        ({"radius": "x"}, "Free.update returned state 'radius' = str 'x'"),
        ({"radius": casadi.SX.zeros(1, 2)}, "Free.update returned state 'radius' of shape (1, 2)"),
    ],
)
def test_a_state(state, text):
    strategy = Free(lambda model: Update(newton(model), state=state), {"radius": np.ones(2)})
    assert text in message(strategy)


@pytest.mark.parametrize(
    ("update", "text"),
    [
        (lambda model: Update(np.full(3, np.nan)), "returned dq with entry 0 = nan; accepted: finite entries"),
        (lambda model: Update(casadi.MX.sym("x", 3)), "returned dq of type MX; accepted: dq as an expression of shape"),
        (
            lambda model: Update(newton(model) + FOREIGN),
            "returned dq that depends on symbols of something else: foreign_0",
        ),
        (
            lambda model: Update(newton(model), figures={"gain": FOREIGN[1]}),
            "returned figures['gain'] that depends on symbols of something else: foreign_1; "
            "accepted: expressions of the model and the state",
        ),
        (lambda model: Update(newton(model), figures={"V": 1.0}), "returned a figure 'V'; accepted: names of figures"),
        (
            lambda model: Update(newton(model), relaxed={"task": 1.0}),
            "returned relaxed with the key str 'task'; accepted: keys (name, unit), two texts each",
        ),
        (lambda model: Update(newton(model), relaxed={("task", 1): 1.0}), "returned relaxed with the key tuple"),
    ],
)
def test_an_update(update, text):
    assert text in message(Free(update))


@pytest.mark.parametrize("name", ["P", "q", "lower", "upper"])
@pytest.mark.parametrize("wrong", ["text", "of two rows", "of foreign symbols"])
def test_a_quadratic_program(name, wrong):
    foreign = identity(3) * FOREIGN[0] if name == "P" else FOREIGN
    value = {"text": "x", "of two rows": casadi.SX.zeros(2, 1), "of foreign symbols": foreign}[wrong]

    def propose(model):
        (lower, upper), J = model.box, model.J
        data = {"P": J.T @ J + identity(3), "q": J.T @ model.here.residual, "lower": lower, "upper": upper}
        return Proposal(model.solve(QuadraticProgram(**{**data, name: value})).x)

    text = message(Proposing(propose, shortened=AdaptiveDamping(4.0, 0.25)))
    assert text.startswith("strategy Proposing(): Proposing.")


def test_a_quadratic_program_that_is_none():
    text = message(Proposing(lambda model: Proposal(model.solve(None).x)))
    assert "Proposing.propose raised ArgumentError: qp: given None; accepted: a jtik.qp.QuadraticProgram" in text


def test_a_repr_that_raises_does_not_hide_the_mistake():
    class Mute(Free):
        def __repr__(self):
            raise RuntimeError("no words")

    assert "strategy <Mute>: Mute.update returned None; accepted: an Update" in message(Mute(lambda model: None))


def test_an_error_about_the_strategys_own_arguments_is_passed_on():
    def update(model):
        raise jtik.errors.ArgumentError("groups", 3, "groups that hold each row once")

    with pytest.raises(jtik.errors.ArgumentError, match="groups: given 3"):
        jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=Free(update))


def test_numbers_and_arrays_are_expressions_too():
    strategy = Free(
        lambda model: Update([0.0, 0, 0], accepted=np.True_, null_space=np.zeros(3), figures={"mu": math.nan})
    )
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=strategy)
    assert ik.step([0.1, 0.2, 0.3], [1.0, 1.0]).q.tolist() == [0.1, 0.2, 0.3]


def test_a_class_is_no_strategy():
    accepted = r"strategy: given the class Composed; accepted: an object of it, Composed\(\); or a jtik.Strategy"
    with pytest.raises(jtik.errors.ArgumentError, match=accepted):
        jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=Composed)

"""A criterion that gives value and gradient together gives those of its value."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.criterion import CriterionError
from jtik.symbolic import sumsqr, symbol
from jtik.testing import check_criterion


class Squares(jtik.Criterion):
    """H = |q|^2, with a gradient of its own: a multiple of the right one."""

    name = "squares"

    def __init__(self, factor: float = 1.0, offset: float = 0.0) -> None:
        self.factor, self.offset = factor, offset

    def value(self, kinematics, parameters):
        return sumsqr(kinematics.q)

    def value_and_gradient(self, kinematics, parameters):
        return sumsqr(kinematics.q) + self.offset, 2 * self.factor * kinematics.q


ARM = jtik.Robot.planar(3)


def test_one_that_agrees_is_accepted():
    check_criterion(Squares(), ARM, samples=2)


@pytest.mark.parametrize(
    ("wrong", "message"), [({"factor": 1.01}, "gradient"), ({"offset": 0.1}, "value_and_gradient")]
)
def test_one_that_differs_is_not(wrong, message):
    with pytest.raises(AssertionError, match=message):
        check_criterion(Squares(**wrong), ARM, samples=2)


class Cubes(Squares):
    """A subclass with another value."""

    def value(self, kinematics, parameters):
        return sumsqr(kinematics.q) ** 2


def test_a_subclass_with_another_value_has_the_gradient_of_that():
    check_criterion(Cubes(), ARM, samples=2)


class Answers(Squares):
    """It returns anything."""

    def __init__(self, answer):
        super().__init__()
        self.answer = answer

    def value(self, kinematics, parameters):
        return sumsqr(kinematics.q)

    def value_and_gradient(self, kinematics, parameters):
        return self.answer(kinematics.q)


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (lambda q: sumsqr(q), "H and its gradient"),
        (lambda q: (q, 2 * q), "a scalar"),
        (lambda q: (sumsqr(q), 2 * q[:2]), "3 entries"),
        (lambda q: (sumsqr(q), symbol("other", 3)), "not its own"),
        (lambda q: (sumsqr(q), float(q[0])), "CasADi cannot trace"),
        (lambda q: [sumsqr(q), 2 * q.T], None),
        (lambda q: (np.sin(q[0]) + sumsqr(q) - np.sin(q[0]), 2 * q), None),
        (lambda q: None, None),
    ],
)
def test_what_is_no_value_and_gradient_is_refused(answer, message):
    def build():
        return jtik.InverseKinematics(ARM, jtik.FrameTask("tip", "position"), criteria=Answers(answer))

    if message is None:
        assert build().solve([1.0, 1.0], q0=[0.1, 0.2, 0.3]).converged
        return
    with pytest.raises(CriterionError, match=message):
        build()

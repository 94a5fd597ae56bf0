"""A criterion that gives value and gradient together gives those of its value."""

from __future__ import annotations

import pytest

import jtik
from jtik.symbolic import sumsqr
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

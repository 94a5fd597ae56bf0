"""A criterion as a subclass."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik

from ..conftest import EXACT, planar
from .shared import at, solver


class TestSubclass:
    def test_a_class_of_ones_own(self, rng):
        class Reach(jtik.Criterion):
            name = "reach"

            def parameters(self, robot):
                return {"wanted": np.array([[1.0, 2.0], [0.0, 1.0]])}

            def value(self, kinematics, parameters):
                away = parameters["wanted"] @ kinematics.position("link3")
                return casadi.sumsqr(away)

        robot = planar(4)
        ik = solver(robot, Reach())
        q = robot.random_configuration(rng)
        matrix = np.array([[1.0, 2.0], [0.0, 1.0]])
        assert at(ik, q).cost == pytest.approx(np.sum((matrix @ robot.position(q, "link3")) ** 2), rel=EXACT)
        matrix = np.array([[0.0, -1.0], [3.0, 1.0]])
        ik.parameters["reach.wanted"] = matrix
        assert at(ik, q).cost == pytest.approx(np.sum((matrix @ robot.position(q, "link3")) ** 2), rel=EXACT)

    @pytest.mark.parametrize("value", [np.nan, [np.inf], np.zeros((2, 2, 2))])
    def test_first_values_that_are_not_finite_or_have_too_many_axes_are_refused(self, value):
        class Odd(jtik.Criterion):
            name = "odd"

            def parameters(self, robot):
                return {"p": value}

            def value(self, kinematics, parameters):
                return kinematics.q[0]

        with pytest.raises(jtik.ArgumentError, match=r"odd\.p"):
            solver(planar(2), Odd())

"""Limits of another library as rows: those without a bound are left out, or kept harmless in a quadratic program."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.interop.limit_rows import Inequality, LimitRows
from jtik.qp import Elastic, QuadraticProgram
from jtik.strategy import Strategy, Update
from jtik.symbolic import identity

from ..conftest import planar

Q = np.array([0.4, -0.3, 0.8])


class FirstJoint(LimitRows):
    """|dq_0| <= dt on the first joint, and a row without a bound that NaN in G makes useless."""

    library = "test"

    def __init__(self, robot, dt):
        super().__init__(robot, dt)
        self._dt = dt

    def _all(self, q):
        G = np.array([[1.0, 0, 0], [np.nan] * 3, [-1.0, 0, 0]])
        return Inequality(G, np.array([self._dt, np.inf, self._dt]))


def test_rows_without_a_bound_are_left_out():
    G, h = FirstJoint(planar(3), 0.01)(Q)
    assert G.tolist() == [[1, 0, 0], [-1, 0, 0]]
    assert h.tolist() == [0.01, 0.01]


def test_the_configuration_is_checked():
    with pytest.raises(jtik.ArgumentError, match="q"):
        FirstJoint(planar(3), 0.01)([0.1, 0.2])


@pytest.mark.parametrize("dt", [0.0, -0.1, np.inf, np.nan])
def test_the_duration_of_a_step_is_positive(dt):
    with pytest.raises(jtik.ArgumentError, match=r"dt: given .*; accepted: a positive time \[s\]"):
        FirstJoint(planar(3), dt)


class Limited(Strategy):
    """Damped least squares within the rows of a limit."""

    def __init__(self, limit, elastic=None):
        self._limit, self._elastic, self.rows = limit, elastic, None

    def uses_qp(self, has_criterion):
        return True

    def update(self, model, state):
        self.rows = self._limit.rows(model, elastic=self._elastic)
        J, (low, high) = model.J, model.box
        P = J.T @ J + 1e-3 * identity(3)
        return Update(model.solve(QuadraticProgram(P, J.T @ model.here.residual, low, high, [self.rows])).x)


def first_step(elastic=None):
    strategy = Limited(FirstJoint(planar(3), 0.01), elastic)
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=strategy)
    return strategy.rows, ik.step(Q, planar(3).position(Q + 0.2)).q - Q


def test_in_a_quadratic_program_they_hold_and_the_number_of_rows_is_constant():
    rows, dq = first_step()
    assert (rows.name, rows.count, rows.elastic) == ("test limit", 3, None)
    assert dq[0] == pytest.approx(0.01, abs=1e-9)


def test_elastic_rows_may_be_violated():
    rows, dq = first_step(Elastic(1e-6))
    assert rows.elastic == Elastic(1e-6)
    assert dq[0] > 0.02

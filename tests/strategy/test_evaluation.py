"""An evaluation: the Lyapunov function of the task and the norm of its residual."""

from __future__ import annotations

import casadi
import pytest

from jtik.strategy import Evaluation

from .conftest import numbers


def test_V_and_the_norm_of_the_residual():
    found = Evaluation(casadi.SX([0.0]), casadi.SX([3.0, -4.0]), casadi.SX(7.0))
    assert numbers(found.V) == 12.5
    assert numbers(found.length) == pytest.approx(5.0)
    assert found.dq is None


def test_the_norm_has_a_derivative_on_the_target():
    r = casadi.SX.sym("r", 2)
    derivative = casadi.Function("f", [r], [casadi.jacobian(Evaluation(r, r, 0).length, r)])
    assert derivative([0, 0]).full().ravel().tolist() == [0, 0]
    assert derivative([3, 4]).full().ravel() == pytest.approx([0.6, 0.8])

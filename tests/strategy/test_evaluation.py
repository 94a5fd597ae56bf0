"""An evaluation: the Lyapunov function of the task and the norm of its residual."""

from __future__ import annotations

from fractions import Fraction

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


class TestTheDecreaseOfV:
    @staticmethod
    def exact(target, before, after):
        """V before less V after, in fractions, of positions and a target."""
        V = [sum((Fraction(p) - Fraction(t)) ** 2 for p, t in zip(q, target, strict=True)) / 2 for q in (before, after)]
        return float(V[0] - V[1])

    @pytest.mark.parametrize("distance", [0.0, 1.0, 1e4, 1e9, 1e100])
    def test_it_is_accurate_however_distant_the_target(self, distance):
        target, before, after = (distance, 0.3 * distance), (0.7, 0.2), (0.7 + 1e-9, 0.2 - 1e-12)
        here, there = (
            Evaluation(None, casadi.SX([p - t for p, t in zip(q, target, strict=True)]), 0, unshifted=casadi.SX(q))
            for q in (before, after)
        )
        assert numbers(here.decrease(there)) == pytest.approx(self.exact(target, before, after), rel=1e-6)

    def test_without_the_unshifted_residual_it_is_the_difference(self):
        here, there = Evaluation(None, casadi.SX([3.0, -4.0]), 0), Evaluation(None, casadi.SX([1.0, 1.0]), 0)
        assert numbers(here.change(there)).tolist() == [-2.0, 5.0]
        assert numbers(here.decrease(there)) == pytest.approx(11.5)


def test_the_residual_to_the_target_itself():
    near = Evaluation(None, casadi.SX([1.0, 0.0]), 0)
    assert numbers(near.V_to_target) == 0.5
    distant = Evaluation(None, casadi.SX([1.0, 0.0]), 0, whole=casadi.SX([6.0, 0.0]))
    assert (numbers(distant.V), numbers(distant.V_to_target)) == (0.5, 18.0)
    assert numbers(distant.to_target).tolist() == [6.0, 0.0]

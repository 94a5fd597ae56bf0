"""Gradients in which parts of an expression are constants."""

from __future__ import annotations

import casadi
import numpy as np

from jtik.symbolic import function, gradient, sumsqr, symbol
from jtik.symbolic.held import not_held, value_and_gradients


def test_a_minimum_has_the_same_gradient_with_its_point_held(rng):
    """The squared distance of a point from a line through the origin, at the closest share."""

    def distance(point, along, hold):
        share = hold(casadi.dot(point, along) / hold(sumsqr(along)))
        return sumsqr(point - share * along)

    point, along = symbol("point", 3), symbol("along", 3)
    value, gradients = value_and_gradients(lambda hold: distance(point, along, hold), [point, along])
    whole = distance(point, along, not_held)
    held = function("held", [point, along], [value, *gradients])
    derived = function("derived", [point, along], [whole, gradient(whole, point), gradient(whole, along)])
    for _ in range(10):
        at = rng.normal(size=3), rng.normal(size=3)
        for one, other in zip(held(*at), derived(*at), strict=True):
            np.testing.assert_allclose(one.full(), other.full(), atol=1e-12)
    assert held.n_instructions() < derived.n_instructions()


def test_what_is_held_is_a_constant():
    x = symbol("x", 1)
    value, (slope,) = value_and_gradients(lambda hold: hold(x) * x, [x])
    f = function("f", [x], [value, slope])
    assert [float(each) for each in f(3.0)] == [9.0, 3.0]

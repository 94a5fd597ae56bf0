"""A function of scalars for many columns at once: what it is for each of them."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.symbolic.many_columns import of_many

COUNT = 7


def test_every_column_is_that_of_the_function(rng):
    x, y = casadi.SX.sym("x", 2), casadi.SX.sym("y", 3)
    chosen = casadi.if_else(x[0] > y[1], casadi.sqrt(casadi.fabs(x[1])), casadi.fmin(y[0], -y[2]))
    outputs = [casadi.vertcat(chosen, 2.5, x[1]), casadi.sumsqr(y) / (1 + x[0] ** 2)]
    function = casadi.Function("one", [x, y], outputs)
    columns, shared = casadi.MX.sym("columns", 2, COUNT), casadi.MX.sym("shared", 3)
    found = of_many(function, [[columns[i, :] for i in range(2)], [shared[i] for i in range(3)]])
    wide = [casadi.vertcat(*[casadi.repmat(row, 1, COUNT // row.shape[1]) for row in rows]) for rows in found]
    many = casadi.Function("many", [columns, shared], wide)
    given, same = rng.normal(size=(2, COUNT)), rng.normal(size=3)
    results = [np.array(each) for each in many(given, same)]
    for i in range(COUNT):
        expected = [np.array(each).ravel() for each in function(given[:, i], same)]
        assert results[0][:, i] == pytest.approx(expected[0])
        assert results[1][:, i] == pytest.approx(expected[1])

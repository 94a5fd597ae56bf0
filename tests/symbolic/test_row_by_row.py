"""A function of one column for the rows of a matrix: what it is for each of them, and in generated C the same bits."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.symbolic import c_source
from jtik.symbolic.compile import CompilerError, bind, compiler, to_c
from jtik.symbolic.row_by_row import row_by_row


def one():
    """A function of all that distances are made of, with outputs that depend on nothing."""
    x = casadi.SX.sym("x", 5)
    chosen = casadi.if_else(x[0] > x[3], casadi.sqrt(casadi.fabs(x[1])), casadi.fmin(x[2], -x[4]))
    either = casadi.logic_and(x[0] <= 0, x[1] < 1) + casadi.logic_not(x[2] > 0)
    return casadi.Function("one", [x], [casadi.vertcat(chosen, 2.5, x[1], casadi.sumsqr(x) / (1 + x[0] ** 2), either)])


def of_rows(function, count):
    rows = casadi.MX.sym("rows", count, function.size1_in(0))
    return casadi.Function("many", [rows], [row_by_row(function, rows)])


@pytest.mark.parametrize("count", [1, 2, 7, 60])
def test_every_row_is_that_of_the_function(count, rng):
    function = one()
    many, given = of_rows(function, count), rng.normal(size=(count, 5))
    expected = [np.array(function(column)).ravel() for column in given]
    assert np.array(many(given)) == pytest.approx(np.array(expected))


@pytest.mark.parametrize("count", [2, 7, 60])
@pytest.mark.parametrize("outputs", [5, 1])
def test_generated_c_has_one_loop_and_the_same_bits(outputs, count, rng, tmp_path, monkeypatch):
    try:
        compiler()
    except CompilerError:
        pytest.skip("needs a C compiler")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    function = one()
    if outputs == 1:
        x = casadi.SX.sym("x", 5)
        function = casadi.Function("first", [x], [function(x)[0]])
    many = of_rows(function, count)
    assert f"for (i=0; i<{count}; ++i)" in c_source(many)
    compiled = to_c(many)
    for value in (0.5, np.nan, np.inf):
        given = rng.normal(size=(count, 5))
        given[-1, 2] = value
        results = [np.full(many.numel_out(0), 9.0) for _ in range(2)]
        for each, result in zip((many, compiled), results, strict=True):
            bind(each, [given.ravel(order="F")], [result])()
        np.testing.assert_array_equal(*results)

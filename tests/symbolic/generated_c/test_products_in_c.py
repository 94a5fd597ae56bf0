"""Products of matrices in generated C with loops of jtik's own: the bits of CasADi's, whatever the shapes."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.symbolic import c_source, sum1
from jtik.symbolic.block_products import block_products
from jtik.symbolic.compile import CompilerError, bind, compiler, to_c
from jtik.symbolic.stacked_rows import stacked

try:
    compiler()
except CompilerError:
    pytest.skip("needs a C compiler", allow_module_level=True)

SHAPES = [
    (1, 5, 1),
    (1, 7, 3),
    (1, 160, 4),
    (1, 33, 9),
    (2, 3, 4),
    (3, 10, 3),
    (5, 4, 1),
    (16, 6, 11),
    (37, 9, 2),
    (1, 33, 19),
]


def evaluated(function, arguments):
    results = [np.full(function.numel_out(i), 9.0) for i in range(function.n_out())]
    bind(function, [np.ravel(each, order="F") for each in arguments], results)()
    return results


def compared(function, rng, *, repeats=5):
    """Whether C and the virtual machine return the same bits, also for numbers that are not finite."""
    compiled = to_c(function)
    for repeat in range(repeats):
        given = [rng.normal(size=function.size_in(i)) * 10.0 ** rng.integers(-9, 9) for i in range(function.n_in())]
        if repeat == 1:
            given[0].flat[0] = np.inf
        if repeat == 2:
            given[1].flat[-1] = np.nan
        for one, other in zip(evaluated(compiled, given), evaluated(function, given), strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(("m", "k", "n"), SHAPES)
def test_dense_products(m, k, n, rng, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    x, y, z = casadi.MX.sym("x", m, k), casadi.MX.sym("y", k, n), casadi.MX.sym("z", m, n)
    function = casadi.Function("product", [x, y, z], [x @ y, casadi.mac(x, y, z)])
    assert "casadi_mtimes_dense" in c_source(function)
    compared(function, rng)


@pytest.mark.parametrize(
    ("blocks", "rows", "more", "e", "n"),
    [(1, 1, 0, 2, 2), (1, 5, 1, 3, 4), (3, 4, 1, 4, 7), (10, 16, 0, 6, 10), (4, 1, 2, 2, 3)],
)
def test_block_products(blocks, rows, more, e, n, rng, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    x, y = casadi.MX.sym("x", blocks * rows, more + e), casadi.MX.sym("y", e, blocks * n)
    function = casadi.Function("products", [x, y], [block_products(x, y, blocks)])
    assert "for (b=0; b<" in c_source(function)
    compared(function, rng)
    A, B = rng.normal(size=(blocks * rows, more + e)), rng.normal(size=(e, blocks * n))
    pairs = zip(np.split(A[:, more:], blocks), np.split(B, blocks, axis=1), strict=True)
    expected = np.vstack([one @ other for one, other in pairs])
    assert np.array(function(A, B)) == pytest.approx(expected)


@pytest.mark.parametrize("counts", [(2, 640), (3,), (1, 1, 4)])
@pytest.mark.parametrize("n", [1, 7])
def test_stacked_rows(counts, n, rng, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    symbols = [casadi.MX.sym(f"m{i}", count, n) for i, count in enumerate([*counts, 1])]
    function = casadi.Function("stack", symbols, [stacked(*symbols[:-1])])
    assert ("*to++ = arg[1]" in c_source(function)) == (len(counts) > 1 and n > 1)
    compared(function, rng)
    given = [rng.normal(size=(count, n)) for count in (*counts, 1)]
    assert np.array_equal(np.array(function(*given)), np.vstack(given[:-1]))


PICKED = {
    "one number again and again": [3] * 40 + [0] * 9,
    "one after the other": [*range(5, 25), *range(12)],
    "every third, forwards and backwards": [*range(0, 60, 3), *range(59, -1, -3)],
    "a single one at the end": [*range(30), 7],
    "none of a pattern": [7, 3, 59, 1, 1, 2, 40, 8, 9, 21, 0, 5, 33],
}


@pytest.mark.parametrize("kind", PICKED)
def test_picked_numbers(kind, rng, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    x, y = casadi.MX.sym("x", 60), casadi.MX.sym("y")
    function = casadi.Function("picked", [x, y], [casadi.sin(x)[PICKED[kind]] + y])
    compared(function, rng)
    values = rng.normal(size=60)
    assert np.array(function(values, 0)).ravel() == pytest.approx(np.sin(values)[PICKED[kind]])


def test_many_picked_numbers_are_runs():
    x = casadi.MX.sym("x", 60)
    function = casadi.Function("picked", [x], [x[PICKED["one number again and again"]], x[PICKED["none of a pattern"]]])
    source = c_source(function)
    assert source.count("JTIK_RUNS(") == 2  # the function, and a call
    assert "{3, 0, 40, 0, 0, 9}" in source
    assert "cs[*cii]" in source


@pytest.mark.parametrize("count", [1, 127, 128, 200])
def test_sums_of_columns(count, rng, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    x, y = casadi.MX.sym("x", count), casadi.MX.sym("y", count, 3)
    function = casadi.Function("sums", [x, y], [sum1(x), sum1(y)])
    compared(function, rng)
    values = rng.normal(size=count)
    assert float(function(values, 0)[0]) == pytest.approx(values.sum())
    assert float(sum1(casadi.SX(values))) == pytest.approx(values.sum())


def test_picked_numbers_that_are_an_output(rng, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    x, y = casadi.MX.sym("x", 60), casadi.MX.sym("y")
    picked = casadi.sin(x)[PICKED["one number again and again"]]
    function = casadi.Function("picked", [x, y], [picked, 2 * y])
    assert "  if (res[0]) JTIK_RUNS(res[0], " in c_source(casadi.Function("alone", [x], [picked]))
    compared(function, rng)
    compared(casadi.Function("alone", [x, y], [picked]), rng)
    compiled, found = to_c(casadi.Function("alone", [x], [picked])), np.full(60, 9.0)
    bind(compiled, [found], [np.zeros(0)])()  # nobody asks for the output

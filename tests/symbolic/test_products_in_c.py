"""Products of matrices in generated C with loops of jtik's own: the bits of CasADi's, whatever the shapes."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.symbolic import c_source
from jtik.symbolic.block_products import block_products
from jtik.symbolic.compile import CompilerError, bind, compiler, to_c

try:
    compiler()
except CompilerError:
    pytest.skip("needs a C compiler", allow_module_level=True)

SHAPES = [(1, 5, 1), (1, 7, 3), (1, 160, 4), (1, 33, 9), (2, 3, 4), (3, 10, 3), (5, 4, 1), (16, 6, 11)]


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
    ("blocks", "rows", "e", "n"), [(1, 1, 2, 2), (1, 5, 3, 4), (3, 4, 4, 7), (10, 16, 6, 10), (4, 1, 2, 3)]
)
def test_block_products(blocks, rows, e, n, rng, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    x, y = casadi.MX.sym("x", blocks * rows, e), casadi.MX.sym("y", e, blocks * n)
    function = casadi.Function("products", [x, y], [block_products(x, y, blocks)])
    assert "for (b=0; b<" in c_source(function)
    compared(function, rng)
    A, B = rng.normal(size=(blocks * rows, e)), rng.normal(size=(e, blocks * n))
    pairs = zip(np.split(A, blocks), np.split(B, blocks, axis=1), strict=True)
    expected = np.vstack([one @ other for one, other in pairs])
    assert np.array(function(A, B)) == pytest.approx(expected)

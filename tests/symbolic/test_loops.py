"""Products as a call with loops in it: the numbers of what is written out, in a text that does not grow with them."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.symbolic import looped, symbol
from jtik.symbolic.generated_c import c_source

from ..conftest import EXACT


def cube(A, b):
    """The third power of a matrix, and its product with a vector."""
    third = A @ A @ A
    return third, third @ b


def of(n, *, loops):
    given = [symbol("A", n, n), symbol("b", n)]
    return casadi.Function("f", given, looped(cube, *given, when=loops))


@pytest.mark.parametrize("loops", [True, False])
@pytest.mark.parametrize("n", [1, 2, 5, 20])
def test_they_are_those_of_numpy(n, loops, rng):
    A, b = rng.normal(size=(n, n)), rng.normal(size=n)
    third, product = (np.array(each) for each in of(n, loops=loops)(A, b))
    expected = np.linalg.matrix_power(A, 3)
    assert third == pytest.approx(expected, abs=EXACT * n**2)
    assert product.ravel() == pytest.approx(expected @ b, abs=EXACT * n**2)


def test_a_sparse_argument():
    A = casadi.diag(symbol("d", 3))
    f = casadi.Function("f", casadi.symvar(A), looped(cube, A, casadi.SX([1, 0, 2])))
    assert np.array(f(1.0, 2.0, 3.0)[1]).ravel().tolist() == [1.0, 0.0, 54.0]


def test_the_text_grows_with_the_entries_and_not_with_the_products():
    """Four times as many lines for twice as many rows: those that pass the entries on."""
    sources = [c_source(of(n, loops=True)).split("\n") for n in (20, 40)]
    lines = [sum("v[" not in line for line in each) for each in sources]  # v: what parts of a function share
    written_out = of(20, loops=False).n_instructions()
    assert lines[1] <= 4 * lines[0]
    assert lines[0] < written_out / 5

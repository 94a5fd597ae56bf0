"""The modified factorisation in a form of its own in generated C: the numbers are those of the virtual machine."""

from __future__ import annotations

import numpy as np
import pytest

from jtik.symbolic import MX, function
from jtik.symbolic.compile import CompiledFunction, CompilerError, compiler, library
from jtik.symbolic.convexified import convexified
from jtik.symbolic.generated_c import c_source

try:
    compiler()
except CompilerError:
    pytest.skip("needs a C compiler", allow_module_level=True)


@pytest.fixture(scope="module", params=[8, 13, 40])
def both(request):
    """The size, and the factorisation on the virtual machine and in C."""
    A = MX.sym("A", request.param, request.param)
    made = function("made", [A], list(convexified(A)), inline=False)
    assert "JTIK_EIGHT(sums" in c_source(made)
    return request.param, CompiledFunction(made), CompiledFunction(library(made).function)


def symmetric(rng, n, kind):
    """A symmetric matrix of a kind."""
    turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
    eigenvalues = {
        "definite": rng.uniform(0.1, 1, n),
        "indefinite": rng.uniform(-1, 1, n),
        "singular": np.arange(n) % 3 / 2.0,
        "negative": -rng.uniform(0, 1, n),
    }[kind]
    A = turn @ np.diag(eigenvalues) @ turn.T
    return (A + A.T) / 2


@pytest.mark.parametrize("kind", ["definite", "indefinite", "singular", "negative"])
def test_numbers_are_those_of_the_virtual_machine(kind, both, rng):
    n, machine, fast = both
    for _ in range(30):
        A = symmetric(rng, n, kind)
        expected, found = machine(A), fast(A)
        for one, other in zip(expected, found, strict=True):
            assert np.array_equal(one, other)
        assert np.linalg.eigvalsh(found[0])[0] > 0
        assert bool(found[1]) == (np.linalg.eigvalsh(A)[0] > 1e-7) or kind == "singular"


@pytest.mark.parametrize("place", [(0, 0), (-1, 0), (-1, -1), (3, 2)])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_has_the_same_result(place, value, both, rng):
    n, machine, fast = both
    A = symmetric(rng, n, "definite")
    A[place] = A[place[::-1]] = value
    for one, other in zip(machine(A), fast(A), strict=True):
        assert np.array_equal(one, other, equal_nan=True)


def test_zero_and_a_large_matrix(both):
    n, machine, fast = both
    for A in (np.zeros((n, n)), 1e150 * np.eye(n), np.ones((n, n))):
        for one, other in zip(machine(A), fast(A), strict=True):
            assert np.array_equal(one, other)

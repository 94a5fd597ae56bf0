"""Reflections: rank and null vector against numpy's singular values."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from jtik.symbolic import function, symbol
from jtik.symbolic.compile import CompiledFunction
from jtik.symbolic.factorization import RANK_THRESHOLD
from jtik.symbolic.reflections import Reflections

ROUNDING = 1e-14
"""Relative error of a null vector and of its length: 100 times the largest that was observed."""


@functools.cache
def compiled(m, n):
    J, g = symbol("J", m, n), symbol("g", n)
    reflections = Reflections(J)
    null = [reflections.null_vector, reflections.null_part(g)] if n == m + 1 else []
    return CompiledFunction(function("reflections", [J, g], [reflections.full_rank, *null]))


@pytest.mark.parametrize("m", [1, 2, 3, 6, 9])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_the_null_vector_of_a_matrix_with_one_column_more_than_rows(m, scale, rng):
    for _ in range(20):
        J, g = scale * rng.normal(size=(m, m + 1)), rng.normal(size=m + 1)
        full_rank, z, part = (each[:, 0] for each in compiled(m, m + 1)(J, g))
        expected = np.linalg.svd(J)[2][-1]
        assert full_rank[0]
        assert np.linalg.norm(J @ z) <= ROUNDING * np.linalg.norm(J)
        assert z @ z == pytest.approx(1, abs=ROUNDING)
        assert abs(z @ expected) == pytest.approx(1, abs=1e-10)
        assert part == pytest.approx(g - np.linalg.pinv(J) @ J @ g, abs=1e-10)


@pytest.mark.parametrize(("m", "n"), [(1, 2), (2, 3), (6, 7), (3, 3), (6, 6)])
def test_entries_that_are_zero_need_no_exchange_of_rows_or_columns(m, n, rng):
    for _ in range(20):
        J = rng.normal(size=(m, n))
        J[:, 0] = 0.0 if n > m else J[:, 0] * (np.arange(m) == m - 1)
        full_rank, *null = compiled(m, n)(J, np.ones(n))
        assert full_rank[0, 0]
        if null:
            assert np.abs(null[0][:, 0]) == pytest.approx(np.eye(n)[0], abs=1e-12)


@pytest.mark.parametrize("row", [0, -1])
@pytest.mark.parametrize(("m", "n"), [(2, 3), (6, 7), (3, 3), (6, 6)])
def test_a_row_that_depends_on_others_is_found(m, n, row, rng):
    for _ in range(20):
        J = rng.normal(size=(m, n))
        others = np.delete(np.arange(m), row)
        J[row] = rng.normal(size=m - 1) @ J[others]
        assert not compiled(m, n)(J, np.ones(n))[0][0, 0]
        J[row] = 0.0
        assert not compiled(m, n)(J, np.ones(n))[0][0, 0]


@pytest.mark.parametrize(("share", "full"), [(1e3, True), (1e-3, False)])
def test_a_row_counts_as_dependent_below_the_threshold(share, full, rng):
    J = np.linalg.qr(rng.normal(size=(4, 4)))[0][:3]
    J[2] = J[0] + share * RANK_THRESHOLD * J[2]
    assert compiled(3, 4)(J, np.ones(4))[0][0, 0] == full

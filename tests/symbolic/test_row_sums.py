"""Sums over rows: NumPy's numbers, in a text that does not grow with the rows."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.symbolic import symbol
from jtik.symbolic.generated_c import c_source
from jtik.symbolic.row_sums import weighted_sums

from ..conftest import EXACT


def sums(rows, columns):
    given = [symbol("M", rows, columns), symbol("w", rows), symbol("v", rows)]
    return casadi.Function("sums", given, weighted_sums(*given))


@pytest.mark.parametrize("shape", [(1, 1), (1, 3), (5, 2), (40, 7)])
def test_they_are_those_of_numpy(shape, rng):
    M, w, v = rng.normal(size=shape), rng.normal(size=shape[0]), rng.normal(size=shape[0])
    product, values = (np.array(each) for each in sums(*shape)(M, w, v))
    assert product == pytest.approx(M.T @ np.diag(w) @ M, abs=EXACT)
    assert values.ravel() == pytest.approx(M.T @ v, abs=EXACT)


def test_rows_add_little_text():
    """Each row adds the lines that pass its entries on, and no products."""
    lines = [c_source(sums(rows, 7)).count("\n") for rows in (20, 40)]
    assert lines[1] - lines[0] <= 20 * (7 + 2) * 2.5

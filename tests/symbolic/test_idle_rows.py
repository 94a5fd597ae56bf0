"""Rows that the box keeps from their bounds are left out in generated C, and solutions are those with all rows."""

from __future__ import annotations

import numpy as np
import pytest

from jtik.qp import Conic
from jtik.symbolic.compile import CompiledFunction, CompilerError, compiler, library
from jtik.symbolic.idle_rows import without_idle_rows
from jtik.symbolic.operations import c_source

try:
    compiler()
except CompilerError:
    pytest.skip("needs a C compiler", allow_module_level=True)
if Conic().archive is None:
    pytest.skip("needs the static library of DAQP that CasADi comes with", allow_module_level=True)

N, ROWS = 6, 25
COUNT = 300


@pytest.fixture(scope="module")
def both():
    """The solver of QPs with six variables and 25 rows on the virtual machine, and in C."""
    back_end = Conic("daqp")
    solver = back_end.function(N, ROWS)
    return CompiledFunction(solver), CompiledFunction(library(solver, archive=back_end.archive).function)


def program(rng, *, box=1.0, equal=0, infinite=0.3):
    """Data of a random QP in which most rows cannot reach their bounds within the box; x = 0 is feasible."""
    A = rng.normal(size=(N, N))
    P, q, C = A @ A.T + 0.1 * np.eye(N), 10 * rng.normal(size=N), rng.normal(size=(ROWS, N))
    low, high = (-(10 ** rng.uniform(-1.5, 1.5, ROWS)) for _ in range(2))
    high = -high
    low[rng.uniform(size=ROWS) < infinite], high[rng.uniform(size=ROWS) < infinite] = -np.inf, np.inf
    low[:equal] = high[:equal] = 0.0
    width = box * rng.uniform(0.1, 1, N)
    return [P, q, C, low, high, -width, box * rng.uniform(0.1, 1, N)]


def idle(data):
    """The rows that no corner of the box brings to a bound."""
    _, _, C, low, high, lower, upper = data
    center, half = (lower + upper) / 2, (upper - lower) / 2
    return (C @ center - abs(C) @ half > low + 1e-6) & (C @ center + abs(C) @ half < high - 1e-6)


KINDS = {
    "box": {},
    "tight box": {"box": 0.1},
    "wide box": {"box": 100.0},
    "equalities": {"equal": 2},
    "no bounds": {"infinite": 1.0},
    "all bounds": {"infinite": 0.0},
}


@pytest.mark.parametrize("kind", KINDS)
def test_the_solution_is_that_with_all_rows(kind, both, rng):
    machine, fast = both
    left_out, active = 0, 0
    for _ in range(COUNT):
        data = program(rng, **KINDS[kind])
        expected, found = machine(*data), fast(*data)
        for one, other in zip(expected, found, strict=True):
            assert other == pytest.approx(one, abs=1e-9, nan_ok=True)
        multipliers = found[1].ravel()
        assert (multipliers[idle(data)] == 0).all()
        left_out, active = left_out + idle(data).sum(), active + (abs(multipliers) > 1e-6).sum()
    assert left_out > (0 if kind == "wide box" else COUNT)
    assert active > 0 or kind == "no bounds"


def test_without_a_box_no_finite_row_is_left_out(both, rng):
    machine, fast = both
    for _ in range(COUNT):
        data = program(rng)
        data[5], data[6] = np.full(N, -np.inf), np.full(N, np.inf)
        data[2][:, 0] = 0.0  # the product of an infinite bound and 0 is no number
        for one, other in zip(machine(*data), fast(*data), strict=True):
            assert np.array_equal(one, other)


def test_a_program_without_a_solution_has_none(both, rng):
    data = program(rng, equal=1)
    data[3][0] = data[4][0] = 1e3  # beyond what the box allows
    found = [each(*data)[0] for each in both]
    row = data[2][0]
    assert all(not abs(row @ x.ravel() - 1e3) < 1 for x in found)


def test_the_text_of_this_casadi_is_known():
    source = c_source(Conic("daqp").function(2, 1))
    assert "daqp_rows" in source
    assert without_idle_rows(source) == source  # only once


def test_another_text_is_left_alone():
    assert without_idle_rows("int main(void) { return 0; }") == "int main(void) { return 0; }"

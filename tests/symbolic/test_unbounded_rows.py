"""Rows without a finite bound are left out in generated C, and solutions are those with all rows, bit by bit."""

from __future__ import annotations

import numpy as np
import pytest

from jtik.qp import Conic
from jtik.symbolic.compile import CompiledFunction, CompilerError, compiler, library
from jtik.symbolic.generated_c import c_source
from jtik.symbolic.unbounded_rows import without_unbounded_rows

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


def program(rng, *, box=1.0, equal=0, unbounded=0.5):
    """Data of a random QP with x = 0 feasible; ``unbounded`` is the share of rows without a finite bound."""
    A = rng.normal(size=(N, N))
    P, q, C = A @ A.T + 0.1 * np.eye(N), 10 * rng.normal(size=N), rng.normal(size=(ROWS, N))
    low, high = -(10 ** rng.uniform(-1.5, 0.5, ROWS)), 10 ** rng.uniform(-1.5, 0.5, ROWS)
    low[rng.uniform(size=ROWS) < 0.3], high[rng.uniform(size=ROWS) < 0.3] = -np.inf, np.inf
    left_out = rng.uniform(size=ROWS) < unbounded
    low[left_out], high[left_out] = -np.inf, np.inf
    low[:equal] = high[:equal] = 0.0
    return [P, q, C, low, high, -box * rng.uniform(0.1, 1, N), box * rng.uniform(0.1, 1, N)]


KINDS = {
    "some": {},
    "all": {"unbounded": 1.0},
    "equalities": {"equal": 2},
    "wide box": {"box": 1e3},
    "no box": {"box": np.inf},
}


@pytest.mark.parametrize("kind", KINDS)
def test_the_solution_is_that_with_all_rows(kind, both, rng):
    machine, fast = both
    left_out, active = 0, 0
    for _ in range(COUNT):
        data = program(rng, **KINDS[kind])
        found = fast(*data)
        for one, other in zip(machine(*data), found, strict=True):
            assert np.array_equal(one, other)
        unbounded = np.isneginf(data[3]) & np.isposinf(data[4])
        assert (found[1].ravel()[unbounded] == 0).all()
        left_out, active = left_out + unbounded.sum(), active + (abs(found[1]) > 1e-6).sum()
    assert left_out > COUNT
    assert active > COUNT or kind == "all"


def test_a_program_without_a_solution_has_none(both, rng):
    data = program(rng, equal=1)
    data[3][0] = data[4][0] = 1e3  # beyond what the box allows
    row = data[2][0]
    for each in both:
        assert not abs(row @ each(*data)[0].ravel() - 1e3) < 1


def test_the_text_of_this_casadi_is_known():
    source = c_source(Conic("daqp").function(2, 1))
    assert "daqp_rows" in source
    assert "setup_time" not in source  # the clock is not read
    assert without_unbounded_rows(source) == source  # only once


def test_another_text_is_left_alone():
    assert without_unbounded_rows("int main(void) { return 0; }") == "int main(void) { return 0; }"

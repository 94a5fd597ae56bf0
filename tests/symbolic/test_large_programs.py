"""Programs of many variables, factorised in generated C before DAQP: solutions and failures are the same."""

from __future__ import annotations

import numpy as np
import pytest

from jtik.qp import Conic
from jtik.symbolic.compile import CompiledFunction, CompilerError, compiler, library
from jtik.symbolic.generated_c import c_source
from jtik.symbolic.large_programs import LEAST, with_own_factors

try:
    compiler()
except CompilerError:
    pytest.skip("needs a C compiler", allow_module_level=True)
if Conic().archive is None:
    pytest.skip("needs the static library of DAQP that CasADi comes with", allow_module_level=True)

SIZES = [(LEAST, 0), (LEAST + 3, 12), (41, 5)]
"""Variables and rows: the fewest that have it, without a row; numbers of variables that eight does not divide."""

KINDS = {
    "few at their bounds": {"pull": 1.0},
    "many at their bounds": {"pull": 30.0},
    "equalities": {"pull": 5.0, "equal": 3},
    "held variables": {"pull": 5.0, "held": 4},
    "no bounds": {"pull": 1.0, "box": np.inf},
    "nearly singular": {"pull": 1.0, "least": 1e-6},
    "diagonal": {"pull": 10.0, "diagonal": True},
}


@pytest.fixture(scope="module", params=SIZES, ids=str)
def both(request):
    """Numbers of variables and rows, and the solver on the virtual machine and in C."""
    back_end = Conic("daqp")
    solver = back_end.function(*request.param)
    in_c = library(solver, archive=back_end.archive).function
    return request.param, CompiledFunction(solver), CompiledFunction(in_c)


def program(rng, size, *, pull, equal=0, held=0, box=1.0, least=0.05, diagonal=False):
    """Data of a random convex program with x = 0 feasible."""
    n, rows = size
    turn = np.eye(n) if diagonal else np.linalg.qr(rng.normal(size=(n, n)))[0]
    P = turn @ np.diag(np.geomspace(least, 1, n)) @ turn.T
    P = (P + P.T) / 2
    q, C = pull * rng.normal(size=n) / np.sqrt(n), rng.normal(size=(rows, n))
    low, high = -rng.uniform(0.1, 2, rows), rng.uniform(0.1, 2, rows)
    low[rng.uniform(size=rows) < 0.3] = -np.inf
    low[:equal] = high[:equal] = 0.0
    lower, upper = -box * rng.uniform(0.1, 1, n), box * rng.uniform(0.1, 1, n)
    lower[:held] = upper[:held] = 0.01
    return [P, q, C, low, high, lower, upper]


def largest_violation(data, x, of_rows, of_box):
    """Largest violation of the conditions of an optimum."""
    P, q, C, low, high, lower, upper = data
    stationarity = np.abs(P @ x + q + C.T @ of_rows + of_box).max()
    worst = stationarity / max(1, np.abs(q).max())
    for values, smallest, largest, multipliers in ((C @ x, low, high, of_rows), (x, lower, upper, of_box)):
        if not values.size:
            continue
        worst = max(worst, (smallest - values).max(), (values - largest).max())
        slack = np.where(multipliers > 0, largest - values, np.where(multipliers < 0, values - smallest, 0))
        worst = max(worst, np.abs(slack * multipliers)[multipliers != 0].max(initial=0))
    return worst


@pytest.mark.parametrize("kind", KINDS)
def test_the_solution_is_the_optimum_and_that_of_the_virtual_machine(kind, both, rng):
    size, machine, fast = both
    options = dict(KINDS[kind])
    options["equal"] = min(options.get("equal", 0), size[1])
    active = 0
    for _ in range(40):
        data = program(rng, size, **options)
        expected, found = ([np.ravel(part) for part in solver(*data)] for solver in (machine, fast))
        x, of_rows, of_box = found[0], found[1], found[2]
        assert largest_violation(data, x, of_rows, of_box) < 1e-7
        for one, other in zip(expected, found, strict=True):
            assert np.array_equal(one, other)
        active += (np.abs(of_box) > 1e-6).sum()
    assert active > 40 or kind == "no bounds"


def test_a_matrix_that_is_not_convex_has_no_solution(both, rng):
    size, machine, fast = both
    for _ in range(10):
        good, bad = program(rng, size, pull=1.0), program(rng, size, pull=1.0, least=0.5)
        bad[0] -= 0.6 * np.eye(size[0])  # a negative eigenvalue
        for solver in (machine, fast):
            assert largest_violation(good, *map(np.ravel, solver(*good))) < 1e-7
            assert not largest_violation(bad, *map(np.ravel, solver(*bad))) < 1e-3


def test_rows_that_contradict_each_other_have_no_solution(both, rng):
    size, machine, fast = both
    if size[1] < 2:
        pytest.skip("needs two rows")
    data = program(rng, size, pull=1.0, equal=2)
    data[2][1], data[3][1], data[4][1] = data[2][0], 0.5, 0.5
    for solver in (machine, fast):
        assert not largest_violation(data, *map(np.ravel, solver(*data))) < 1e-3
    held = program(rng, size, pull=1.0, equal=2, held=1)
    held[2][:2], held[3][0], held[4][0] = np.eye(size[0])[0], 0.5, 0.5  # two rows for a variable that is held elsewhere
    for solver in (machine, fast):
        assert not largest_violation(held, *map(np.ravel, solver(*held))) < 1e-3
    good = program(rng, size, pull=1.0, equal=2)
    for one, other in zip(machine(*good), fast(*good), strict=True):
        assert np.array_equal(one, other)


@pytest.mark.parametrize("which", [0, 1])
def test_numbers_that_are_not_finite_give_no_number(which, both, rng):
    size, machine, fast = both
    last = size[0] - 1
    for row, column in ((0, 0), (last, 0), (last // 2, last // 2)):
        data, after = program(rng, size, pull=1.0), program(rng, size, pull=1.0)
        if which == 0:
            data[0][row, column] = data[0][column, row] = np.nan
        else:
            data[1][row] = np.nan
        expected, found = machine(*data), fast(*data)
        assert np.isnan(found[0]).any()
        assert all(np.array_equal(one, other, equal_nan=True) for one, other in zip(expected, found, strict=True))
        x, of_rows, of_box = (np.ravel(part) for part in fast(*after))
        assert largest_violation(after, x, of_rows, of_box) < 1e-7


def test_the_text_of_this_casadi_is_known():
    source = c_source(Conic("daqp").function(LEAST, 1))
    assert "own_cholesky" in source
    assert with_own_factors(source) == source  # only once


def test_another_text_is_left_alone():
    assert with_own_factors("int main(void) { return 0; }") == "int main(void) { return 0; }"

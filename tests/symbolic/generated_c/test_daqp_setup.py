"""Quadratic programs that generated C sets up for DAQP: solutions are those of the virtual machine, bit by bit."""

from __future__ import annotations

import numpy as np
import pytest

from jtik.qp import Conic
from jtik.symbolic.compile import CompiledFunction, CompilerError, compiler, library
from jtik.symbolic.generated_c import c_source
from jtik.symbolic.generated_c.daqp_setup import with_own_setup

try:
    compiler()
except CompilerError:
    pytest.skip("needs a C compiler", allow_module_level=True)
if Conic().archive is None:
    pytest.skip("needs the static library of DAQP that CasADi comes with", allow_module_level=True)

SIZES = [(1, 0), (2, 3), (7, 0), (6, 25), (10, 40), (8, 3), (23, 12), (41, 5)]
"""Variables and rows; the last two are not on the stack. Eight and four divide some of the numbers only."""

KINDS = {
    "few at their bounds": {"pull": 1.0},
    "many at their bounds": {"pull": 30.0},
    "wide box": {"pull": 10.0, "box": 1e3},
    "no bounds": {"pull": 1.0, "box": np.inf},
    "some rows without a bound": {"pull": 10.0, "unbounded": 0.5},
    "no row with a bound": {"pull": 10.0, "unbounded": 1.0},
    "equalities": {"pull": 5.0, "equal": 2},
    "bounds that are nearly equal": {"pull": 5.0, "equal": 1, "apart": 1e-12},
    "fixed variables": {"pull": 5.0, "fixed": 3},
    "rows of zeros": {"pull": 5.0, "empty": 2},
    "rows that are there twice": {"pull": 10.0, "twice": True},
    "nearly singular": {"pull": 1.0, "smallest": 1e-6},
    "diagonal": {"pull": 10.0, "diagonal": True},
    "diagonal, rows without a bound": {"pull": 10.0, "diagonal": True, "unbounded": 0.5, "equal": 1},
    "nearly diagonal": {"pull": 10.0, "diagonal": True, "beside": 1e-13},
    "not diagonal in the corner": {"pull": 10.0, "diagonal": True, "beside": 1e-3},
}


@pytest.fixture(scope="module", params=SIZES, ids=str)
def both(request):
    """Numbers of variables and rows, and the solver on the virtual machine and in C."""
    back_end = Conic("daqp")
    solver = back_end.function(*request.param)
    in_c = library(solver, archive=back_end.archive).function
    return request.param, CompiledFunction(solver), CompiledFunction(in_c)


def random_qp(
    rng,
    size,
    *,
    pull,
    box=1.0,
    unbounded=0.0,
    equal=0,
    apart=0.0,
    fixed=0,
    empty=0,
    twice=False,
    smallest=0.05,
    diagonal=False,
    beside=0.0,
):
    """Data of a random convex QP with x = 0 feasible, or nearly so."""
    n, rows = size
    turn = np.eye(n) if diagonal else np.linalg.qr(rng.normal(size=(n, n)))[0]
    P = turn @ np.diag(np.geomspace(smallest, 1, n)) @ turn.T
    P = (P + P.T) / 2
    P[-1, 0] += beside if n > 1 else 0
    P[0, -1] = P[-1, 0]
    q, C = pull * rng.normal(size=n) / np.sqrt(n), rng.normal(size=(rows, n))
    if twice:
        C[rows // 2 :] = C[: rows - rows // 2]
    C[:empty] = 0.0
    low, high = -rng.uniform(0.1, 2, rows), rng.uniform(0.1, 2, rows)
    low[rng.uniform(size=rows) < 0.3] = -np.inf
    high[rng.uniform(size=rows) < 0.2] = np.inf
    left_out = rng.uniform(size=rows) < unbounded
    low[left_out], high[left_out] = -np.inf, np.inf
    equal = min(equal, rows, n - 1)
    low[:equal] = 0.0
    high[:equal] = apart
    lower, upper = -box * rng.uniform(0.1, 1, n), box * rng.uniform(0.1, 1, n)
    fixed = min(fixed, n - 1 - equal)
    if fixed > 0:
        lower[-fixed:] = upper[-fixed:] = 0.01 if equal == 0 else 0.0
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


def assert_solved(both_solvers, data):
    """Both solvers return the optimum, the same bits; multipliers of rows and box."""
    expected, found = ([np.ravel(part) for part in solver(*data)] for solver in both_solvers)
    for one, other in zip(expected, found, strict=True):
        assert np.array_equal(one, other)
    x, of_rows, of_box = found[:3]
    assert largest_violation(data, x, of_rows, of_box) < 1e-7
    return of_rows, of_box


def assert_unsolved(solver, data):
    """A solver returns no optimum; what it returns is not defined."""
    with np.errstate(invalid="ignore"):
        assert not largest_violation(data, *(np.ravel(part) for part in solver(*data)[:3])) < 1e-3


@pytest.mark.parametrize("kind", KINDS)
def test_the_solution_is_the_optimum_and_that_of_the_virtual_machine(kind, both, rng):
    size, *solvers = both
    active = 0
    for _ in range(60):
        data = random_qp(rng, size, **KINDS[kind])
        of_rows, of_box = assert_solved(solvers, data)
        unbounded = np.isneginf(data[3]) & np.isposinf(data[4])
        assert (of_rows[unbounded] == 0).all()
        active += (np.abs([*of_rows, *of_box]) > 1e-6).sum()
    assert active > 5 or KINDS[kind].get("box", 1) > 1


def test_bounds_in_the_wrong_order_have_no_solution(both, rng):
    size, machine, fast = both
    for where in (0, size[0] - 1):
        bad, good = random_qp(rng, size, pull=1.0), random_qp(rng, size, pull=1.0)
        bad[5][where] = bad[6][where] + 0.1
        assert_unsolved(fast, bad)  # the virtual machine raises
        assert_solved((machine, fast), good)


def test_a_matrix_that_is_not_convex_has_no_solution(both, rng):
    size, *solvers = both
    for _ in range(10):
        good, bad = random_qp(rng, size, pull=1.0), random_qp(rng, size, pull=1.0, smallest=0.5)
        bad[0] -= (0.6 if size[0] > 1 else 1.6) * np.eye(size[0])  # a negative eigenvalue
        for solver in solvers:
            assert_unsolved(solver, bad)
        assert_solved(solvers, good)


def test_rows_that_contradict_each_other_have_no_solution(both, rng):
    size, *solvers = both
    if min(size) < 2:
        pytest.skip("needs two rows and two variables")
    contradictory, with_fixed = (random_qp(rng, size, pull=1.0) for _ in range(2))
    for data in (contradictory, with_fixed):
        data[3][:2] = data[4][:2] = 0.0
    contradictory[2][1], contradictory[3][1], contradictory[4][1] = contradictory[2][0], 0.5, 0.5
    with_fixed[5][0] = with_fixed[6][0] = 0.01
    with_fixed[2][:2], with_fixed[3][0], with_fixed[4][0] = (
        np.eye(size[0])[0],
        0.5,
        0.5,
    )  # rows for a variable that is fixed elsewhere
    for data in (contradictory, with_fixed):
        for solver in solvers:
            assert_unsolved(solver, data)
    assert_solved(solvers, random_qp(rng, size, pull=1.0, equal=1))


@pytest.mark.parametrize("number", [np.nan, np.inf])
@pytest.mark.parametrize("which", ["matrix", "linear cost", "row"])
def test_numbers_that_are_not_finite_have_no_solution(which, number, both, rng):
    size, *solvers = both
    last = size[0] - 1
    if which == "row" and not size[1]:
        pytest.skip("needs a row")
    for row, column in ((0, 0), (last, 0), (last // 2, last // 2)):
        data = random_qp(rng, size, pull=1.0)
        if which == "matrix":
            data[0][row, column] = data[0][column, row] = number
        elif which == "linear cost":
            data[1][row] = number
        else:
            data[2][min(row, size[1] - 1), column] = number
        for solver in solvers:
            assert_unsolved(solver, data)
        assert_solved(solvers, random_qp(rng, size, pull=1.0))


def test_the_text_of_this_casadi_is_known():
    source = c_source(Conic("daqp").function(3, 1))
    assert "case 3: return" in source
    assert "daqp_solved)(d)) return 0;" in source
    assert with_own_setup(source) == source  # only once


def test_another_text_is_left_alone():
    assert with_own_setup("int main(void) { return 0; }") == "int main(void) { return 0; }"

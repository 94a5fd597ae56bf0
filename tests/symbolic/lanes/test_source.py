"""C of a function on vectors, against the same function on CasADi's virtual machine."""

from __future__ import annotations

import ctypes
import itertools

import casadi
import numpy as np
import pytest

from jtik._loop.lanes import search
from jtik._loop.search.start_bank import aligned
from jtik.symbolic import (
    atan2,
    cos,
    exp,
    fabs,
    fmax,
    fmin,
    function,
    if_else,
    logic_not,
    logic_or,
    sin,
    sqrt,
    symbol,
    vertcat,
)  # fmt: skip
from jtik.symbolic.compile import plain_library
from jtik.symbolic.lanes.maths import EXACT, LEVELS, lane_maths
from jtik.symbolic.lanes.source import lane_source

SPECIAL = (np.nan, -np.inf, -2.5, -0.0, 0.0, 1e-310, 3.0, np.inf)

HIGHEST = LEVELS[search.highest_level()]

ENTRY = "\nJTIK_CPU void JTIK_NAME_call(const V* x, const V* y, V* out) { JTIK_NAME_step(x, y, out); }\n"


def in_lanes(f, level, columns, *, single=False):
    """The rows of ``f(x, y)`` at each of the columns (k, 2), computed in lanes."""
    code = lane_maths(level, single=single) + lane_source(f, "JTIK_NAME_step", ()) + ENTRY
    loaded, name = plain_library(code, EXACT)
    call, rows = getattr(loaded, f"{name}_call"), []
    lanes, kind = level.lanes_of(single=single), np.float32 if single else float
    for part in columns.reshape(-1, lanes, 2):
        memory = [aligned(16 + lanes * size).view(kind)[: lanes * size] for size in (1, 1, f.numel_out())]
        memory[0][:], memory[1][:] = part.T
        call(*(ctypes.c_void_p(each.ctypes.data) for each in memory))
        rows.append(memory[2].reshape(-1, lanes).T.astype(float))
    return np.concatenate(rows)


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("level", LEVELS, ids=["any processor", "AVX2", "AVX-512"])
def test_smaller_and_larger_of_special_numbers_are_casadis(level, single):
    if LEVELS.index(level) > search.highest_level():
        pytest.skip("a processor without these instructions")
    x, y = symbol("x", 1), symbol("y", 1)
    f = function("f", [x, y], [vertcat(fmin(x, y), fmax(x, y))])
    numbers = [1e-40 if single and each == 1e-310 else each for each in SPECIAL]
    pairs = np.array([*itertools.product(numbers, numbers)])
    expected = np.array([np.array(f(*pair)).ravel() for pair in pairs])
    found = in_lanes(f, level, pairs, single=single)
    if single:
        expected = expected.astype(np.float32).astype(float)
    assert np.array_equal(found, expected, equal_nan=True)


@pytest.mark.parametrize("level", LEVELS, ids=["any processor", "AVX2", "AVX-512"])
def test_every_operation_has_single_precision(level, rng):
    if LEVELS.index(level) > search.highest_level():
        pytest.skip("a processor without these instructions")
    x, y = symbol("x", 1), symbol("y", 1)
    signs = if_else(x < y, x, -y) + if_else(logic_or(x <= 0, logic_not(y != 1)), 2.0, casadi.sign(y))
    others = vertcat(sqrt(fabs(x)), sin(x) * cos(y), atan2(y, x), exp(x) / (1 + y**2), 1 / (2 + y), signs, 1e-300 * x)
    f = function("f", [x, y], [others])
    points = rng.normal(size=(64, 2))
    expected = np.array([np.array(f(*point)).ravel() for point in points])
    assert in_lanes(f, level, points, single=True) == pytest.approx(expected, rel=1e-5, abs=1e-6)


def test_several_divisions_by_one_number_are_its_inverse(rng):
    x, y = symbol("x", 1), symbol("y", 1)
    f = function("f", [x, y], [vertcat(x / y, (x + 1) / y, 3 / y - x, x / (y + 1))])
    source = lane_source(f, "JTIK_NAME_step", ())
    assert source.count(" / ") == 2  # 1 / y, and that by y + 1
    points = np.column_stack([rng.normal(size=64), rng.uniform(0.1, 5, 64)])
    expected = np.array([np.array(f(*point)).ravel() for point in points])
    assert in_lanes(f, HIGHEST, points) == pytest.approx(expected, rel=1e-14, abs=1e-14)
    zero = np.tile([1.0, 0.0], (8, 1))
    assert np.isinf(in_lanes(f, LEVELS[0], zero)[:, :3]).all()

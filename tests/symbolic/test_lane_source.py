"""C of a function on vectors, against the same function on CasADi's virtual machine."""

from __future__ import annotations

import ctypes
import itertools

import numpy as np
import pytest

from jtik._loop.lanes import search
from jtik.symbolic import fmax, fmin, function, symbol, vertcat
from jtik.symbolic.compile import plain_library
from jtik.symbolic.lane_maths import EXACT, LEVELS, lane_maths
from jtik.symbolic.lane_source import lane_source

SPECIAL = (np.nan, -np.inf, -2.5, -0.0, 0.0, 1e-310, 3.0, np.inf)

ENTRY = "\nJTIK_CPU void JTIK_NAME_call(const V* x, const V* y, V* out) { JTIK_NAME_step(x, y, out); }\n"


def in_lanes(f, level, columns):
    """The rows of ``f(x, y)`` at each of the columns (k, 2), computed in lanes."""
    code = lane_maths(level) + lane_source(f, "JTIK_NAME_step", ()) + ENTRY
    loaded, name = plain_library(code, EXACT)
    call, rows = getattr(loaded, f"{name}_call"), []
    for part in columns.reshape(-1, level.lanes, 2):
        memory = np.zeros((2 + f.numel_out(), level.lanes + 8))
        aligned = [row[-row.ctypes.data % 64 // 8 :][: level.lanes] for row in memory[:2]]
        aligned[0][:], aligned[1][:] = part.T
        room = np.zeros(f.numel_out() * level.lanes + 8)
        out = room[-room.ctypes.data % 64 // 8 :][: f.numel_out() * level.lanes]
        call(*(ctypes.c_void_p(each.ctypes.data) for each in (*aligned, out)))
        rows.append(out.reshape(-1, level.lanes).T.copy())
    return np.concatenate(rows)


@pytest.mark.parametrize("level", LEVELS, ids=["any processor", "AVX2", "AVX-512"])
def test_smaller_and_larger_of_special_numbers_are_casadis(level):
    if LEVELS.index(level) > search.highest_level():
        pytest.skip("a processor without these instructions")
    x, y = symbol("x", 1), symbol("y", 1)
    f = function("f", [x, y], [vertcat(fmin(x, y), fmax(x, y))])
    pairs = np.array([*itertools.product(SPECIAL, SPECIAL)])
    expected = np.array([np.array(f(*pair)).ravel() for pair in pairs])
    found = in_lanes(f, level, pairs)
    assert np.array_equal(found, expected, equal_nan=True)


def test_several_divisions_by_one_number_are_its_inverse(rng):
    x, y = symbol("x", 1), symbol("y", 1)
    f = function("f", [x, y], [vertcat(x / y, (x + 1) / y, 3 / y - x, x / (y + 1))])
    source = lane_source(f, "JTIK_NAME_step", ())
    assert source.count(" / ") == 2  # 1 / y, and that by y + 1
    points = np.column_stack([rng.normal(size=64), rng.uniform(0.1, 5, 64)])
    expected = np.array([np.array(f(*point)).ravel() for point in points])
    assert in_lanes(f, LEVELS[search.highest_level()], points) == pytest.approx(expected, rel=1e-14, abs=1e-14)
    zero = np.tile([1.0, 0.0], (8, 1))
    assert np.isinf(in_lanes(f, LEVELS[0], zero)[:, :3]).all()

"""Sine, cosine and arc tangent in lanes, in both precisions, against NumPy's and against extended precision."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from jtik.symbolic.compile import plain_library
from jtik.symbolic.lanes import maths

SINES = """
%s
JTIK_CPU void JTIK_NAME_turns(const double* x, double* s, double* c, long long n) {
  for (long long i = 0; i < n; i += 4) {
    V v, a, b;
    memcpy(&v, x + i, sizeof v);
    v_sin_cos(1, &v, &a, &b);
    memcpy(s + i, &a, sizeof a);
    memcpy(c + i, &b, sizeof b);
  }
}
JTIK_CPU void JTIK_NAME_angles(const double* y, const double* x, double* r, long long n) {
  for (long long i = 0; i < n; i += 4) {
    V a, b;
    memcpy(&a, y + i, sizeof a);
    memcpy(&b, x + i, sizeof b);
    a = v_atan2(a, b);
    memcpy(r + i, &a, sizeof a);
  }
}
"""


def pointers(*arrays):
    return [each.ctypes.data_as(ctypes.c_void_p) for each in arrays]


def test_sine_and_cosine_are_within_two_units_of_the_last_place(rng):
    loaded, name = plain_library(SINES % maths.lane_maths(maths.LEVELS[0]), maths.EXACT)
    near = np.arange(-64000, 64000) * (np.pi / 2)
    x = np.concatenate([rng.uniform(-1e5, 1e5, 200_000), rng.uniform(-7, 7, 200_000), near[::5], [0.0, -0.0, 1e-300]])
    x = np.concatenate([x, np.zeros(-len(x) % 4)])
    s, c = np.zeros_like(x), np.zeros_like(x)
    getattr(loaded, f"{name}_turns")(*pointers(x, s, c), ctypes.c_longlong(len(x)))
    exact = np.asarray(x, dtype=np.longdouble)
    for found, expected in ((s, np.sin(exact)), (c, np.cos(exact))):
        off = np.abs(found - expected) / np.spacing(np.abs(expected.astype(float)))
        assert off.max() < 2.0
    outside = np.array([1e6, -3e8, np.inf, np.nan])
    s, c = np.zeros(4), np.zeros(4)
    getattr(loaded, f"{name}_turns")(*pointers(outside, s, c), ctypes.c_longlong(4))
    with np.errstate(invalid="ignore"):
        assert s == pytest.approx(np.sin(outside), abs=1e-15, nan_ok=True)
        assert c == pytest.approx(np.cos(outside), abs=1e-15, nan_ok=True)


def test_the_arc_tangent_is_within_three_units_of_the_last_place(rng):
    loaded, name = plain_library(SINES % maths.lane_maths(maths.LEVELS[0]), maths.EXACT)
    angle = np.concatenate([rng.uniform(-np.pi, np.pi, 200_000), np.arange(-16, 17) * np.pi / 16])
    length = 10.0 ** rng.uniform(-12, 12, len(angle))
    special = [0.0, -0.0, 1.0, -1.0, 1e-305, -1e-305, 1e305, np.inf, -np.inf, np.nan]
    y, x = (np.concatenate([length * f(angle), np.array(pair)]) for f, pair in
            ((np.sin, np.repeat(special, len(special))), (np.cos, np.tile(special, len(special)))))  # fmt: skip
    y, x = (np.concatenate([each, np.ones(-len(each) % 4)]) for each in (y, x))
    found = np.zeros_like(x)
    getattr(loaded, f"{name}_angles")(*pointers(y, x, found), ctypes.c_longlong(len(x)))
    expected = np.arctan2(y.astype(np.longdouble), x.astype(np.longdouble))
    assert np.array_equal(np.isnan(found), np.isnan(expected))
    assert np.array_equal(np.signbit(found), np.signbit(expected.astype(float)))
    known = ~np.isnan(expected)
    off = np.abs(found - expected)[known] / np.spacing(np.abs(expected.astype(float)))[known]
    assert off.max() < 3.0


ANGLES = """
%s
JTIK_CPU void JTIK_NAME_angles(const float* x, const float* y, float* s, float* c, float* r, long long n) {
  for (long long i = 0; i < n; i += JTIK_LANES) {
    V v, w, a, b;
    memcpy(&v, x + i, sizeof v);
    memcpy(&w, y + i, sizeof w);
    v_sin_cos(1, &v, &a, &b);
    w = v_atan2(w, v);
    memcpy(s + i, &a, sizeof a);
    memcpy(c + i, &b, sizeof b);
    memcpy(r + i, &w, sizeof w);
  }
}
"""


def angles(x, y):
    """sin x, cos x and atan2(y, x) in single precision."""
    loaded, name = plain_library(ANGLES % maths.lane_maths(maths.LEVELS[0], single=True), maths.EXACT)
    given = [np.concatenate([each, np.ones(-len(each) % 8)]).astype(np.float32) for each in (x, y)]
    found = [np.zeros_like(given[0]) for _ in range(3)]
    pointers = [each.ctypes.data_as(ctypes.c_void_p) for each in (*given, *found)]
    getattr(loaded, f"{name}_angles")(*pointers, ctypes.c_longlong(len(given[0])))
    return [each[: len(x)].astype(float) for each in (*given, *found)]


def test_sine_cosine_and_arc_tangent_in_single_precision(rng):
    x = np.concatenate([rng.uniform(-1e3, 1e3, 100_000), rng.uniform(-7, 7, 100_000), np.arange(-600, 600) * np.pi / 2])
    y = rng.normal(size=len(x)) * 10.0 ** rng.uniform(-6, 6, len(x))
    x, y, s, c, r = angles(x, y)
    assert np.abs(s - np.sin(x)).max() < 3e-7
    assert np.abs(c - np.cos(x)).max() < 3e-7
    assert np.abs(r - np.arctan2(y, x)).max() < 6e-7


def test_special_angles_in_single_precision():
    special = np.array([0.0, -0.0, 1.0, -1.0, 1e-38, -1e-38, 1e38, np.inf, -np.inf, np.nan])
    y, x = np.repeat(special, len(special)), np.tile(special, len(special))
    x, y, s, c, r = angles(x, y)
    assert r == pytest.approx(np.arctan2(y, x), abs=6e-7, nan_ok=True)
    assert np.array_equal(np.signbit(r), np.signbit(np.arctan2(y, x)))
    assert not np.isfinite(s[~np.isfinite(x)]).any()
    assert not np.isfinite(c[~np.isfinite(x)]).any()

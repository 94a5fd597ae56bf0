"""SingularValues: against numpy at any rank, and against extended precision where numpy is not accurate enough."""

from __future__ import annotations

import functools

import casadi
import numpy as np
import pytest

import jtik
from jtik.symbolic.svd import SWEEPS, SingularValues

ROUNDING = 2e-14
"""A hundred times the working precision: observed below 5e-15 for unit vectors and below 3e-16 |J| for values."""

SHAPES = [(1, 4), (2, 2), (2, 10), (3, 7), (4, 8), (5, 7), (6, 6), (6, 7), (6, 12), (8, 12), (4, 2), (6, 3)]


@functools.cache
def compiled(m, n):
    J, r, gains = casadi.SX.sym("J", m, n), casadi.SX.sym("r", m), casadi.SX.sym("gains", m)
    found = SingularValues(J)
    each = [gains[i] for i in range(m)]
    outputs = (
        casadi.horzcat(*found.left),
        casadi.vertcat(*found.values),
        casadi.horzcat(*found.rows).T,
        casadi.vertcat(*found.squared),
        casadi.vertcat(*found.components(r)),
        found.combined(each),
        found.image(each),
    )
    return casadi.Function("svd", [J, r, gains], [casadi.densify(x) for x in outputs], {"cse": True})


def svd(J):
    """U (m, m), sigma (m,), S V' (m, n)."""
    U, sigma, rows, *_ = (x.full() for x in compiled(*J.shape)(J, np.zeros(len(J)), np.zeros(len(J))))
    return U, sigma[:, 0], rows


def orthonormal(rng, rows, columns):
    return np.linalg.qr(rng.standard_normal((rows, columns)))[0]


def matrix(rng, shape, kind):
    m, n = shape
    k = min(m, n)
    sigma = {
        "spread": 10 ** rng.uniform(-6, 0, k),
        "near-singular": np.append(rng.uniform(0.1, 1, k - 1), 1e-12),
        "equal": np.ones(k),
        "equal in pairs": np.repeat(rng.uniform(0.1, 1, k), 2)[:k],
    }
    if kind in sigma:
        return orthonormal(rng, m, k) @ np.diag(sigma[kind]) @ orthonormal(rng, n, k).T
    rank = rng.integers(1, max(k, 2))
    return {
        "generic": lambda: rng.standard_normal(shape),
        "singular": lambda: rng.standard_normal((m, rank)) @ rng.standard_normal((rank, n)),
        "integers": lambda: rng.integers(-2, 3, shape).astype(float),
        "repeated rows": lambda: np.repeat(rng.standard_normal((1, n)), m, axis=0),
        "zero row": lambda: np.vstack([np.zeros(n), rng.standard_normal((m - 1, n))]),
        "zero": lambda: np.zeros(shape),
        "graded": lambda: 10.0 ** -np.linspace(0, 12, m)[:, None] * rng.standard_normal(shape),
    }[kind]()


KINDS = (
    "generic",
    "spread",
    "near-singular",
    "singular",
    "equal",
    "equal in pairs",
    "integers",
    "repeated rows",
    "zero row",
    "zero",
    "graded",
)


@pytest.mark.thinned
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("shape", SHAPES)
def test_it_is_a_singular_value_decomposition(shape, kind, rng):
    m, n = shape
    for _ in range(8):
        J = matrix(rng, shape, kind)
        size = max(np.linalg.norm(J), 1e-130)
        U, sigma, rows = svd(J)
        expected = np.zeros(m)
        expected[: min(m, n)] = np.linalg.svd(J, compute_uv=False)
        assert np.linalg.norm(U.T @ U - np.eye(m)) <= ROUNDING
        assert U @ rows == pytest.approx(J, abs=ROUNDING * size)
        assert rows @ rows.T == pytest.approx(np.diag(sigma**2), abs=ROUNDING * size**2)
        assert sigma == pytest.approx(expected, abs=ROUNDING * size)
        assert (np.diff(sigma) <= ROUNDING * size).all()


@pytest.mark.thinned
@pytest.mark.parametrize("kind", ["generic", "near-singular", "singular", "zero"])
@pytest.mark.parametrize("shape", SHAPES)
def test_components_and_images_need_no_U(shape, kind, rng):
    m, _ = shape
    J, r, gains = matrix(rng, shape, kind), rng.standard_normal(m), rng.standard_normal(m)
    U, _, rows, _, components, combined, image = (x.full() for x in compiled(*shape)(J, r, gains))
    assert components[:, 0] == pytest.approx(U.T @ r, abs=ROUNDING * np.linalg.norm(r))
    assert combined[:, 0] == pytest.approx(gains @ rows, abs=ROUNDING * np.linalg.norm(J))
    assert image[:, 0] == pytest.approx(J @ (gains @ rows), abs=10 * ROUNDING * np.linalg.norm(J) ** 2)


def by_extended_precision(J):
    """sigma by the same rotations in long double, repeated until nothing changes."""
    A, tiny = J.astype(np.longdouble), np.finfo(np.longdouble).tiny
    for _ in range(14):
        for p in range(len(A) - 1):
            for q in range(p + 1, len(A)):
                a, b, g = A[p] @ A[p], A[q] @ A[q], A[p] @ A[q]
                t = np.sign(a - b or 1) * 2 * g / (abs(a - b) + np.sqrt((a - b) ** 2 + 4 * g * g) + tiny)
                c = 1 / np.sqrt(1 + t * t)
                A[p], A[q] = c * A[p] + c * t * A[q], c * A[q] - c * t * A[p]
    return np.sort(np.linalg.norm(A, axis=1))[::-1]


@pytest.mark.skipif(np.finfo(np.longdouble).eps > 1e-18, reason="long double is no longer than double here")
@pytest.mark.parametrize("shape", [(2, 10), (3, 7), (6, 7), (6, 6), (8, 12)])
@pytest.mark.parametrize("order", [1, -1])
def test_small_values_of_graded_rows_are_relatively_accurate(shape, order, rng):
    """Rows over twelve orders of magnitude, where numpy's smallest value has three digits or none."""
    for _ in range(5):
        J = matrix(rng, shape, "graded")[::order]
        assert svd(J)[1] == pytest.approx(by_extended_precision(J), rel=1e-11)


@pytest.mark.parametrize("scale", [1e-60, 1e-6, 1e6, 1e60])
def test_it_scales(scale, rng):
    J = rng.standard_normal((3, 7))
    U, sigma, rows = svd(J)
    scaled = svd(scale * J)
    assert scaled[0] == pytest.approx(U, abs=ROUNDING)
    assert scaled[1] / scale == pytest.approx(sigma, rel=ROUNDING)
    assert scaled[2] / scale == pytest.approx(rows, abs=10 * ROUNDING)


def cosines(m, sweeps, rng):
    """Largest cosine between two of the rows found, over many matrices of full rank."""
    J = casadi.SX.sym("J", m, m + 1)
    found = casadi.Function("rows", [J], [casadi.horzcat(*SingularValues(J, sweeps=sweeps).rows).T])
    worst = 0.0
    for k in range(100):
        rows = found(matrix(rng, (m, m + 1), ("generic", "spread", "near-singular")[k % 3])).full()
        unit = rows / np.linalg.norm(rows, axis=1, keepdims=True)
        worst = max(worst, np.abs(unit @ unit.T - np.eye(m)).max())
    return worst


@pytest.mark.quick(2)
@pytest.mark.parametrize("m", [3, 4, 5, 6])
def test_the_sweeps_are_as_many_as_needed(m, rng):
    """Enough for singular vectors orthogonal to working precision at any singular value, and not many more."""
    assert cosines(m, SWEEPS[m], rng) < ROUNDING
    assert cosines(m, SWEEPS[m] - 2, rng) > ROUNDING


def test_a_negative_number_of_sweeps_is_refused():
    with pytest.raises(jtik.ArgumentError, match="sweeps"):
        SingularValues(casadi.SX.sym("J", 2, 3), sweeps=-1)

"""RowSpace: pseudo-inverse and null space at any rank, against numpy's singular values."""

from __future__ import annotations

import functools
from pathlib import Path

import casadi
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import jtik
from jtik.symbolic.factorization import RANK_THRESHOLD, RowSpace

EPS = np.finfo(float).eps
FACTOR = 1e3
"""Constant in front of eps * condition in the error of a factorisation; observed below 50."""


@functools.cache
def compiled(m, n):
    J, r, g = (casadi.SX.sym(*size) for size in (("J", m, n), ("r", m), ("g", n)))
    rows = RowSpace(J)
    solved, split = rows.least_squares(r), rows.split(g)
    vectors = (solved.vector, solved.image, split.null, split.multipliers)
    squares = (solved.squared_length, split.rest.squared_length)
    outputs = [casadi.densify(x) for x in (*vectors, *squares, rows.rank)]
    return casadi.Function("rows", [J, r, g], outputs)


def answers(J, r, g):
    """x = J+ r, J x, (I - J+ J) g, (J')+ g, rank."""
    *vectors, length, rest, rank = (x.full()[:, 0] for x in compiled(*J.shape)(J, r, g))
    x, _, null, _ = vectors
    assert length[0] == pytest.approx(x @ x, rel=1e-9, abs=1e-30)
    assert rest[0] == pytest.approx((g - null) @ (g - null), rel=1e-9, abs=1e-30)
    return (*vectors, int(rank[0]))


def check_against_pinv(J, r, g, rcond=RANK_THRESHOLD):
    sigma = np.linalg.svd(J, compute_uv=False)
    rank = int((sigma > rcond * max(sigma[0], 1e-300)).sum())
    condition = sigma[0] / sigma[rank - 1] if rank else 1.0
    pinv = np.linalg.pinv(J, rcond=rcond)
    x, image, null, multipliers, found = answers(J, r, g)
    inverse = 1 / sigma[rank - 1] if rank else 0.0
    slack = FACTOR * EPS * condition
    assert found == rank
    assert x == pytest.approx(pinv @ r, abs=slack * (inverse * np.linalg.norm(r) * condition + 1e-300))
    assert image == pytest.approx(J @ pinv @ r, abs=slack * (np.linalg.norm(r) + 1e-300))
    assert null == pytest.approx(g - pinv @ J @ g, abs=slack * (np.linalg.norm(g) + 1e-300))
    assert multipliers == pytest.approx(pinv.T @ g, abs=slack * (inverse * np.linalg.norm(g) * condition + 1e-300))


SHAPES = [(1, 1), (1, 5), (2, 2), (2, 10), (3, 7), (6, 7), (6, 6), (6, 12), (4, 2), (3, 1)]


@pytest.mark.parametrize("shape", SHAPES)
def test_full_rank(shape, rng):
    for _ in range(20):
        check_against_pinv(rng.standard_normal(shape), rng.standard_normal(shape[0]), rng.standard_normal(shape[1]))


@pytest.mark.thinned
@pytest.mark.parametrize("shape", [shape for shape in SHAPES if shape[0] <= shape[1]])
@pytest.mark.parametrize("damping", [0.0, 1e-6, 0.3])
def test_a_damped_step_takes_the_rows_in_turn(shape, damping, rng):
    """Each coordinate of the QR factorisation of J' minimises its row's error with its own damping."""
    symbols = J, r, w = [casadi.SX.sym(*size) for size in (("J", *shape), ("r", shape[0]), ("w", 1))]
    step = RowSpace(J).damped(r, w)
    function = casadi.Function("damped", symbols, [casadi.densify(x) for x in (step.vector, step.image)])
    for _ in range(5):
        J, r = rng.standard_normal(shape), rng.standard_normal(shape[0])
        Q, R = np.linalg.qr(J.T)
        c = np.zeros(shape[0])
        for i in range(shape[0]):
            c[i] = R[i, i] * (r[i] - R[:i, i] @ c[:i]) / (R[i, i] ** 2 + damping)
        x, image = (each.full()[:, 0] for each in function(J, r, damping))
        assert x == pytest.approx(Q @ c, rel=1e-6, abs=1e-9 * np.linalg.norm(c))
        assert image == pytest.approx(J @ x, rel=1e-6, abs=1e-9)
        if damping == 0:
            assert image == pytest.approx(r, abs=1e-9 * (1 + np.linalg.norm(c)))


@pytest.mark.parametrize(
    ("m", "n", "rank"),
    [(2, 10, 1), (3, 7, 1), (3, 7, 2), *[(6, n, k) for n in (7, 12) for k in (1, 2, 3, 4, 5)]],
)
def test_dependent_rows(m, n, rank, rng):
    for _ in range(10):
        J = rng.standard_normal((m, rank)) @ rng.standard_normal((rank, n))
        check_against_pinv(J, rng.standard_normal(m), rng.standard_normal(n))


@pytest.mark.parametrize("zero", [(0,), (1,), (2,), (0, 2), (0, 1)])
def test_zero_rows(zero, rng):
    J = rng.standard_normal((3, 7))
    J[list(zero)] = 0
    check_against_pinv(J, rng.standard_normal(3), rng.standard_normal(7))


def test_repeated_and_opposite_rows(rng):
    row = rng.standard_normal(5)
    check_against_pinv(np.stack([row, row, -2 * row]), rng.standard_normal(3), rng.standard_normal(5))


@pytest.mark.parametrize("shape", SHAPES)
def test_the_zero_matrix_spans_nothing(shape, rng):
    m, n = shape
    g = rng.standard_normal(n)
    x, image, null, multipliers, rank = answers(np.zeros(shape), rng.standard_normal(m), g)
    assert rank == 0
    assert not np.any([*x, *image, *multipliers])
    assert null.tolist() == g.tolist()


def nearly_dependent(ratio, rng):
    """Two rows of which the second is the first plus an orthogonal part of ``ratio`` times the Frobenius norm."""
    a, b = rng.standard_normal((2, 6))
    b -= a * (a @ b) / (a @ a)
    J = np.stack([a, a])
    J[1] += ratio * np.sqrt(2) * np.linalg.norm(a) * b / np.linalg.norm(b)
    return J


@pytest.mark.parametrize("above", [1.5, 10.0, 1e3, 1e5])
def test_rows_that_differ_by_more_than_the_threshold_are_two(above, rng):
    J, r, g = nearly_dependent(above * RANK_THRESHOLD, rng), rng.standard_normal(2), rng.standard_normal(6)
    x, image, null, _, rank = answers(J, r, g)
    pinv = np.linalg.pinv(J, rcond=1e-14)
    condition = np.linalg.cond(J)
    assert rank == 2
    # backward stable: the error of x is that of a solution of a problem perturbed by eps
    assert np.linalg.norm(x - pinv @ r) <= FACTOR * EPS * condition * np.linalg.norm(pinv @ r)
    assert image == pytest.approx(r, abs=FACTOR * EPS * np.linalg.norm(J) * np.linalg.norm(x))
    assert null == pytest.approx(g - pinv @ J @ g, abs=FACTOR * EPS * condition)


@pytest.mark.parametrize("below", [0.7, 1e-1, 1e-3, 1e-6])
def test_rows_that_differ_by_less_than_the_threshold_are_one(below, rng):
    J, r, g = nearly_dependent(below * RANK_THRESHOLD, rng), rng.standard_normal(2), rng.standard_normal(6)
    x, image, null, multipliers, rank = answers(J, r, g)
    pinv = np.linalg.pinv(np.stack([J[0], J[0]]))
    dropped = 10 * below * RANK_THRESHOLD  # what the part that was dropped could have changed
    assert rank == 1
    assert x == pytest.approx(pinv @ r, abs=dropped)
    assert image == pytest.approx(np.full(2, r.mean()), abs=dropped)
    assert null == pytest.approx(g - pinv @ J @ g, abs=dropped)
    assert multipliers == pytest.approx(pinv.T @ g, abs=dropped)


@pytest.mark.parametrize("second", [3e-8, 1e-7, 1e-6])
@pytest.mark.parametrize("first", [1e-2, 1e-3, 1e-4])
def test_a_null_space_step_where_two_rows_are_nearly_dependent_and_later_ones_are(first, second, rng):
    """What is left of the later rows is noise. The error is that of the second short row."""
    for _ in range(50):
        basis = np.linalg.qr(rng.standard_normal((7, 7)))[0]
        new = np.array([1.0, 1.0, first, second, 0.0, 0.0])  # what each row has outside the span of those before it
        J = (np.tril(rng.standard_normal((6, 6)), -1) * (new > 0) + np.diag(new)) @ basis[:6]
        g = rng.standard_normal(7)
        _, _, null, *_, rank = (x.full()[:, 0] for x in compiled(6, 7)(J, np.zeros(6), g))
        assert rank == 4
        leak = np.linalg.norm(J @ null) / np.linalg.norm(J) / np.linalg.norm(g)
        assert leak <= max(RANK_THRESHOLD, 10 * EPS / (first * second))


@pytest.mark.parametrize("scale", [1e-100, 1e-6, 1e6, 1e100])
def test_rank_is_relative(scale, rng):
    J, r, g = rng.standard_normal((3, 7)), rng.standard_normal(3), rng.standard_normal(7)
    J[2] = J[0] - J[1]
    unscaled, scaled = answers(J, r, g), answers(scale * J, r, g)
    assert scaled[-1] == unscaled[-1] == 2
    assert scale * scaled[0] == pytest.approx(unscaled[0], abs=1e-12)
    assert scaled[2] == pytest.approx(unscaled[2], abs=1e-12)


@pytest.mark.slow
@settings(deadline=None, max_examples=300)
@given(st.data())
def test_integer_matrices_of_every_rank(data):
    m, n = data.draw(st.integers(1, 6)), data.draw(st.integers(1, 8))
    numbers = st.integers(-3, 3)
    J = data.draw(arrays(np.int64, (m, n), elements=numbers)).astype(float)
    r = data.draw(arrays(np.int64, (m,), elements=numbers)).astype(float)
    g = data.draw(arrays(np.int64, (n,), elements=numbers)).astype(float)
    check_against_pinv(J, r, g)


@settings(deadline=None, max_examples=100)
@given(st.integers(0, 2**32 - 1), st.integers(0, 12))
def test_the_null_space_part_is_a_projection_and_J_maps_it_to_zero(seed, digits):
    """Moore-Penrose conditions at condition numbers up to 1e6 and at exact rank loss beyond."""
    rng = np.random.default_rng(seed)
    U, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    W, _ = np.linalg.qr(rng.standard_normal((7, 7)))
    last = 10.0**-digits if digits <= 6 else 0.0
    J = U @ np.diag([1.0, 0.5, last]) @ W[:3]
    g = rng.standard_normal(7)
    _, _, null, _, rank = answers(J, np.zeros(3), g)
    assert rank == (3 if last else 2)
    # Gram-Schmidt loses orthogonality in proportion to the condition number
    assert np.linalg.norm(J @ null) <= FACTOR * EPS / (last or 0.5) * np.linalg.norm(g)
    again = answers(J, np.zeros(3), null)[2]
    assert again == pytest.approx(null, abs=FACTOR * EPS / (last or 0.5) * np.linalg.norm(g))


def with_condition(condition, m, n, rng):
    """A random matrix whose singular values fall from 1 to the reciprocal of ``condition`` in equal ratios."""
    U, _ = np.linalg.qr(rng.standard_normal((m, m)))
    W, _ = np.linalg.qr(rng.standard_normal((n, n)))
    return U @ np.diag(np.logspace(0, -np.log10(condition), m)) @ W[:m]


def weak_row_first(condition, m, n, rng):
    """Two nearly parallel rows, then a row along their difference: entries of L as large as the condition number."""
    J = rng.standard_normal((m, n))
    difference = J[1].copy()
    J[1] = J[0] + difference / condition
    J[2] += 3 * difference
    return J


def nearly_straight(condition, m, n, rng):
    """An arm of n links that is bent by the reciprocal of ``condition``, along no coordinate axis."""
    q = rng.uniform(-1, 1, n) / condition
    q[0] += 0.7
    return jtik.Robot.planar(n).jacobian(q, "tip")[:m]


def residual(J, x, r):
    """|J x - r| / |r| with more digits than the solution has."""
    return float(np.linalg.norm(J.astype(np.longdouble) @ x - r) / np.linalg.norm(r))


ILL_CONDITIONED = [(with_condition, 2, 10), (with_condition, 6, 7), (weak_row_first, 3, 7), (nearly_straight, 2, 10)]


@pytest.mark.thinned
@pytest.mark.parametrize("digits", range(2, 8))
@pytest.mark.parametrize(("matrix", "m", "n"), ILL_CONDITIONED)
def test_residuals_grow_with_the_condition_number_and_not_with_its_square(matrix, m, n, digits, rng):
    for _ in range(20):
        J = matrix(10.0**digits, m, n, rng)
        r, dual = rng.standard_normal((2, m))
        _, sigma, V = np.linalg.svd(J, full_matrices=False)
        g = V.T @ dual  # in the row space
        x, image, null, multipliers, rank = answers(J, r, g)
        slack = FACTOR * EPS * sigma[0] / sigma[-1]
        assert rank == m
        assert residual(J, x, r) <= slack
        assert image == pytest.approx(r, abs=slack * np.linalg.norm(r))
        assert residual(J.T, multipliers, g) <= slack
        assert np.linalg.norm(null) <= slack * np.linalg.norm(g)


def cholesky_solution(J, r):
    """J' (J J')^-1 r."""
    factor = np.linalg.cholesky(J @ J.T)
    return J.T @ np.linalg.solve(factor.T, np.linalg.solve(factor, r))


def condition_table(rng):
    """Rows of the table in formulations/factorization.md: condition, then medians of |J x - r| / |r| of 6 x 7."""
    rows = []
    for digits in range(2, 9):
        each = []
        for _ in range(200):
            J, r = with_condition(10.0**digits, 6, 7, rng), rng.standard_normal(6)
            ours = answers(J, r, np.zeros(7))[0]
            solutions = (ours, cholesky_solution(J, r), np.linalg.pinv(J, rcond=1e-15) @ r)
            each.append([residual(J, x, r) for x in solutions])
        rows.append([10.0**digits, *np.median(each, axis=0)])
    return rows


@pytest.mark.slow
def test_the_table_of_residuals_in_the_derivation(rng):
    text = (Path(__file__).parents[2] / "formulations" / "factorization.md").read_text()
    printed = [[float(cell) for cell in line.split("|")[1:-1]] for line in text.splitlines() if line.startswith("| 1e")]
    for line, computed in zip(printed, condition_table(rng), strict=True):
        assert np.log10(line) == pytest.approx(np.log10(computed), abs=0.5)


@pytest.mark.thinned
@pytest.mark.parametrize("digits", range(1, 7))
@pytest.mark.parametrize(("m", "n", "rank"), [(2, 10, 1), (3, 7, 2), (6, 7, 3), (6, 12, 5)])
def test_so_they_do_with_dependent_rows(m, n, rank, digits, rng):
    for _ in range(20):
        J = rng.standard_normal((m, rank)) @ with_condition(10.0**digits, rank, n, rng)
        r, dual = rng.standard_normal((2, m))
        U, sigma, V = np.linalg.svd(J)
        U, sigma = U[:, :rank], sigma[:rank]
        g = V[:rank].T @ dual[:rank]
        x, image, _, multipliers, found = answers(J, r, g)
        slack = FACTOR * EPS * sigma[0] / sigma[-1]
        assert found == rank
        assert J @ x == pytest.approx(U @ (U.T @ r), abs=slack * np.linalg.norm(r))
        assert image == pytest.approx(U @ (U.T @ r), abs=slack * np.linalg.norm(r))
        assert J.T @ multipliers == pytest.approx(g, abs=slack * np.linalg.norm(g))

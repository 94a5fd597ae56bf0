"""Exact rows: equalities that hold to rounding, against NumPy's pseudo-inverse and optimality conditions."""

from __future__ import annotations

import numpy as np
import pytest

from jtik.qp.refinement import refinement

ACCURACY = 1e-7
SOLVER_NOISE = 1e-8
"""Size of the errors that are added to exact solutions: the tolerance of DAQP."""

ROUNDING = 1e-14


def solved(C, q, low, high, active):
    """x with 1/2 |x|^2 + q' x minimal where C x = 0 and each active variable is at its bound, and its multipliers."""
    n = len(q)
    x = np.where(active > 0, high, np.where(active < 0, low, 0.0))
    free = active == 0
    rhs = -C[:, ~free] @ x[~free]
    F = C[:, free]
    shortest = np.linalg.pinv(F) @ rhs
    x[free] = shortest - (np.eye(free.sum()) - np.linalg.pinv(F) @ F) @ q[free]
    y = np.linalg.lstsq(F.T, -(x + q)[free], rcond=None)[0]
    return x, np.where(free, 0.0, -(x + q + C.T @ y)) + np.zeros(n)


def call(C, to, lower, upper, x, multipliers, accuracy=ACCURACY, exact=None):
    refine = refinement(C.shape[1], len(C), range(len(C)) if exact is None else exact)
    low, high = to if isinstance(to, tuple) else (to, to)
    return np.array(refine(C, low, high, lower, upper, x, multipliers, accuracy)).ravel()


@pytest.mark.quick(1)
@pytest.mark.parametrize("active_count", [0, 1, 3])
def test_a_noisy_solution_satisfies_the_rows_and_stays_in_the_box(rng, active_count):
    for _ in range(20):
        C = np.linalg.qr(rng.normal(size=(8, 3)))[0].T
        lower, upper = -rng.uniform(3, 5, 8), rng.uniform(3, 5, 8)
        active = np.zeros(8)
        active[:active_count] = rng.choice([-1, 1], active_count)
        lower[:active_count] = upper[:active_count] = 0.0
        lower[:active_count] -= active[:active_count] > 0
        upper[:active_count] += active[:active_count] < 0
        exact, multipliers = solved(C, 0.3 * rng.normal(size=8), lower, upper, active)
        multipliers = np.abs(multipliers) * active
        noisy = exact + SOLVER_NOISE * rng.uniform(-1, 1, 8)
        x = call(C, np.zeros(3), lower, upper, noisy, multipliers)
        assert np.abs(C @ noisy).max() > 1e-10
        assert np.abs(C @ x).max() <= ROUNDING
        assert (x >= lower).all()
        assert (x <= upper).all()
        assert x[:active_count] == pytest.approx(exact[:active_count], abs=0)
        assert np.abs(x - exact).max() <= 10 * SOLVER_NOISE


def test_a_right_hand_side_is_kept(rng):
    C, to = rng.normal(size=(2, 5)), np.array([0.3, -0.2])
    exact = np.linalg.pinv(C) @ to
    x = call(C, to, np.full(5, -9.0), np.full(5, 9.0), exact + SOLVER_NOISE * rng.normal(size=5), np.zeros(5))
    assert np.abs(C @ x - to).max() <= 1e-15


def test_a_variable_that_the_correction_moves_out_of_the_box_stays_at_its_bound():
    C, upper = np.array([[1.0, 1.0, 1.0]]), np.array([0.5, 9.0, 9.0])
    noisy = np.array([0.5 - 1e-12, -0.2, -0.3 - 3e-8])  # a third of 3e-8 is to be added to each
    x = call(C, np.zeros(1), -upper, upper, noisy, np.zeros(3))
    assert x[0] == 0.5
    assert abs(x.sum()) <= 1e-16
    assert x == pytest.approx([0.5, -0.2 + 1.5e-8, -0.3 - 1.5e-8], abs=1e-12)


def test_rows_whose_bounds_differ_and_rows_that_are_not_exact_are_left_alone(rng):
    C = np.eye(3, 5)
    noisy = np.full(5, SOLVER_NOISE) + np.array([0, 0, 0, 0.5, 0.5])
    low, high = np.array([0.0, -np.inf, 0.0]), np.array([0.0, np.inf, 0.0])
    x = call(C, (low, high), np.full(5, -9.0), np.full(5, 9.0), noisy, np.zeros(5), exact=[0, 1])
    assert x == pytest.approx([0.0, *noisy[1:]], abs=1e-20)


def test_noise_is_not_taken_for_a_solution(rng):
    """A solution as short as its error: the correction would be an arbitrary direction."""
    C, noise = np.eye(2, 4), 1e-12 * rng.normal(size=4)
    x = call(C, np.zeros(2), np.full(4, -9.0), np.full(4, 9.0), noise, np.zeros(4))
    assert np.array_equal(x, noise)


def test_rows_that_the_free_variables_cannot_satisfy_leave_the_solution_in_the_box(rng):
    C = np.array([[1.0, 1.0, 0.0], [1.0, -1.0, 0.0]])
    upper = np.array([0.0, 0.0, 9.0])
    x = call(C, np.zeros(2), upper - 9, upper, np.array([1e-9, 2e-9, 0.5]), np.array([1.0, 1.0, 0.0]))
    assert x == pytest.approx([0.0, 0.0, 0.5], abs=0)
    x = call(C, np.array([1e-3, 0.0]), upper - 9, upper, np.array([1e-9, 2e-9, 0.5]), np.array([1.0, 1.0, 0.0]))
    assert x == pytest.approx([0.0, 0.0, 0.5], abs=SOLVER_NOISE)


def test_other_rows_do_not_suffer():
    """A row in another unit, a thousand times as steep: the correction would violate it by more than the accuracy."""
    C = np.array([[1.0, 1.0, 1.0], [1e3, 0.0, 0.0]])
    x = np.array([-0.2, 0.1, 0.1 - 3e-9])
    low, high = np.array([0.0, -np.inf]), np.array([0.0, -200.0])
    box = np.full(3, 9.0)
    assert np.array_equal(call(C, (low, high), -box, box, x, np.zeros(3), exact=[0]), x)
    high = np.array([0.0, -199.0])
    assert abs(call(C, (low, high), -box, box, x, np.zeros(3), exact=[0]).sum()) <= 1e-16


def test_nan_remains_nan():
    x = call(np.ones((1, 2)), np.zeros(1), -np.ones(2), np.ones(2), np.full(2, np.nan), np.full(2, np.nan))
    assert np.isnan(x).all()

"""A task displacement fitted into a box: published numbers, and the linear program of the largest share."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from scipy.optimize import linprog, lsq_linear

from jtik.qp.call import FunctionCall
from jtik.qp.few_saturated import few_saturated
from jtik.qp.fitting import OF_ERROR, fitting, least_error_fitting
from jtik.symbolic.compile import CompiledFunction

TOLERANCE = 1e-6
"""Accuracy of the QP solver, relative to the displacement."""


@functools.cache
def built(make, m, n):
    return CompiledFunction(make(m, n))


def direct_or_by_qp(m, n):
    """As a step has it: the QP is solved where the direct result is none."""
    return FunctionCall("fitting", fitting(m, n), few_saturated(m, n)).complete


def fitted(J, t, lower, upper, make=direct_or_by_qp):
    return built(make, *J.shape)(J, t, lower, upper)[0][:, 0]


def largest_share(J, wanted, lower, upper):
    """The largest s up to 1 with J x = s wanted in the box."""
    n = J.shape[1]
    found = linprog(
        [*[0.0] * n, -1.0],
        A_eq=np.column_stack([J, -wanted]),
        b_eq=np.zeros(len(wanted)),
        bounds=[*zip(lower, upper, strict=True), (0.0, 1.0)],
    )
    return found.x[-1]


@pytest.mark.parametrize(
    ("share", "expected"),
    [
        (1.0, [2, -11 / 6, 11 / 6, -11 / 3]),
        (1.5, [2, -2, 26 / 11, -4]),
        (2.0, [2, -2, 26 / 11, -4]),
        (3.0, [2, -2, 26 / 11, -4]),
    ],
)
def test_the_published_example(share, expected):
    """Flacco, De Luca and Khatib (2012): the arm of four unit links."""
    J = np.array([[-2.0, -1.0, -1.0, 0.0], [2.0, 2.0, 1.0, 1.0]])
    t = share * np.linalg.pinv(J) @ [-4.0, -1.5]
    limit = np.array([2.0, 2.0, 4.0, 4.0])
    assert fitted(J, t, -limit, limit) == pytest.approx(expected, abs=TOLERANCE)


@pytest.mark.quick(2)
@pytest.mark.parametrize(("m", "n"), [(1, 3), (2, 4), (3, 7), (6, 7), (6, 6)])
def test_the_direction_is_kept_and_the_share_is_that_of_the_linear_program(m, n, rng):
    for _ in range(25):
        J, limit = rng.normal(size=(m, n)), rng.uniform(0.2, 2, n)
        lower, upper = -limit * rng.uniform(0.1, 1, n), limit
        wanted = rng.normal(size=m) * rng.uniform(0.1, 4)
        t = np.linalg.pinv(J) @ wanted
        x = fitted(J, t, lower, upper)
        assert (x >= lower).all()
        assert (x <= upper).all()
        share = (J @ x) @ wanted / (wanted @ wanted)
        assert np.linalg.norm(J @ x - share * wanted) <= TOLERANCE * np.linalg.norm(wanted)
        assert share == pytest.approx(largest_share(J, wanted, lower, upper), abs=TOLERANCE)


@pytest.mark.thinned
@pytest.mark.parametrize("of", ["zero", "repeated"])
@pytest.mark.parametrize("row", [0, 1, 2])
@pytest.mark.parametrize(("m", "n"), [(3, 3), (3, 7), (6, 7)])
def test_a_row_that_gives_no_direction_does_not_matter(m, n, row, of, rng):
    """As the row along x of an arm that moves in the y-z plane, whichever row it is."""
    compared = 0
    for _ in range(20):
        J = rng.normal(size=(m, n))
        J[row] = 0.0 if of == "zero" else J[row - 1]
        t = np.linalg.pinv(J) @ rng.normal(size=m)
        limit = np.abs(t).max() * rng.uniform(0.2, 1.0, n)
        wanted = J @ t
        most = largest_share(J, wanted, -limit, limit)
        if most < 0.02:  # blocked: the joints are clipped
            continue
        compared += 1
        x = fitted(J, t, -limit, limit)
        share = (J @ x) @ wanted / (wanted @ wanted)
        assert np.linalg.norm(J @ x - share * wanted) <= TOLERANCE * np.linalg.norm(wanted)
        assert share == pytest.approx(most, abs=TOLERANCE)
    assert compared >= 10


@pytest.mark.quick(2)
@pytest.mark.parametrize(("m", "n", "most"), [(2, 4, 45), (3, 7, 26), (6, 7, 35), (6, 6, 33), (6, 8, 36)])
def test_few_saturated_joints_need_no_solver(m, n, most, rng):
    """Also beside joints that cannot move and rows that depend on others; wherever it is found, it is the solution."""
    few, count = CompiledFunction(few_saturated(m, n)), 0
    for k in range(50):
        J, limit = rng.normal(size=(m, n)), rng.choice([0.0, 0.7, 1.5, 3.0], n, p=[0.03, 0.17, 0.3, 0.5])
        if k % 10 == 0:
            J[-1] = J[0]
        t = np.linalg.pinv(J) @ rng.normal(size=m)
        limit = limit * np.abs(t)
        x, found = few(J, t, -limit, limit)
        if not found[0, 0]:
            continue
        count += 1
        x, wanted = x[:, 0], J @ t
        share = (J @ x) @ wanted / (wanted @ wanted)
        assert (np.abs(x) <= limit).all()
        assert np.linalg.norm(J @ x - share * wanted) <= TOLERANCE * np.linalg.norm(wanted)
        assert share == pytest.approx(largest_share(J, wanted, -limit, limit), abs=TOLERANCE)
        free = np.abs(x) < limit - TOLERANCE
        multipliers, *_ = np.linalg.lstsq(J[:, free].T, (x - t)[free], rcond=None)
        if share > 1 - TOLERANCE and np.linalg.matrix_rank(J[:, free]) == m:  # of these the closest to t
            residual = x - t - J.T @ multipliers
            assert np.abs(residual[free]).max() <= TOLERANCE
            assert (residual[~free] * np.sign(x[~free]) <= TOLERANCE).all()
    assert count >= most


def test_of_these_the_closest_to_the_displacement(rng):
    """The conditions of optimality: t - x is in the row space but for the joints at a bound, which t pushes outward."""
    for _ in range(40):
        J, limit = rng.normal(size=(2, 5)), rng.uniform(0.5, 1, 5)
        t = rng.normal(size=5)
        x = fitted(J, t, -limit, limit)
        wanted = J @ t
        if largest_share(J, wanted, -limit, limit) < 1:
            continue
        free = np.abs(x) < limit - TOLERANCE
        multipliers, *_ = np.linalg.lstsq(J[:, free].T, (x - t)[free], rcond=None)
        if np.linalg.matrix_rank(J[:, free]) < 2:
            continue
        residual = x - t - J.T @ multipliers
        assert np.abs(residual[free]).max() <= 1e-5
        assert (residual[~free] * np.sign(x[~free]) <= 1e-5).all()


def test_at_a_singular_pose():
    J = np.array([[0.0, 0.0, 0.0], [3.0, 2.0, 1.0]])
    limit = np.array([0.1, 1.0, 1.0])
    t = np.linalg.pinv(J) @ [0.0, 1.0]
    x = fitted(J, t, -limit, limit)
    assert J @ x == pytest.approx([0.0, 1.0], abs=TOLERANCE)
    assert x == pytest.approx([0.1, 0.28, 0.14], abs=TOLERANCE)


def test_a_blocked_direction_is_left_and_the_joints_are_clipped():
    J, t = np.array([[1.0, 0.0], [0.0, 1.0]]), np.array([1.0, 1.0])
    assert fitted(J, t, np.array([-1.0, -1.0]), np.array([0.0, 0.5])).tolist() == [0.0, 0.5]


@pytest.mark.quick(2)
@pytest.mark.parametrize(("m", "n"), [(1, 3), (2, 4), (3, 7), (6, 7), (6, 6)])
def test_the_error_is_the_smallest_in_the_box(m, n, rng):
    for _ in range(25):
        J, limit = rng.normal(size=(m, n)), rng.uniform(0.2, 2, n)
        lower, upper = -limit * rng.uniform(0.1, 1, n), limit
        t = np.linalg.pinv(J) @ rng.normal(size=m) * rng.uniform(0.1, 4)
        x = fitted(J, t, lower, upper, least_error_fitting)
        assert (x >= lower).all()
        assert (x <= upper).all()
        weighted = np.vstack([np.sqrt(OF_ERROR) / np.linalg.norm(J) * J, np.eye(n)])
        oracle = lsq_linear(weighted, weighted @ t, (lower, upper), tol=1e-14).x
        assert np.linalg.norm(J @ (x - t)) == pytest.approx(np.linalg.norm(J @ (oracle - t)), rel=1e-5, abs=1e-6)
        best = lsq_linear(J, J @ t, (lower, upper), tol=1e-14)
        distance = np.linalg.norm(J) * np.linalg.norm(best.x - t)
        bound = np.hypot(np.sqrt(2 * best.cost), distance / np.sqrt(OF_ERROR))
        assert np.linalg.norm(J @ (x - t)) <= 1.001 * bound + TOLERANCE * np.linalg.norm(J) * np.linalg.norm(t)


def test_of_all_displacements_with_the_smallest_error_it_is_the_closest():
    J, t, limit = np.array([[1.0, 1.0, 0.0]]), np.array([1.0, 1.0, 0.5]), np.array([0.6, 3.0, 3.0])
    x = fitted(J, t, -limit, limit, least_error_fitting)
    assert x == pytest.approx([0.6, 1.4, 0.5], abs=1e-3)


def test_with_more_rows_than_joints_what_is_in_the_box_is_kept(rng):
    J, t = rng.normal(size=(5, 3)), np.array([0.4, -0.2, 0.1])
    few = CompiledFunction(few_saturated(5, 3))
    x, found = few(J, t, -np.ones(3), np.ones(3))
    assert found[0, 0]
    assert x[:, 0].tolist() == t.tolist()

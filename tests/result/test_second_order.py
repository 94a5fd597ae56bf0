"""The lowest curvature over the motions that task and limits allow, against a search over directions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import null_space

from jtik.result.second_order import lowest_curvature

FREE = np.ones(4, dtype=bool)
NONE = np.zeros(4)


def problem(rng):
    W = rng.normal(size=(4, 4))
    return (W + W.T) / 2, rng.normal(size=(2, 4))


def circle(J, directions=20001):
    """Unit vectors of a null space of two dimensions."""
    angles = np.linspace(0, 2 * np.pi, directions)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1) @ null_space(J).T


def smallest(W, z):
    return np.einsum("ki,ij,kj->k", z, W, z).min()


def test_without_limits_it_is_the_lowest_eigenvalue(rng):
    for _ in range(50):
        W, J = problem(rng)
        found = lowest_curvature(W, J, FREE, NONE, 1e-9)
        assert found.value == pytest.approx(smallest(W, circle(J)), abs=1e-5)
        assert found.direction @ W @ found.direction == pytest.approx(found.value, abs=1e-12)
        assert np.linalg.norm(found.direction) == pytest.approx(1.0)
        assert J @ found.direction == pytest.approx(0.0, abs=1e-12)
        assert found.kind == ("saddle" if found.value < 0 else "minimum")


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_one_joint_at_a_limit_moves_inward_only(sign, rng):
    """Over the half circle of the directions allowed the search over directions finds no smaller one."""
    kinds = set()
    for _ in range(100):
        W, J = problem(rng)
        inward = sign * np.eye(4)[2]
        found = lowest_curvature(W, J, FREE & (inward == 0), inward, 1e-9)
        z = circle(J)
        least = smallest(W, z[z @ inward >= 0])
        if least < -1e-3:
            assert found.value < 0
            assert found.direction @ inward >= -1e-9
            assert J @ found.direction == pytest.approx(0.0, abs=1e-12)
            assert found.direction @ W @ found.direction == pytest.approx(found.value, abs=1e-12)
        elif least > 1e-3:
            assert found.value > 0
        kinds.add(found.kind)
    assert kinds == {"saddle", "minimum"}


@pytest.mark.slow
def test_several_joints_at_limits_move_inward_only(rng):
    """A direction that is found is always allowed; most of those that exist are found."""
    missed = existing = 0
    for _ in range(200):
        W, J = problem(rng)
        inward = np.array([0.0, *rng.choice([-1.0, 1.0], 3)])
        found = lowest_curvature(W, J, inward == 0, inward, 1e-9)
        z = circle(J)
        allowed = z[(z * inward >= 0).all(axis=1)]
        least = smallest(W, allowed) if len(allowed) else np.inf
        if found.value < 0:
            assert (found.direction * inward >= -1e-9).all()
            assert found.value >= least - 2e-3  # the directions on the circle are 3e-4 apart
        if least < -1e-3:
            existing += 1
            missed += found.value >= 0
    assert existing > 30
    assert missed <= 0.1 * existing


def test_where_nothing_can_move_it_is_a_minimum():
    W, J = -np.eye(4), np.eye(4)
    assert lowest_curvature(W, J, FREE, NONE, 1e-9).kind == "minimum"
    assert lowest_curvature(W, J[:2], ~FREE, NONE, 1e-9).kind == "minimum"


def test_a_curvature_of_zero_is_flat():
    W, J = np.diag([5.0, 5.0, 1e-7, 1.0]), np.eye(4)[:2]
    assert lowest_curvature(W, J, FREE, NONE, 1e-9).kind == "flat"
    assert lowest_curvature(-W, J, FREE, NONE, 1e-9).kind == "saddle"


def test_combinations_of_rows_that_no_motion_changes_are_reported():
    W, J = np.eye(4), np.array([[1.0, 0, 0, 0], [2.0, 0, 0, 0]])
    missing = lowest_curvature(W, J, FREE, NONE, 1e-9).missing
    assert missing.shape == (2, 1)
    assert missing[:, 0] @ J == pytest.approx(0.0, abs=1e-12)

"""The reduced gradient: as short as multipliers of rows and limits make it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from jtik.result.reduced_gradient import reduced_gradient

RANK = 1e-10


def shortest(J, gradient, at_upper, at_lower):
    """|gradient + J' lambda + limits| at its smallest, by nnls in the null space of J: an independent oracle."""
    n = len(gradient)
    null = np.linalg.svd(J)[2][np.linalg.matrix_rank(J) :]
    columns = [np.eye(n)[j] for j in at_upper] + [-np.eye(n)[j] for j in at_lower]
    if not columns:
        return float(np.linalg.norm(null @ gradient))
    return nnls(null @ np.array(columns).T, -null @ gradient)[1]


@pytest.mark.parametrize("size", [(2, 4), (2, 10), (3, 5), (6, 7), (6, 30), (0, 3)])
def test_it_is_the_shortest(size, rng):
    m, n = size
    for _ in range(60):
        J, gradient = rng.normal(size=(m, n)), rng.normal(size=n)
        if rng.random() < 0.3:
            gradient = J.T @ rng.normal(size=m) + 1e-6 * rng.normal(size=n)
        at = rng.permutation(n)[: rng.integers(0, n + 1)]
        upper, lower, both = np.split(at, sorted(rng.integers(0, len(at) + 1, size=2)))
        free, reduced, multipliers = reduced_gradient(J, gradient, {*upper, *both}, {*lower, *both}, RANK)
        np.testing.assert_allclose(reduced, gradient + J.T @ multipliers, atol=1e-12)
        limits = [*upper, *both], [*lower, *both]
        assert np.linalg.norm(reduced[free]) == pytest.approx(shortest(J, gradient, *limits), rel=1e-7, abs=1e-12)
        assert not free[both].any()
        small = 1e-9 * np.linalg.norm(gradient)
        assert (reduced[[j for j in upper if not free[j]]] <= small).all()
        assert (reduced[[j for j in lower if not free[j]]] >= -small).all()


def test_rows_that_depend_on_each_other(rng):
    for _ in range(40):
        J = rng.normal(size=(4, 2)) @ rng.normal(size=(2, 8))
        gradient, at = rng.normal(size=8), rng.permutation(8)[:5]
        free, reduced, _ = reduced_gradient(J, gradient, at[:3], at[3:], RANK)
        assert np.linalg.norm(reduced[free]) == pytest.approx(shortest(J, gradient, at[:3], at[3:]), rel=1e-7)


def test_a_limit_that_was_released_becomes_active_again():
    """Where releasing one limit after the other, and none of them again, does not find the shortest."""
    found = 0
    for seed in range(200):
        rng = np.random.default_rng(seed)
        J, gradient = rng.normal(size=(2, 6)), rng.normal(size=6)
        free, reduced, _ = reduced_gradient(J, gradient, range(5), (), RANK)
        only_released = np.array([False] * 5 + [True])
        while True:
            multipliers = -np.linalg.pinv(J[:, only_released].T) @ gradient[only_released]
            rest = gradient + J.T @ multipliers
            inward = [j for j in range(5) if not only_released[j] and rest[j] > 0]
            if not inward:
                break
            only_released[max(inward, key=lambda j: rest[j])] = True
        found += np.linalg.norm(rest[only_released]) > 1.001 * np.linalg.norm(reduced[free])
    assert found > 5

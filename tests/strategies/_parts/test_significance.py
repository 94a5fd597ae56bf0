"""A direction in the null space counts where it is longer than the rounding of its computation."""

from __future__ import annotations

import numpy as np
import pytest
from casadi import DM, SX

from jtik_formulations.strategies._parts.significance import LEAKAGE, NOISE, in_null_space, significant

from ...strategy.conftest import numbers, quadratic_model


@pytest.mark.parametrize(("length", "expected"), [(2 * NOISE, 1), (0.5 * NOISE, 0), (0.0, 0)])
@pytest.mark.parametrize("size", [1e-6, 1.0, 1e9])
def test_it_is_relative_to_the_gradient(length, expected, size):
    assert numbers(significant(length * size, size)) == expected


def test_a_gradient_in_the_row_space_leaves_no_significant_direction(rng):
    """The gradient is a combination of the rows of J; one part in a million beside them is significant."""
    for _ in range(20):
        J = rng.normal(size=(2, 6))
        inside, beside = J.T @ rng.normal(size=2), np.linalg.svd(J)[2][-1]
        for g, expected in ((inside, 0), (inside + 1e-6 * beside, 1)):
            model = quadratic_model(J, np.zeros(2), gradient=g)
            assert numbers(significant(model.null_gradient_norm, model.gradient_norm)) == expected


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e3])
def test_a_displacement_is_in_the_null_space_relative_to_the_longer_part_of_the_step(rng, size):
    K = np.linalg.qr(rng.normal(size=(6, 2)))[0].T
    null = np.linalg.svd(K)[2][-1]
    for leak, task, expected in ((0.5, 0.0, 1), (2.0, 0.0, 0), (2.0, 4.0, 1)):
        dq = size * (null + leak * LEAKAGE * K[0])
        assert numbers(in_null_space(SX(DM(K)), SX(DM(dq)), SX(DM(size * task * null)))) == expected

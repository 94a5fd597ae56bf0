"""The step of damped least squares for a given damping, against NumPy."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

from jtik_formulations.strategies._parts.damped_least_squares import DampedLeastSquares

from ...strategy.conftest import numbers, quadratic_model


@dataclass(frozen=True, kw_only=True)
class Constant(DampedLeastSquares):
    damping: float = 0.1

    def damping_of(self, model):
        return self.damping


@pytest.mark.parametrize("damping", [1e-3, 0.1, 10.0])
@pytest.mark.parametrize("active", [(), (2,)], ids=["all free", "one active"])
def test_it_is_the_damped_pseudo_inverse_of_the_free_joints(damping, active, rng):
    J, r = rng.normal(size=(2, 4)), rng.normal(size=2)
    free = J.copy()
    free[:, list(active)] = 0
    found = numbers(Constant(damping=damping).full_step(quadratic_model(J, r, active=active), {}).dq)
    assert found == pytest.approx(-free.T @ np.linalg.solve(free @ free.T + damping * np.eye(2), r))


def test_it_is_bounded_at_a_singular_pose():
    """|J' (J J' + mu)^-1 r| is at most |r| / (2 sqrt(mu))."""
    J, r = np.array([[1.0, 1.0], [1.0, 1.0 + 1e-9]]), np.array([1.0, -1.0])
    step = numbers(Constant(damping=0.04, q_limit=math.inf).full_step(quadratic_model(J, r), {}).dq)
    assert np.linalg.norm(step) <= np.linalg.norm(r) / (2 * 0.2)

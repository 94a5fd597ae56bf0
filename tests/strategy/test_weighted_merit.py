"""The weighted sum of V and H as a merit function, on linear tasks with quadratic criteria."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.strategy import Proposal, WeightedMerit

from .conftest import numbers, quadratic_model

J = np.array([[1.0, 2.0, 0.5], [0.0, 1.0, -1.0]])
R = np.array([0.4, -0.3])
G = np.array([0.2, -1.0, 0.5])
MERIT = WeightedMerit(gain=2.0, weight=0.1)


def verdict_on(dq, predicted, **options):
    model = quadratic_model(J, R, **options)
    proposal = Proposal(casadi.SX(dq), predicted_decrease=casadi.SX(predicted))
    return MERIT.verdict(model, {}, proposal, model.candidate(casadi.SX(dq)))


def decrease(dq, criterion):
    """Of gain V + weight H along dq, in closed form."""
    V = lambda r: r @ r / 2  # noqa: E731
    H = G @ dq + dq @ dq / 2 if criterion else 0.0
    return 2.0 * (V(R) - V(R + J @ dq)) - 0.1 * H


@pytest.mark.parametrize("criterion", [False, True])
class TestArmijo:
    def test_a_step_is_accepted_iff_the_sum_falls_sufficiently(self, criterion, rng):
        options, accepted = ({"gradient": G} if criterion else {}), 0
        for _ in range(60):
            dq = rng.uniform(-0.5, 0.5, 3)
            expected = decrease(dq, criterion) >= 1e-4 * 0.3
            accepted += expected
            assert bool(numbers(verdict_on(dq, 0.3, **options).accepted)) is bool(expected)
        assert 5 < accepted < 55

    def test_more_than_ten_thousand_times_too_little_is_refused(self, criterion):
        options = {"gradient": G} if criterion else {}
        dq = -np.linalg.pinv(J) @ R
        actual = decrease(dq, criterion)
        assert numbers(verdict_on(dq, 0.99e4 * actual, **options).accepted)
        assert not numbers(verdict_on(dq, 1.01e4 * actual, **options).accepted)

    def test_a_step_that_promises_nothing_is_refused(self, criterion):
        assert not numbers(verdict_on(-np.linalg.pinv(J) @ R, 0.0, **({"gradient": G} if criterion else {})).accepted)


def test_progress_is_the_decrease_relative_to_the_sum():
    dq = -np.linalg.pinv(J) @ R
    H = G @ dq + dq @ dq / 2
    size = 2.0 * (R @ R) / 2 + 0.1 * abs(H)  # H is 0 before the step
    assert numbers(verdict_on(dq, 0.3, gradient=G).progress) == pytest.approx(decrease(dq, True) / size)
    assert verdict_on(dq, 0.3).progress is None


def test_the_prediction_is_the_proposals():
    assert numbers(verdict_on(np.zeros(3), 0.7, gradient=G).predicted_decrease) == 0.7

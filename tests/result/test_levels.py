"""Levels of priority: which are reached, the gradient beside those above, what remains of a task."""

from __future__ import annotations

import numpy as np
import pytest

from jtik.result.levels import Levels

ROWS = ((0, 1), (2,), (3,))


def levels(error, weighted=None, limits=((), ())):
    error = np.array(error)
    weighted = np.eye(4, 5) if weighted is None else np.array(weighted)
    return Levels(
        rows=ROWS,
        tasks={"hand": (0, 1), "tilt": (2,), "turn": (3,)},
        error=error,
        linear=np.array([True, True, False, False]),
        residual=error,
        weighted=weighted,
        limits=limits,
        tolerances=(1e-6, 1e-3),
        rank_threshold=1e-9,
    )


@pytest.mark.parametrize(
    ("error", "count"),
    [([0, 0, 0, 0], 3), ([1e-7, 0, 9e-4, 0.5], 2), ([0, 0, 0.1, 0], 1), ([2e-6, 0, 0, 0], 0)],
)
def test_how_many_levels_are_reached(error, count):
    assert levels(error).reached == count


def test_a_level_that_those_above_fix_is_stationary():
    """The third row is the sum of the first two: it cannot move beside them."""
    fixed = [[1, 0, 0, 0, 0], [0, 1, 0, 0, 0], [1, 1, 0, 0, 0], [0, 0, 0, 1, 0]]
    assert levels([0, 0, 0.3, 0], fixed).relative_gradient() == pytest.approx((0, 0), abs=1e-15)
    assert levels([0, 0, 0.3, 0]).relative_gradient() == pytest.approx((1, 1))
    assert levels([0, 0, 0.3, 0.2], fixed).relative_gradient() == pytest.approx((1, 1))  # that of the last level


def test_a_limit_that_the_level_pushes_outward_keeps_it():
    """The negative gradient of the second level moves joint 3 down for a positive error."""
    down = levels([0, 0, 0.3, 0], limits=((), (2,)))
    assert down.relative_gradient() == pytest.approx((1, 0))
    up = levels([0, 0, 0.3, 0], limits=((2,), ()))
    assert up.relative_gradient() == pytest.approx((1, 1))


def test_what_remains_of_each_task():
    relaxed = levels([0, 0, 0.3, -0.2]).relaxed()
    assert [(each.name, each.amount, each.unit) for each in relaxed] == [
        ("task 'tilt'", 0.3, "rad"),
        ("task 'turn'", 0.2, "rad"),
    ]
    assert str(levels([3e-3, 4e-3, 0, 0]).relaxed()[0]) == "task 'hand' by 0.005 m"

"""Targets as plain values."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.problems.plain_values import frozen_array, frozen_target, plain_target


@pytest.mark.parametrize(
    ("target", "plain"),
    [
        (0.25, 0.25),
        (np.float64(0.25), 0.25),
        ([1, 2], [1.0, 2.0]),
        (((1, 2, 3), (1, 0, 0, 0)), [[1.0, 2.0, 3.0], [1.0, 0.0, 0.0, 0.0]]),
        ({"tip": [1, 2], "turn": 3}, {"tip": [1.0, 2.0], "turn": 3.0}),
        (np.eye(2), [[1.0, 0.0], [0.0, 1.0]]),
    ],
)
def test_targets_become_plain_data(target, plain):
    assert plain_target(frozen_target("target", target)) == plain


def test_an_array_is_a_read_only_copy():
    given = np.array([1.0, 2.0])
    frozen = frozen_array("q", given)
    given[0] = 9
    assert frozen.tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match="read-only"):
        frozen[0] = 3


@pytest.mark.parametrize("value", [[1, [2]], [np.nan], ["a"], [np.inf, 1]])
def test_values_that_are_not_finite_numbers_are_refused(value):
    with pytest.raises(jtik.ArgumentError) as caught:
        frozen_array("q", value)
    assert caught.value.argument == "q"

"""Checks of options: what each accepts, and the message for what it refuses."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik.strategy import check_choice, check_gain, check_non_negative, check_positive, check_step_limit

NOT_NUMBERS = [math.nan, "fast", None, [1.0, 2.0]]


@pytest.mark.parametrize(
    ("check", "accepted", "refused", "words"),
    [
        (check_positive, [1e-300, 2, np.float64(3)], [0.0, -1.0], "a positive, finite number"),
        (check_non_negative, [0.0, 1, 1e300], [-1e-300, -1], "a non-negative, finite number"),
        (check_step_limit, [1e-300, 2, math.inf, np.float64(0.5)], [0.0, -1.0, True], "a positive angle [rad]"),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_the_range_of_a_number(check, accepted, refused, words):
    for value in accepted:
        check("option", value)
    for value in refused:
        with pytest.raises(jtik.ArgumentError) as caught:
            check("option", value)
        assert (caught.value.argument, caught.value.given) == ("option", value)
        assert words in str(caught.value)


@pytest.mark.parametrize("value", NOT_NUMBERS, ids=repr)
@pytest.mark.parametrize("check", [check_positive, check_non_negative, check_step_limit], ids=lambda c: c.__name__)
def test_a_value_that_is_not_a_number_is_refused(check, value):
    with pytest.raises(jtik.ArgumentError, match="option"):
        check("option", value)


@pytest.mark.parametrize("check", [check_positive, check_non_negative], ids=lambda c: c.__name__)
def test_infinity_is_a_step_limit_only(check):
    check_step_limit("option", math.inf)
    with pytest.raises(jtik.ArgumentError, match="option: given inf; accepted: one finite number"):
        check("option", math.inf)


def test_a_gain_is_in_the_half_open_unit_interval():
    for value in (1e-300, 0.5, 1.0):
        check_gain(value)
    for value in (0.0, -0.5, np.nextafter(1.0, 2.0), math.nan, "all"):
        with pytest.raises(jtik.ArgumentError, match="gain"):
            check_gain(value)


def test_a_choice_is_one_of_the_texts():
    for value in ("one", "two", "three"):
        check_choice("option", value, ("one", "two", "three"))
    for value in ("four", "One", "", None, 1, ["one"]):
        with pytest.raises(jtik.ArgumentError, match="option: given .*; accepted: 'one', 'two' or 'three'"):
            check_choice("option", value, ("one", "two", "three"))

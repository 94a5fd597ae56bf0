"""Checks of options that several strategies have."""

from __future__ import annotations

import math
from numbers import Real

from jtik.errors import ArgumentError, finite_array


def check_positive(name: str, value: float) -> None:
    """Raise ArgumentError unless the value is a positive, finite number."""
    finite_array(name, value, ())
    if not 0 < value < math.inf:
        raise ArgumentError(name, value, "a positive, finite number")


def check_non_negative(name: str, value: float) -> None:
    """Raise ArgumentError unless the value is a non-negative, finite number."""
    finite_array(name, value, ())
    if not 0 <= value < math.inf:
        raise ArgumentError(name, value, "a non-negative, finite number")


def check_gain(value: float) -> None:
    """Raise ArgumentError unless ``gain``, the fraction of the error a step aims to remove, is in (0, 1]."""
    finite_array("gain", value, ())
    if not 0 < value <= 1:
        raise ArgumentError("gain", value, "a number in (0, 1]")


def check_step_limit(name: str, value: float) -> None:
    """Raise ArgumentError unless the value is a positive angle [rad] or infinite, for no limit."""
    if isinstance(value, bool) or not isinstance(value, Real) or not value > 0:
        raise ArgumentError(name, value, "a positive angle [rad], math.inf for none")


def check_choice(name: str, value: object, choices: tuple[str, ...]) -> None:
    """Raise ArgumentError unless the value is one of the choices."""
    if not (isinstance(value, str) and value in choices):
        *first, last = [repr(choice) for choice in choices]
        raise ArgumentError(name, value, f"{', '.join(first)} or {last}")

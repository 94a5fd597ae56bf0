"""Checks of numeric arguments of criteria."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import finite_array
from jtik.errors import ArgumentError
from jtik.types import Array


def number_between(argument: str, given: float, low: float, high: float) -> float:
    """The number. Raises ArgumentError unless it is finite and strictly between the two."""
    value = float(finite_array(argument, given, ()))
    if not low < value < high:
        raise ArgumentError(argument, given, f"a number between {low:g} and {high:g}, both excluded")
    return value


def vector(argument: str, given: ArrayLike, size: int) -> Array:
    """The numbers (size,). Raises ArgumentError where they have another shape or are not finite."""
    return finite_array(argument, given, (size,))


def direction(argument: str, given: ArrayLike, size: int) -> Array:
    """The numbers (size,), scaled to length 1. Raises ArgumentError where they are zero or have another shape."""
    value = finite_array(argument, given, (size,))
    length = float(np.linalg.norm(value))
    if not length > 0:
        raise ArgumentError(argument, given, f"{size} numbers that are not all zero")
    return value / length

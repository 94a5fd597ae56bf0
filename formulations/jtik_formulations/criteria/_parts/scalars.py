"""Readers of arguments of criteria: numbers in a range, points, directions, frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import array_of, finite_array, number
from jtik.arguments import name as read_name
from jtik.errors import ArgumentError
from jtik.types import Array

POINT = "2 or 3 finite numbers"
"""What a point or a direction is while the robot is not known."""


def number_between(argument: str, given: float, low: float, high: float) -> float:
    """The number. Raises ArgumentError unless it is finite and strictly between the two."""
    accepted = f"a number between {low:g} and {high:g}, both excluded"
    value = number(argument, given, accepted)
    if not low < value < high:
        raise ArgumentError(argument, given, accepted)
    return value


def number_from_to(argument: str, given: float, low: float, high: float) -> float:
    """The number. Raises ArgumentError unless it is from ``low`` to ``high``."""
    accepted = f"a number from {low:g} to {high:g}"
    value = number(argument, given, accepted, minimum=low)
    if value > high:
        raise ArgumentError(argument, given, accepted)
    return value


def frame_or_tip(frame: str | None) -> str | None:
    """The name of a frame, or None for the tip. Raises ArgumentError for anything else."""
    return None if frame is None else read_name("frame", frame, "the name of a frame, or None for the tip")


def point(argument: str, given: ArrayLike) -> Array:
    """A copy of the coordinates of a point, (2,) or (3,). Raises ArgumentError for anything else."""
    return array_of(argument, given, [(2,), (3,)], POINT)


def nonzero(argument: str, given: ArrayLike, *, rows: bool = False) -> Array:
    """A copy of a direction, (2,) or (3,), or of any length where it is in ``rows`` of a task.

    Raises:
        ArgumentError: for anything else, and where all numbers are zero.
    """
    accepted = f"{'finite numbers, one for each row,' if rows else POINT} that are not all zero"
    value = array_of(argument, given, [(None,)] if rows else [(2,), (3,)], accepted)
    if not np.any(value):
        raise ArgumentError(argument, given, accepted)
    return value


def vector(argument: str, given: ArrayLike, size: int) -> Array:
    """The numbers (size,). Raises ArgumentError where they have another shape or are not finite."""
    return finite_array(argument, given, (size,))


def direction(argument: str, given: ArrayLike, size: int) -> Array:
    """The numbers (size,), scaled to length 1. Raises ArgumentError where they are zero or have another shape."""
    value = finite_array(argument, given, (size,))
    largest = float(np.max(np.abs(value)))  # the norm may be too large or too small for a number
    if not largest > 0:
        raise ArgumentError(argument, given, f"{size} numbers that are not all zero")
    value = value / largest
    return np.asarray(value / np.linalg.norm(value))

"""Targets as plain values: read-only copies, and data that JSON stores without loss."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jtik.arguments import finite_array, shape_of
from jtik.types import Array


def frozen_array(argument: str, value: object) -> Array:
    """A read-only float64 copy of any shape. Raises ArgumentError unless all entries are finite numbers."""
    shape = shape_of(value)
    array = finite_array(argument, value, (None,) * len(shape or ()), "finite numbers")
    array.flags.writeable = False
    return array


def frozen_target(argument: str, target: Any) -> Any:
    """A copy of a target: a float, a read-only array, a pair of arrays, or a dict of these by task name.

    Raises:
        ArgumentError: unless all entries are finite numbers.
    """
    if isinstance(target, Mapping):
        return {str(name): frozen_target(f"{argument}[{name!r}]", value) for name, value in target.items()}
    if hasattr(target, "as_matrix") and not isinstance(target, type):
        target = target.as_matrix()
    if _is_pair(target):
        return tuple(frozen_array(argument, part) for part in target)
    array = frozen_array(argument, target)
    return float(array) if array.ndim == 0 else array


def plain_target(target: Any) -> Any:
    """A frozen target as numbers, lists and dicts."""
    if isinstance(target, dict):
        return {name: plain_target(value) for name, value in target.items()}
    if isinstance(target, tuple):
        return [part.tolist() for part in target]
    return target if isinstance(target, float) else target.tolist()


def _is_pair(target: Any) -> bool:
    """Whether the target is (position, quaternion): two vectors of different lengths."""
    if not isinstance(target, (tuple, list)) or len(target) != 2:
        return False
    return all(isinstance(part, (tuple, list, np.ndarray)) for part in target) and len(target[0]) != len(target[1])

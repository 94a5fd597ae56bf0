"""Norms of numbers without overflow: that of a vector with entries of 1e200 is finite, and no warning is given."""

from __future__ import annotations

import math

import numpy as np

from jtik.types import Array


def length(numbers: Array) -> float:
    """The Euclidean norm of all entries of an array."""
    return math.hypot(*numbers.ravel().tolist())


def lengths(rows: Array) -> Array:
    """The Euclidean norm of each row of a matrix (k, m), (k,)."""
    return np.array([length(row) for row in rows])

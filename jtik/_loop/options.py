"""The options of a solve, checked at the door."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from jtik._loop.search import Request
from jtik._step.inputs import Settings
from jtik.errors import ArgumentError, finite_array

Until = Literal["stationary", "reached"]


def read_settings(position: float, orientation: float, optimality: float, until: str) -> Settings:
    """Tolerances and what to wait for. Raises ArgumentError for what cannot be used, naming it."""
    if until not in ("stationary", "reached"):
        raise ArgumentError("until", until, "'stationary' or 'reached'")
    return Settings(
        positive("position_tolerance", position),
        positive("orientation_tolerance", orientation),
        positive("optimality_tolerance", optimality),
        1.0 if until == "stationary" else 0.0,
    )


def read_request(restarts: int, seed: int | None, max_iterations: int) -> Request:
    """What a search may spend. Raises ArgumentError for what is not a count, naming it."""
    return Request(
        limit=_count("max_iterations", max_iterations),
        restarts=_count("restarts", restarts),
        seed=0 if seed is None else _count("seed", seed),
    )


def positive(argument: str, value: float) -> float:
    """The value as a float. Raises ArgumentError unless it is finite and positive."""
    if type(value) is float and 0.0 < value < math.inf:
        return value
    number = float(finite_array(argument, value, ()))
    if not number > 0:
        raise ArgumentError(argument, value, "a positive number")
    return number


def _count(argument: str, value: int) -> int:
    if type(value) is int and value >= 0:
        return value
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 0:
        raise ArgumentError(argument, value, "an integer from 0")
    return int(value)

"""Values that are wrong for most arguments, and the kinds of arguments with the values that each of them accepts."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

VALUES: dict[str, Callable[[], object]] = {
    "None": lambda: None,
    "'x'": lambda: "x",
    "''": lambda: "",
    "True": lambda: True,
    "0.5": lambda: 0.5,
    "1.5": lambda: 1.5,
    "2": lambda: 2,
    "-1": lambda: -1,
    "0": lambda: 0,
    "nan": lambda: math.nan,
    "inf": lambda: math.inf,
    "1j": lambda: 1j,
    "[]": lambda: [],
    "[1, 'a']": lambda: [1, "a"],
    "[1.0, True]": lambda: [1.0, True],
    "{}": lambda: {},
    "object()": object,
    "(3, 5)": lambda: np.zeros((3, 5)),
    "text array": lambda: np.array(["1", "2"]),
    "complex array": lambda: np.array([1.0 + 0j, 0.5]),
    "masked array": lambda: np.ma.array([0.3, 0.5], mask=[True, False]),
    "boolean array": lambda: np.array([True, False]),
    "NaN array": lambda: np.array([math.nan, 0.5]),
    "10**400": lambda: 10**400,
    "bytes": lambda: b"x",
    "set": lambda: {0.5, 0.25},
    "generator": lambda: (each for each in (0.5, 0.25)),
    "class": lambda: int,
}
"""The values by label; each is made anew, since a generator can be read once. The arrays have the shape of q."""


class Kind(NamedTuple):
    """A kind of argument.

    Attributes:
        accepted: labels of the values that it accepts.
        skipped: labels of values that are accepted and not tried, because they take long or print.
    """

    accepted: frozenset[str]
    skipped: frozenset[str] = frozenset()

    def __or__(self, labels: str | tuple[str, ...]) -> Kind:  # type: ignore[override]
        more = (labels,) if isinstance(labels, str) else labels
        return Kind(self.accepted | set(more), self.skipped)

    def without(self, *labels: str) -> Kind:
        """The same kind, with these values left out of the trial."""
        return Kind(self.accepted, self.skipped | set(labels))


def _kind(*accepted: str) -> Kind:
    return Kind(frozenset(accepted))


NOTHING = _kind()
"""An object of a class, a choice of a few names, a name that must exist, an array of a shape that no value has."""

NUMBER = _kind("0.5", "1.5", "2", "-1", "0")
POSITIVE = _kind("0.5", "1.5", "2")
NON_NEGATIVE = POSITIVE | "0"
POSITIVE_OR_INFINITE = POSITIVE | "inf"
SHARE = _kind("0.5")
COUNT = _kind("0", "2")
POSITIVE_COUNT = _kind("2")
FLAG = _kind("True")
TEXT = _kind("'x'", "''")
NAME = _kind("'x'")
CONFIGURATION = _kind("{}")
"""A configuration: a dict from joint name to position may be empty."""

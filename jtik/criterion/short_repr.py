"""Short texts of values, for the repr of criteria."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

_SHOWN = 6
"""Vectors up to this length are shown in full."""


def summarize(value: Any) -> str:
    """A value in short: a vector of up to six numbers in full, a longer array by its ends and its shape."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key!r}: {summarize(each)}" for key, each in value.items()) + "}"
    if not isinstance(value, (list, tuple, np.ndarray, np.generic)):
        return repr(value)
    array = np.asarray(value)
    if array.ndim == 0:
        return repr(array.item())
    if array.ndim == 1 and array.size <= _SHOWN:
        return "[" + ", ".join(summarize(each) for each in array) + "]"
    flat = array.ravel()
    ends = f"[{summarize(flat[0])}, ..., {summarize(flat[-1])}]" if flat.size else "[]"
    return f"{ends} of shape {array.shape}"


def call_text(name: str, /, *leading: str, **values: Any) -> str:
    """``name(leading, key=value, ...)`` as text, with values in short."""
    return f"{name}({', '.join([*leading, *(f'{key}={summarize(value)}' for key, value in values.items())])})"

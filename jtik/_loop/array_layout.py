"""Where a NumPy array keeps its data, shape and type, for C that reads arrays without a conversion.

The layout is that of ``PyArrayObject_fields`` in NumPy's headers, which every extension module relies on. It is
compared with what some arrays tell of themselves before anything relies on it.
"""

from __future__ import annotations

import ctypes
import sys
from functools import cache

import numpy as np
from numpy.typing import NDArray

HEAD = object.__basicsize__
"""Size of the head of every object, at whose end is the address of its type."""


class Fields(ctypes.Structure):
    """The fields of an array after the head."""

    _fields_ = (
        ("data", ctypes.c_void_p),
        ("dimensions", ctypes.c_int),
        ("shape", ctypes.POINTER(ctypes.c_ssize_t)),
        ("strides", ctypes.POINTER(ctypes.c_ssize_t)),
        ("base", ctypes.c_void_p),
        ("type", ctypes.c_void_p),
    )


@cache
def is_known() -> bool:
    """Whether arrays of this interpreter and NumPy have this layout."""
    if sys.implementation.name != "cpython":
        return False
    table = np.arange(24.0).reshape(4, 6)
    return all(_as_told(array) for array in (table, table.T, table[::2, 1::3], np.zeros(7), table[:, 1]))


def _as_told(array: NDArray[np.float64]) -> bool:
    fields = Fields.from_address(id(array) + HEAD)
    kind = ctypes.c_void_p.from_address(id(array) + HEAD - ctypes.sizeof(ctypes.c_void_p)).value
    base = None if array.base is None else id(array.base)
    if (kind, fields.data, fields.dimensions) != (id(np.ndarray), array.ctypes.data, array.ndim):
        return False
    own = fields.shape[: array.ndim], fields.strides[: array.ndim], fields.base, fields.type
    return own == (list(array.shape), list(array.strides), base, id(np.dtype(np.float64)))

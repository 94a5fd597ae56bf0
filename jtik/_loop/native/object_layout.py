"""Where objects keep what C reads of them: an array its data, shape and type, a float its number, a slot its object.

The layout of arrays is that of ``PyArrayObject_fields`` in NumPy's headers, and that of floats is ``PyFloatObject`` in
Python's, which every extension module relies on. Both are compared with what some objects tell of themselves before
anything relies on them.
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


class Slot:
    """An object with one slot."""

    __slots__ = ("content",)

    def __init__(self, content: object) -> None:
        self.content = content


@cache
def is_known() -> bool:
    """Whether arrays, floats and slots of this interpreter and NumPy have this layout."""
    if sys.implementation.name != "cpython":
        return False
    slot, number = Slot(object()), 0.1
    if _pointer(slot, HEAD) != id(slot.content) or ctypes.c_double.from_address(id(number) + HEAD).value != number:
        return False
    table = np.arange(24.0).reshape(4, 6)
    return all(_as_told(array) for array in (table, table.T, table[::2, 1::3], np.zeros(7), table[:, 1]))


def tuples_have_items_only() -> bool:
    """Whether nothing but its length stands in a tuple before its items; Python 3.14 keeps its hash there."""
    return tuple.__basicsize__ == HEAD + ctypes.sizeof(ctypes.c_ssize_t)


def _pointer(of: object, offset: int) -> int | None:
    return ctypes.c_void_p.from_address(id(of) + offset).value


def _as_told(array: NDArray[np.float64]) -> bool:
    fields = Fields.from_address(id(array) + HEAD)
    kind = _pointer(array, HEAD - ctypes.sizeof(ctypes.c_void_p))
    base = None if array.base is None else id(array.base)
    if (kind, fields.data, fields.dimensions) != (id(np.ndarray), array.ctypes.data, array.ndim):
        return False
    own = fields.shape[: array.ndim], fields.strides[: array.ndim], fields.base, fields.type
    return own == (list(array.shape), list(array.strides), base, id(np.dtype(np.float64)))

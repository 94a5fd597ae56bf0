"""Functions of C that Python calls as those of an extension module: calls through ctypes take longer, the more so where
caches are cold.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik._loop.native.python_source import FUNCTIONS, NEW_ARRAY


class Method(ctypes.Structure):
    """Python's PyMethodDef."""

    _fields_ = (
        ("name", ctypes.c_char_p),
        ("call", ctypes.c_void_p),
        ("kind", ctypes.c_int),
        ("text", ctypes.c_char_p),
    )


class Memory(np.ndarray):
    """The addresses of what C reads and writes, which keep it alive. A function of C has them as its self.

    Attributes:
        kept: what is kept alive.
    """

    kept: dict[str, object]


def memory_of(
    members: Iterable[str],
    *,
    arrays: Mapping[str, NDArray[Any]],
    numbers: Mapping[str, int],
    objects: Mapping[str, object],
    kept: Mapping[str, object],
) -> Memory:
    """The memory with these members.

    Args:
        members: their names, in their order; those of `FUNCTIONS` are functions of Python's C interface;
            ``new_array`` is one of NumPy's.
        arrays: members that are addresses of numbers.
        numbers: members that are numbers.
        objects: members that are objects.
        kept: what else is kept alive.
    """
    api = ctypes.pythonapi
    values = {
        **{name: ctypes.cast(getattr(api, each), ctypes.c_void_p).value for name, each in FUNCTIONS.items()},
        "new_array": _new_array(),
        **{name: array.ctypes.data for name, array in arrays.items()},
        **numbers,
        **{name: id(each) for name, each in objects.items()},
    }
    memory = np.array([values[name] for name in members], dtype=np.uintp).view(Memory)
    memory.kept = {**arrays, **objects, **kept}
    return memory


def functions(loaded: ctypes.CDLL, name: str, count: int, memory: Memory) -> list[Callable[..., Any]]:
    """The functions whose PyMethodDefs are this array of a library; each has the memory as its self."""
    return [_NEW(ctypes.addressof(each), memory, None) for each in (Method * count).in_dll(loaded, name)]


@cache
def _new_array() -> int:
    """Address of the function of NumPy's C interface that makes arrays, where every extension module finds it."""
    module = import_module(
        "numpy._core._multiarray_umath" if find_spec("numpy._core") else "numpy.core._multiarray_umath"
    )
    functions = ctypes.cast(_CONTENT(module._ARRAY_API, None), ctypes.POINTER(ctypes.c_size_t))
    address: int = functions[NEW_ARRAY]
    return address


_CONTENT = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.py_object, ctypes.c_char_p)(
    ("PyCapsule_GetPointer", ctypes.pythonapi)
)
"""(capsule, its name) -> its address."""

_NEW = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.py_object, ctypes.c_void_p)(
    ("PyCFunction_NewEx", ctypes.pythonapi)
)
"""(method, self, module) -> function."""

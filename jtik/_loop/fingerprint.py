"""Fingerprint of a study or a batch: a hash of everything that its numbers depend on.

What was saved is resumed only if the fingerprints agree. The hash is that of the values. The bytes of a pickle would
not do, because they can differ for equal values.
"""

from __future__ import annotations

import copyreg
import hashlib
from collections.abc import Mapping, Set
from enum import Enum
from functools import partial
from types import BuiltinFunctionType, CodeType, FunctionType, MethodType
from typing import Any

import numpy as np

from jtik.robot.mesh import Meshes


def fingerprint(*values: Any) -> str:
    """Hash of the values, 64 hexadecimal digits."""
    digest = hashlib.sha256()
    _Reader(digest.update).read(values)
    return digest.hexdigest()


class _Reader:
    """Traverses values and passes their parts to a hash, in order, as bytes."""

    def __init__(self, update: Any) -> None:
        self._update = update
        self._open: set[int] = set()

    def read(self, value: Any) -> None:
        """A value and everything in it."""
        if id(value) in self._open:
            self._add("itself")
            return
        self._open.add(id(value))
        try:
            self._read(value)
        finally:
            self._open.discard(id(value))

    def _add(self, *words: object) -> None:
        for word in words:
            text = word if isinstance(word, bytes) else str(word).encode()
            self._update(f"{len(text)}:".encode() + text)

    def _read(self, value: Any) -> None:
        if isinstance(value, Enum):
            self._add(type(value).__qualname__, value.name)
        elif value is None or isinstance(value, (bool, int, float, complex, str, bytes)):
            self._add(type(value).__name__, value if isinstance(value, bytes) else repr(value))
        elif isinstance(value, (np.ndarray, np.generic)):
            array = np.asarray(value)
            self._add("array", array.dtype.str, array.shape, np.ascontiguousarray(array).tobytes())
        elif isinstance(value, type):
            self._add("class", value.__module__, value.__qualname__)
        elif isinstance(value, Meshes):
            self._add("meshes")
        elif isinstance(value, Mapping):
            self._add("mapping", len(value))
            for key in sorted(value, key=repr):
                self.read(key)
                self.read(value[key])
        elif isinstance(value, (list, tuple)):
            self._add("sequence", len(value))
            for item in value:
                self.read(item)
        elif isinstance(value, Set):
            self.read(sorted(value, key=repr))
        elif isinstance(value, (FunctionType, MethodType)):
            self._function(value)
        elif isinstance(value, partial):
            self.read(("partial", value.func, value.args, value.keywords))
        elif isinstance(value, BuiltinFunctionType):
            self._add("builtin", value.__module__, value.__qualname__)
        else:
            self._object(value)

    def _function(self, function: Any) -> None:
        """A function by its code, defaults and closure."""
        self._add("function", function.__name__)
        self._code(function.__code__)
        cells = [cell.cell_contents for cell in function.__closure__ or ()]
        self.read([function.__defaults__, function.__kwdefaults__, cells])
        if isinstance(function, MethodType):
            self.read(function.__self__)

    def _code(self, code: CodeType) -> None:
        self._add("code", code.co_code, code.co_names)
        for constant in code.co_consts:
            if isinstance(constant, CodeType):
                self._code(constant)
            else:
                self.read(constant)

    def _object(self, value: Any) -> None:
        """An object by the parts from which pickle rebuilds it; by its repr if it has none."""
        self._add("object", type(value).__module__, type(value).__qualname__)
        try:
            parts = value.__reduce_ex__(4)
        except Exception:  # third-party objects may raise anything here; the repr is used instead
            self._add(repr(value))
            return
        if isinstance(parts, str):
            self._add(parts)
            return
        constructor, arguments, *rest = parts
        if constructor not in (copyreg.__newobj__, copyreg.__newobj_ex__):  # type: ignore[attr-defined]
            self.read(constructor)
        self.read(arguments)
        state, items, pairs = (*rest, None, None, None)[:3]
        self.read(_without_caches(type(value), state))
        self.read([list(items or ()), list(pairs or ())])


def _without_caches(kind: type[Any], state: Any) -> Any:
    """The state without the values of cached properties."""
    from functools import cached_property

    if not isinstance(state, dict):
        return state
    cached = {name for base in kind.__mro__ for name, each in vars(base).items() if isinstance(each, cached_property)}
    return {name: each for name, each in state.items() if name not in cached}

"""The fingerprint of a study: the same for the same robot, tasks, criteria, contenders, problems and options.

What was saved of a study is gone on with only under the same fingerprint. It is taken of values, not of a pickle's
bytes, which tell apart what is equal.
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


def fingerprint(*values: Any) -> str:
    """64 hexadecimal digits."""
    digest = hashlib.sha256()
    _Reader(digest.update).read(values)
    return digest.hexdigest()


class _Reader:
    """Walks through values and tells their parts, in order, as bytes."""

    def __init__(self, tell: Any) -> None:
        self._tell = tell
        self._open: set[int] = set()

    def read(self, value: Any) -> None:
        """One value and all that it holds."""
        if id(value) in self._open:
            self._say("itself")
            return
        self._open.add(id(value))
        try:
            self._read(value)
        finally:
            self._open.discard(id(value))

    def _say(self, *words: object) -> None:
        for word in words:
            text = word if isinstance(word, bytes) else str(word).encode()
            self._tell(f"{len(text)}:".encode() + text)

    def _read(self, value: Any) -> None:
        if isinstance(value, Enum):
            self._say(type(value).__qualname__, value.name)
        elif value is None or isinstance(value, (bool, int, float, complex, str, bytes)):
            self._say(type(value).__name__, value if isinstance(value, bytes) else repr(value))
        elif isinstance(value, (np.ndarray, np.generic)):
            array = np.asarray(value)
            self._say("array", array.dtype.str, array.shape, np.ascontiguousarray(array).tobytes())
        elif isinstance(value, type):
            self._say("class", value.__module__, value.__qualname__)
        elif isinstance(value, Mapping):
            self._say("mapping", len(value))
            for key in sorted(value, key=repr):
                self.read(key)
                self.read(value[key])
        elif isinstance(value, (list, tuple)):
            self._say("sequence", len(value))
            for item in value:
                self.read(item)
        elif isinstance(value, Set):
            self.read(sorted(value, key=repr))
        elif isinstance(value, (FunctionType, MethodType)):
            self._function(value)
        elif isinstance(value, partial):
            self.read(("partial", value.func, value.args, value.keywords))
        elif isinstance(value, BuiltinFunctionType):
            self._say("builtin", value.__module__, value.__qualname__)
        else:
            self._object(value)

    def _function(self, function: Any) -> None:
        """What a function does, as far as its own code tells."""
        self._say("function", function.__name__)
        self._code(function.__code__)
        cells = [cell.cell_contents for cell in function.__closure__ or ()]
        self.read([function.__defaults__, function.__kwdefaults__, cells])
        if isinstance(function, MethodType):
            self.read(function.__self__)

    def _code(self, code: CodeType) -> None:
        self._say("code", code.co_code, code.co_names)
        for constant in code.co_consts:
            if isinstance(constant, CodeType):
                self._code(constant)
            else:
                self.read(constant)

    def _object(self, value: Any) -> None:
        """By what it would be rebuilt from; by its looks where it cannot be."""
        self._say("object", type(value).__module__, type(value).__qualname__)
        try:
            parts = value.__reduce_ex__(4)
        except Exception:  # whatever an object of somebody else's raises: its text has to do
            self._say(repr(value))
            return
        if isinstance(parts, str):
            self._say(parts)
            return
        made, arguments, *rest = parts
        if made not in (copyreg.__newobj__, copyreg.__newobj_ex__):  # type: ignore[attr-defined]
            self.read(made)
        self.read(arguments)
        state, items, pairs = (*rest, None, None, None)[:3]
        self.read(_without_caches(type(value), state))
        self.read([list(items or ()), list(pairs or ())])


def _without_caches(kind: type[Any], state: Any) -> Any:
    """The state without what cached properties have left in it."""
    from functools import cached_property

    if not isinstance(state, dict):
        return state
    cached = {name for base in kind.__mro__ for name, each in vars(base).items() if isinstance(each, cached_property)}
    return {name: each for name, each in state.items() if name not in cached}

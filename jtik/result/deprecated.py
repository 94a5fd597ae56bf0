"""Old names of attributes, which warn and name the new one."""

from __future__ import annotations

import warnings
from typing import Any


class RenamedAttribute:
    """An attribute under its old name: reads the new one with a DeprecationWarning.

    Args:
        new: the new name.
    """

    def __init__(self, new: str) -> None:
        self._new = new

    def __set_name__(self, owner: type, name: str) -> None:
        self._old = f"{owner.__name__}.{name}"
        self.__doc__ = f"Deprecated: use `{self._new}`."

    def __get__(self, instance: Any, owner: type) -> Any:
        if instance is None:
            return self
        warnings.warn(f"{self._old} is deprecated: use {self._new}", DeprecationWarning, stacklevel=2)
        return getattr(instance, self._new)

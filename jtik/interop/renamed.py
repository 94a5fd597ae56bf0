"""Deprecated names of the classes of this package."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from typing import Any


def renamed_classes(module: str, classes: Mapping[str, type]) -> Callable[[str], Any]:
    """The ``__getattr__`` of a module that gives a class under its old name, with a DeprecationWarning.

    Args:
        module: name of the module.
        classes: the classes by their old names.
    """

    def get(name: str) -> Any:
        if name not in classes:
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        new = classes[name]
        warnings.warn(f"{module}.{name} is deprecated: use {new.__name__}", DeprecationWarning, stacklevel=2)
        return new

    return get

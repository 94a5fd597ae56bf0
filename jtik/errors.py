"""Errors that keep their data, and the checks at the door that raise them.

Every error derives from `JtikError`, so ``except JtikError`` catches all of them and nothing else. Each keeps
what went wrong as attributes and says in its message what would have been accepted.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable

import numpy as np

from jtik.types import Array


class JtikError(Exception):
    """The base of every error that jtik raises on purpose."""


class ArgumentError(JtikError, ValueError):
    """An argument has a value that cannot be used.

    Attributes:
        argument: name of the argument, as the caller wrote it.
        given: what was given, or a sentence about it.
        accepted: what would have been accepted.
    """

    def __init__(self, argument: str, given: object, accepted: str) -> None:
        super().__init__(argument, given, accepted)
        self.argument = argument
        self.given = given
        self.accepted = accepted

    def __str__(self) -> str:
        shown = self.given if isinstance(self.given, str) else repr(self.given)
        return f"{self.argument}: given {shown}; accepted: {self.accepted}"


class UnknownNameError(JtikError, KeyError):
    """A frame, joint, strategy ... of that name does not exist.

    Attributes:
        kind: what was looked up, for instance ``"frame"``.
        name: the name that was not found.
        known: the names that exist.
        closest: the known name most like the given one, whatever the case of its letters, or None.
    """

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        self.kind = kind
        self.name = name
        self.known = tuple(known)
        lowered = {str(one).lower(): one for one in reversed(self.known)}
        matches = difflib.get_close_matches(str(name).lower(), lowered, n=1)
        self.closest: str | None = lowered[matches[0]] if matches else None
        super().__init__(kind, name, self.known)

    def __str__(self) -> str:
        hint = f"; did you mean {self.closest!r}?" if self.closest is not None else ""
        listed = ", ".join(self.known) if self.known else "none"
        return f"unknown {self.kind} {self.name!r}{hint} (known: {listed})"


class MissingExtraError(JtikError, ImportError):
    """A feature needs an optional package that is not installed.

    Attributes:
        package: the package that is missing.
        extra: the extra of jtik that installs it.
        feature: what was asked for.
    """

    def __init__(self, package: str, extra: str, feature: str) -> None:
        self.package = package
        self.extra = extra
        self.feature = feature
        super().__init__(package, extra, feature)

    def __str__(self) -> str:
        return f"{self.feature} needs {self.package}; install it with: pip install 'jtik[{self.extra}]'"


class RobotFileError(JtikError, ValueError):
    """A description of a robot that cannot be read.

    Attributes:
        file: the path, or what stands for it where the description was text or a model.
        element: which part of it is wrong, for instance ``"joint 'elbow'"``; empty when it is the whole.
        problem: what is wrong with it, and what would have been accepted.
    """

    def __init__(self, file: str, element: str, problem: str) -> None:
        super().__init__(file, element, problem)
        self.file = file
        self.element = element
        self.problem = problem

    def __str__(self) -> str:
        return ": ".join(part for part in (self.file, self.element, self.problem) if part)


class ImmutableError(JtikError, AttributeError):
    """An attempt to change an object that cannot change.

    Attributes:
        owner: the object, as text.
        attribute: the attribute that was to be set or deleted.
        instead: what to do instead.
    """

    def __init__(self, owner: str, attribute: str, instead: str = "build a new one") -> None:
        self.owner = owner
        self.attribute = attribute
        self.instead = instead
        super().__init__(owner, attribute, instead)

    def __str__(self) -> str:
        return f"{self.owner} is immutable: {self.attribute!r} cannot be changed; {self.instead} instead"


def finite_array(argument: str, value: object, shape: tuple[int | None, ...]) -> Array:
    """A float64 copy of ``value``, checked at the door.

    Args:
        argument: the name to use in the error.
        value: numbers: a scalar, a nested sequence or an array.
        shape: the shape wanted; None stands for any length of that axis.

    Raises:
        ArgumentError: when ``value`` is not numeric, has another shape, or holds NaN or infinity.
    """
    wanted = _shape_text(shape)
    try:
        raw = np.asarray(value)
    except ValueError as error:
        raise ArgumentError(argument, f"a ragged {type(value).__name__}", wanted) from error
    if raw.dtype.kind not in "fiub":
        raise ArgumentError(argument, f"non-numeric {type(value).__name__}", wanted)
    fits = raw.ndim == len(shape) and all(w is None or w == g for w, g in zip(shape, raw.shape, strict=True))
    if not fits:
        raise ArgumentError(argument, f"shape {raw.shape}", wanted)
    array = np.array(raw, dtype=np.float64)
    if not np.isfinite(array).all():
        where = [tuple(int(i) for i in index) for index in np.argwhere(~np.isfinite(array))]
        first = where[0] if len(where[0]) != 1 else where[0][0]
        place = f" at index {first}" if array.ndim else ""
        raise ArgumentError(argument, f"{array[where[0]]}{place}", wanted)
    return array


def _shape_text(shape: tuple[int | None, ...]) -> str:
    if not shape:
        return "one finite number"
    sizes = ", ".join("any" if size is None else str(size) for size in shape)
    return f"finite numbers of shape ({sizes}{',' if len(shape) == 1 else ''})"

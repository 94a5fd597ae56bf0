"""Errors of jtik, and the check of arguments that are arrays.

Every error derives from `JtikError`, so ``except JtikError`` catches all of them and nothing else. Each keeps its data
as attributes. Its message contains what would have been accepted.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from jtik.types import Array


class JtikError(Exception):
    """Base class of the errors that jtik raises."""


class ArgumentError(JtikError, ValueError):
    """An argument has a value that cannot be used.

    Attributes:
        argument: name of the argument, as the caller wrote it.
        given: what was given, or a text that describes it.
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
    """A name that does not exist: of a frame, a joint, a strategy ...

    Attributes:
        kind: what was looked up, for instance ``"frame"``.
        name: the name that was not found.
        known: the names that exist.
        closest: the known name most similar to the given one, without regard to case; None if none is similar.
        nearest: up to three known names that are similar, the most similar first.
        hint: what else helps, such as the name of the tip; the message then has all of ``nearest``. Empty without one.
    """

    def __init__(self, kind: str, name: str, known: Iterable[str], hint: str = "") -> None:
        self.kind = kind
        self.name = name
        self.known = tuple(known)
        lowered = {str(one).lower(): one for one in reversed(self.known)}
        matches = difflib.get_close_matches(str(name).lower(), lowered, n=3)
        self.nearest = tuple(lowered[match] for match in matches)
        self.closest: str | None = self.nearest[0] if self.nearest else None
        self.hint = hint
        super().__init__(kind, name, self.known, hint)

    def __str__(self) -> str:
        nearest = " or ".join(map(repr, self.nearest if self.hint else self.nearest[:1]))
        hint = f"; did you mean {nearest}?" if nearest else ""
        listed = ", ".join(self.known) if self.known else "none"
        more = f"; {self.hint}" if self.hint else ""
        return f"unknown {self.kind} {self.name!r}{hint}{more} (known: {listed})"


class MissingExtraError(JtikError, ImportError):
    """A feature needs an optional package that is not installed.

    Attributes:
        package: the package that is missing.
        extra: the extra of jtik that installs it.
        feature: the feature that needs the package.
    """

    def __init__(self, package: str, extra: str, feature: str) -> None:
        self.package = package
        self.extra = extra
        self.feature = feature
        super().__init__(package, extra, feature)

    def __str__(self) -> str:
        return f"{self.feature} needs {self.package}; install it with: pip install 'jtik[{self.extra}]'"


class RobotFileError(JtikError, ValueError):
    """A robot description that cannot be read.

    Attributes:
        file: the path; for a description that is a text or a model, what kind it is.
        element: the part that is wrong, for instance ``"joint 'elbow'"``; empty for the description as such.
        problem: what is wrong, and what would have been accepted.
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
        attribute: the attribute that the caller tried to set or delete.
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
    """A float64 copy of an argument, with a check of its shape and that all numbers are finite.

    Args:
        argument: name of the argument, for the error.
        value: a scalar, a nested sequence or an array of numbers.
        shape: the wanted shape; None for an axis of any length.

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


def several(argument: str, given: Any, accepted: str) -> tuple[Any, ...]:
    """What an iterable holds. Raises ArgumentError for what is no iterable."""
    try:
        return tuple(given)
    except TypeError:
        raise ArgumentError(argument, given, accepted) from None


def positive_number(argument: str, value: float) -> float:
    """The value as a float.

    Raises:
        ArgumentError: unless it is finite and positive.
    """
    if type(value) is float and 0.0 < value < math.inf:
        return value
    accepted = "a positive number"
    try:
        number = float(finite_array(argument, value, ()))
    except ArgumentError as error:
        raise ArgumentError(argument, error.given, accepted) from None
    if isinstance(value, bool) or not number > 0:
        raise ArgumentError(argument, value, accepted)
    return number


def _shape_text(shape: tuple[int | None, ...]) -> str:
    """What is accepted, as a text."""
    if not shape:
        return "one finite number"
    sizes = ", ".join("any" if size is None else str(size) for size in shape)
    return f"finite numbers of shape ({sizes}{',' if len(shape) == 1 else ''})"

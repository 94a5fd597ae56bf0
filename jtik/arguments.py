"""Readers of arguments, one for each kind of argument: what every public function reads its arguments by.

A reader takes the name of the argument and the value, and returns the value in the form that the library uses. For any
other value it raises `ArgumentError`, which names the argument, what was given and what would be accepted. True and
False are no numbers; numbers are no flags; text, complex numbers and masked entries are neither. A strategy declares
the reader of an option by its annotation, see `jtik.strategy.options`.
"""

from __future__ import annotations

import math
import os
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence, Set
from numbers import Real
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from jtik.errors import ArgumentError
from jtik.types import Array

T = TypeVar("T")

Shape = tuple[int | None, ...]
"""The shape of an array; None for an axis of any length."""

LARGEST_INTEGER = 2**63 - 1
"""Largest integer that is accepted: the largest one of NumPy and of C."""


def number(argument: str, value: object, accepted: str = "one finite number", *, minimum: float = -math.inf) -> float:
    """A finite number, not below ``minimum``, as a float."""
    return _number(argument, value, accepted, lambda x: minimum <= x < math.inf and x > -math.inf)


def positive_number(argument: str, value: object, accepted: str = "a positive number") -> float:
    """A positive, finite number as a float."""
    if type(value) is float and 0.0 < value < math.inf:
        return value
    return _number(argument, value, accepted, lambda x: 0 < x < math.inf)


def non_negative_number(argument: str, value: object, accepted: str = "a non-negative number") -> float:
    """A non-negative, finite number as a float."""
    return _number(argument, value, accepted, lambda x: 0 <= x < math.inf)


def positive_or_infinite(
    argument: str, value: object, accepted: str = "a positive number, or math.inf for none"
) -> float:
    """A positive number or infinity as a float."""
    return _number(argument, value, accepted, lambda x: x > 0)


def share(argument: str, value: object, accepted: str = "a number in (0, 1]") -> float:
    """A number above 0, up to 1, as a float."""
    return _number(argument, value, accepted, lambda x: 0 < x <= 1)


def limit(argument: str, value: object, accepted: str = "a number, infinity for none") -> float:
    """A number or an infinity, but no NaN, as a float."""
    return _number(argument, value, accepted, lambda x: not math.isnan(x))


def limits(argument: str, lower: object, upper: object) -> tuple[float, float]:
    """A lower and an upper limit as floats, in ascending order; an infinity on its own side for none."""
    accepted = "lower <= upper, no NaN"
    low, high = limit(argument, lower, accepted), limit(argument, upper, accepted)
    if not low <= high or low == math.inf or high == -math.inf:
        raise ArgumentError(argument, f"lower {low:g}, upper {high:g}", accepted)
    return low, high


def integer(argument: str, value: object, minimum: int = 0, accepted: str | None = None) -> int:
    """An integer not below ``minimum``, 0 or 1; 1.0 and True are none."""
    if type(value) is int and minimum <= value <= LARGEST_INTEGER:
        return value
    if isinstance(value, (int, np.integer)) and not isinstance(value, bool) and minimum <= value <= LARGEST_INTEGER:
        return int(value)
    accepted = accepted or ("a positive integer" if minimum else "a non-negative integer")
    if isinstance(value, int) and value > LARGEST_INTEGER:
        accepted += f", at most {LARGEST_INTEGER}"
    raise ArgumentError(argument, value, accepted)


def positive_integer(argument: str, value: object) -> int:
    """An integer not below 1."""
    return integer(argument, value, minimum=1)


def flag(argument: str, value: object, meaning: str = "") -> bool:
    """True or False; no other value counts as one of them.

    Args:
        argument: name of the argument.
        value: the value.
        meaning: what the flag says, for the message.
    """
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    raise ArgumentError(argument, value, f"True or False{f': {meaning}' if meaning else ''}")


def text(argument: str, value: object, accepted: str = "a text") -> str:
    """A text, perhaps empty."""
    if isinstance(value, str):
        return str(value)
    raise ArgumentError(argument, repr(value), accepted)


def name(argument: str, value: object, accepted: str = "a name: a text of at least one character") -> str:
    """A text of at least one character."""
    if isinstance(value, str) and value:
        return str(value)
    raise ArgumentError(argument, repr(value), accepted)


def choice(argument: str, value: object, choices: Sequence[str]) -> str:
    """One of a few words."""
    if isinstance(value, str) and value in choices:
        return value
    *first, last = [repr(each) for each in choices]
    raise ArgumentError(argument, value, f"{', '.join(first)} or {last}" if first else last)


def names(argument: str, value: object, accepted: str = "a name, or several") -> tuple[str, ...]:
    """One name, or several in a list or another collection; none of them twice."""
    given = (value,) if isinstance(value, str) else several(argument, value, accepted, ordered=False)
    for each in given:
        if not isinstance(each, str):
            raise ArgumentError(argument, list(given), accepted)
    repeated = [each for each, count in Counter(given).items() if count > 1]
    if repeated:
        raise ArgumentError(argument, f"{repeated[0]!r} more than once", f"{accepted}; each name once")
    return given


def several(argument: str, value: object, accepted: str, *, ordered: bool = True) -> tuple[Any, ...]:
    """What a list or another iterable holds.

    A text, a mapping or a class is none; where the order counts, neither is a set.

    Args:
        argument: name of the argument.
        value: the value.
        accepted: what is accepted, for the message.
        ordered: whether the order counts.
    """
    if isinstance(value, (str, bytes, bytearray, Mapping, type)) or (ordered and isinstance(value, Set)):
        raise ArgumentError(argument, value, accepted)
    try:
        items = iter(value)  # type: ignore[call-overload]
    except TypeError:
        raise ArgumentError(argument, value, accepted) from None
    return tuple(items)


def mapping(argument: str, value: object, accepted: str) -> dict[Any, Any]:
    """A copy of a dict."""
    if isinstance(value, Mapping):
        return dict(value)
    raise ArgumentError(argument, value, accepted)


def instance(argument: str, value: object, kind: type[T] | tuple[type[T], ...], accepted: str) -> T:
    """An object of a class, or of one of several classes."""
    if isinstance(value, kind):
        return value
    raise ArgumentError(argument, value, accepted)


def instances(argument: str, value: object, kind: type[T], accepted: str) -> tuple[T, ...]:
    """One object of a class, or several in an iterable."""
    given = (value,) if isinstance(value, kind) else several(argument, value, accepted)
    return tuple(instance(argument, each, kind, accepted) for each in given)


def path(argument: str, value: object, accepted: str = "the path of a file: a text or a pathlib.Path") -> Path:
    """The path of a file."""
    if isinstance(value, (str, os.PathLike)):
        found = os.fspath(value)
        if isinstance(found, str) and found and "\0" not in found:
            return Path(found)
    raise ArgumentError(argument, repr(value), accepted)


def existing_file(argument: str, value: object) -> Path:
    """The path of a file that exists."""
    found = path(argument, value)
    if not found.is_file():
        raise ArgumentError(argument, str(found), "the path of a file that exists")
    return found


def random_generator(argument: str, value: object) -> np.random.Generator:
    """A random generator itself, or that of a seed."""
    if isinstance(value, np.random.Generator):
        return value
    return np.random.default_rng(integer(argument, value, accepted="a numpy.random.Generator, or a seed from 0"))


def finite_array(argument: str, value: object, shape: Shape, accepted: str | None = None) -> Array:
    """A float64 copy of an array of finite numbers.

    Args:
        argument: name of the argument.
        value: a scalar, a nested sequence or an array of numbers.
        shape: the wanted shape; None for an axis of any length.
        accepted: what is accepted, for the message; by default the shape.
    """
    wanted = accepted or _shape_text(shape)
    raw = _numeric(argument, value, wanted)
    if not _fits(raw.shape, shape):
        raise ArgumentError(argument, f"shape {raw.shape}", wanted)
    array = np.array(raw, dtype=np.float64)
    _check_entries(argument, array, np.isfinite(array), wanted)
    return array


def array_of(
    argument: str, value: object, shapes: Sequence[Shape], accepted: str, valid: Callable[[Array], Any] = np.isfinite
) -> Array:
    """A float64 copy of an array of one of several shapes, with at least one number.

    Args:
        argument: name of the argument.
        value: a scalar, a nested sequence or an array of numbers.
        shapes: the shapes; None for an axis of any length.
        accepted: what is accepted, for the message.
        valid: which numbers are accepted; by default the finite ones.
    """
    if isinstance(value, (str, bytes)) or value is None:
        raise ArgumentError(argument, value, accepted)
    raw = _numeric(argument, value, accepted)
    if not any(_fits(raw.shape, shape) for shape in shapes):
        raise ArgumentError(argument, value if raw.ndim == 0 else f"shape {raw.shape}", accepted)
    array = np.array(raw, dtype=np.float64)
    if not array.size:
        raise ArgumentError(argument, value, accepted)
    _check_entries(argument, array, valid(array), accepted)
    return array


def numeric_array(value: object) -> Array | None:
    """A float64 copy of an array of any shape; None for what is no array of real numbers."""
    raw = _numeric_or_none(value)
    return None if raw is None else np.array(raw, dtype=np.float64)


def shape_of(value: Any) -> tuple[int, ...] | None:
    """The shape of what may be an array; None for what has none, such as a ragged list."""
    try:
        shape: tuple[int, ...] = np.shape(value)
    except Exception:  # what the conversion of an object of another library raises
        return None
    return shape


def _number(argument: str, value: object, accepted: str, valid: Callable[[float], bool]) -> float:
    found = _float(value)
    if found is None or not valid(found):
        raise ArgumentError(argument, value, accepted)
    return found


def _float(value: object) -> float | None:
    """A real number as a float; None for anything else, such as a flag."""
    if isinstance(value, (bool, np.bool_)):
        return None
    if isinstance(value, Real):
        try:
            return float(value)
        except OverflowError:
            return None
    raw = _numeric_or_none(value) if hasattr(value, "__array__") else None
    return float(raw) if raw is not None and raw.ndim == 0 else None


def _numeric(argument: str, value: object, accepted: str) -> NDArray[Any]:
    """An array of real numbers of any shape, perhaps the value itself."""
    raw = _numeric_or_none(value)
    if raw is None:
        given = f"a ragged {type(value).__name__}" if _is_ragged(value) else f"non-numeric {type(value).__name__}"
        raise ArgumentError(argument, given, accepted)
    return raw


def _numeric_or_none(value: object) -> NDArray[Any] | None:
    # without the module, or while a thread imports it, no array is a masked one
    masked = getattr(sys.modules.get("numpy.ma"), "MaskedArray", None)
    if masked is not None and isinstance(value, masked):
        return None if np.ma.is_masked(value) else _numeric_or_none(np.asarray(value.data))
    try:
        raw = np.asarray(value)
    except Exception:  # ragged, an expression, or what an object of another library raises
        return None
    if raw.dtype.kind not in "fiu":
        return None
    return None if _has_flags(value) else raw


def _has_flags(value: object) -> bool:
    """Whether a nested list holds True or False, which would count as 1 or 0 among numbers."""
    if isinstance(value, (list, tuple)):
        return any(_has_flags(each) for each in value)
    return isinstance(value, (bool, np.bool_)) or (isinstance(value, np.ndarray) and value.dtype.kind == "b")


def _is_ragged(value: object) -> bool:
    """Whether a nested list has rows of different lengths."""
    if not isinstance(value, (list, tuple)):
        return False
    return len({shape_of(each) for each in value}) > 1 or any(_is_ragged(each) for each in value)


def _check_entries(argument: str, array: Array, valid: Any, accepted: str) -> None:
    """Raise ArgumentError, with the first entry that is not valid and its place, unless all are."""
    if np.all(valid):
        return
    first = tuple(int(i) for i in np.argwhere(~np.asarray(valid))[0])
    place = f" at index {first[0] if len(first) == 1 else first}" if first else ""
    raise ArgumentError(argument, f"{array[first]}{place}", accepted)


def _fits(given: tuple[int, ...], shape: Shape) -> bool:
    return len(given) == len(shape) and all(w is None or w == g for w, g in zip(shape, given, strict=True))


def _shape_text(shape: Shape) -> str:
    """What is accepted, as a text."""
    if not shape:
        return "one finite number"
    sizes = ", ".join("any" if size is None else str(size) for size in shape)
    return f"finite numbers of shape ({sizes}{',' if len(shape) == 1 else ''})"

"""Options of strategies: an option declares by its annotation how it is read, so that none is left unread.

A strategy, or a secondary term, is a frozen dataclass. Its ``__post_init__`` reads every field by the annotation:

- `Positive`, `NonNegative`, `Share`, `PositiveInteger`, `AngleLimit`, `StepLimit`, `LengthLimit`, or
  ``Annotated[T, reader]``: by that reader, a function of the name and the value, such as those of `jtik.arguments`.
- ``float``: a finite number; ``int``: a non-negative integer; ``bool``: True or False; ``str``: a text.
- ``Literal[...]``: one of these words. ``... | None``: None as well.
- a secondary term: an object of that class, or the name of a registered one.

A field with another annotation is left as it is. A subclass with a ``__post_init__`` of its own calls the inherited one
first.
"""

from __future__ import annotations

import importlib
import sys
import types
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import cache, partial
from typing import Annotated, Any, Literal, TypeAlias, Union, get_args, get_origin

from jtik import arguments

Reader: TypeAlias = Callable[[str, Any], Any]
"""(name, value) -> the value as it is kept; raises ArgumentError for another one."""

Positive: TypeAlias = Annotated[float, arguments.positive_number]
"""A positive, finite number."""

NonNegative: TypeAlias = Annotated[float, arguments.non_negative_number]
"""A non-negative, finite number."""

Share: TypeAlias = Annotated[float, arguments.share]
"""A number above 0, up to 1."""

PositiveInteger: TypeAlias = Annotated[int, arguments.positive_integer]
"""An integer from 1."""

StepLimit: TypeAlias = Annotated[
    float, partial(arguments.positive_or_infinite, accepted="a positive angle [rad], math.inf for none")
]
"""A positive angle [rad], or infinity for no limit."""

AngleLimit: TypeAlias = Annotated[float, partial(arguments.positive_number, accepted="a positive, finite angle [rad]")]
"""A positive, finite angle [rad]."""

LengthLimit: TypeAlias = Annotated[
    float, partial(arguments.positive_or_infinite, accepted="a positive length [m], math.inf for none")
]
"""A positive length [m], or infinity for no limit."""

_READERS: dict[Any, Reader] = {
    float: arguments.number,
    int: arguments.integer,
    bool: arguments.flag,
    str: arguments.text,
}


class Part:
    """Base of a part of a strategy that an option may name: a registered name then stands for an object of it."""


def read_options(options: Any) -> None:
    """Read every field of a frozen dataclass by its annotation, in place.

    Args:
        options: the dataclass.

    Raises:
        ArgumentError: for a value that the annotation does not allow, naming the option.
        UnknownNameError: for a name that is not registered.
    """
    cls: type = type(options)
    for name, reader in _readers(cls).items():
        given = getattr(options, name)
        read = reader(name, given)
        if read is not given:
            object.__setattr__(options, name, read)


@cache
def _readers(cls: type) -> Mapping[str, Reader]:
    """The reader of each field that has one."""
    found = {}
    for field in fields(cls):
        reader = _reader(_annotation(cls, field.name, field.type)) if field.init else None
        if reader is not None:
            found[field.name] = reader
    return found


def _annotation(cls: type, name: str, annotation: Any) -> Any:
    """The annotation of a field as an object; None where its text names what is not defined at run time."""
    if not isinstance(annotation, str):
        return annotation
    owner = next(base for base in cls.__mro__ if name in vars(base).get("__annotations__", {}))
    try:
        return eval(annotation, vars(sys.modules[owner.__module__]), dict(vars(owner)))
    except Exception:  # a name that only a type checker knows
        return None


def _reader(annotation: Any) -> Reader | None:
    """The reader for an annotation; None where the annotation says nothing about it."""
    origin, inner = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return next((each for each in annotation.__metadata__ if callable(each)), _reader(inner[0]))
    if origin is Literal:
        return partial(_choice, inner)
    if origin in (Union, types.UnionType) and type(None) in inner and len(inner) == 2:
        reader = _reader(next(each for each in inner if each is not type(None)))
        return None if reader is None else partial(_optional, reader)
    if isinstance(annotation, type) and issubclass(annotation, Part):
        return partial(_part, annotation)
    return _READERS.get(annotation) if isinstance(annotation, type) else None


def _choice(words: tuple[str, ...], name: str, value: Any) -> str:
    return arguments.choice(name, value, words)


def _optional(reader: Reader, name: str, value: Any) -> Any:
    return None if value is None else reader(name, value)


def _part(kind: type[Part], name: str, value: Any) -> Part:
    """A part, or the registered one of that name with its defaults."""
    if isinstance(value, str):
        # by name at run time, since the registry imports this module
        value = importlib.import_module("jtik.registry").secondary_of(name, value)
    return arguments.instance(name, value, kind, f"a {kind.__name__}, or the name of a registered one")

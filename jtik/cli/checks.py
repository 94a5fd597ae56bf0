"""Checks of the values of documents and options; each error names the place."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from jtik.errors import ArgumentError, JtikError, UnknownNameError

Table = Mapping[str, Any]
"""A table of a TOML document, or an object of a JSON document."""

T = TypeVar("T")


class InputError(JtikError):
    """Input of the command line that cannot be used. The message contains what is accepted."""


def checked_table(where: str, given: Any, accepted: Iterable[str] | None = None) -> Table:
    """``given`` itself, a table. Raises InputError when it is none, UnknownNameError for a key that is not accepted."""
    if not isinstance(given, Mapping):
        listed = "" if accepted is None else f" with keys {', '.join(accepted)}"
        raise InputError(f"{where}: accepted: a table{listed}")
    if accepted is not None:
        known = tuple(accepted)
        for key in given:
            if key not in known:
                raise UnknownNameError(f"key of {where}", key, known)
    return given


def checked_name(where: str, given: Any, known: Iterable[str]) -> str:
    """``given`` itself, a name. Raises ArgumentError when it is no text."""
    if not isinstance(given, str):
        raise ArgumentError(where, "nothing" if given is None else given, f"one of {', '.join(known)}")
    return given


def call(where: str, make: Callable[..., T], options: Any) -> T:
    """Call ``make`` with options from a document. Errors in the options name ``where`` they are."""
    parameters = inspect.signature(make).parameters
    checked_table(where, options, parameters)
    for name, parameter in parameters.items():
        if parameter.default is parameter.empty and name not in options:
            raise InputError(f"{where}: {name} is missing; accepted: {', '.join(parameters)}")
    try:
        return make(**options)
    except JtikError:
        raise
    except (TypeError, ValueError) as error:  # such as a text in place of a number
        raise InputError(f"{where}: {error}") from error

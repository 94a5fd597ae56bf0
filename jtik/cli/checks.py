"""Checks of the values of documents and options; each error names the place."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from jtik.errors import ArgumentError, JtikError, UnknownNameError

Table = Mapping[str, Any]
"""A table of a TOML document, or an object of a JSON document."""

T = TypeVar("T")

MAX_BYTES = 10_000_000
"""Size of the largest file that is read as a document or as numbers."""


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


def call(where: str, make: Callable[..., T], options: Any, hint: str = "") -> T:
    """Call ``make`` with options from a document. Errors in the options name ``where`` they are.

    ``hint`` says where the options are given, for one that is missing.
    """
    parameters = inspect.signature(make).parameters
    checked_table(where, options, parameters)
    for name, parameter in parameters.items():
        if parameter.default is parameter.empty and name not in options:
            raise InputError(f"{where}: {name} is missing; accepted: {', '.join(parameters)}{hint}")
    try:
        return make(**options)
    except JtikError:
        raise
    except (TypeError, ValueError) as error:  # such as a text in place of a number
        raise InputError(f"{where}: {error}") from error


def read_text(path: Path) -> str:
    """The text of a file. Raises InputError when there is none, it is too large, or it is no text."""
    if not path.is_file():
        raise InputError(f"{path}: {'not a file' if path.exists() else 'no such file'}")
    with path.open("rb") as file:
        content = file.read(MAX_BYTES + 1)
    if len(content) > MAX_BYTES:
        raise InputError(f"{path}: larger than {MAX_BYTES // 1_000_000} MB")
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not UTF-8: {error}") from None


def check_folder(*paths: str | None) -> None:
    """Raise InputError unless the folder of every path exists."""
    for path in paths:
        if path and not Path(path).absolute().parent.is_dir():
            raise InputError(f"{path}: no such folder")


def check_suffix(option: str, path: str | None, accepted: Iterable[str]) -> None:
    """Raise InputError unless the path has one of the suffixes."""
    if path and Path(path).suffix.lower() not in accepted:
        raise InputError(f"{option} {path}: accepted: a file name that ends in {', '.join(accepted)}")

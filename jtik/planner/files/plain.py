"""Readers of plain JSON data that a stranger may have written: each names the place of what is wrong."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Any

from jtik.arguments import mapping
from jtik.errors import ArgumentError

DEEPEST = 20
"""Largest depth of plain data."""

LONGEST_NAME = 100
"""Largest length of a name, in characters."""

PLAIN = "texts, finite numbers, true, false and null, in lists and in mappings with texts as keys"


def plain(argument: str, value: object, depth: int = 0) -> Any:
    """A copy of plain data: what JSON has, nested at most `DEEPEST` deep. Tuples become lists."""
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if isinstance(value, float):
        if math.isfinite(value):
            return float(value)
        raise ArgumentError(argument, value, PLAIN)
    if depth >= DEEPEST:
        raise ArgumentError(argument, f"data nested more than {DEEPEST} deep", PLAIN)
    if isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, str):
                raise ArgumentError(argument, f"the key {key!r}", PLAIN)
        return {key: plain(f"{argument}.{key}", each, depth + 1) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(f"{argument}[{i}]", each, depth + 1) for i, each in enumerate(value)]
    raise ArgumentError(argument, value, PLAIN)


class PlainMapping(dict[str, Any]):
    """A mapping that `plain_mapping` has read. Nobody changes it, so that it is not read again."""


def plain_mapping(argument: str, value: object) -> PlainMapping:
    """A copy of a mapping of plain data."""
    if isinstance(value, PlainMapping):
        return value
    return PlainMapping(plain(argument, mapping(argument, value, "a mapping with texts as keys")))


def entries(argument: str, value: object, required: Collection[str], optional: Collection[str] = ()) -> dict[str, Any]:
    """A mapping with these keys and no others.

    Raises:
        ArgumentError: for anything else, naming the key that is missing or not known.
    """
    accepted = f"a mapping with {', '.join([*required, *(f'{key} (optional)' for key in optional)])}"
    found = mapping(argument, value, accepted)
    for key in required:
        if key not in found:
            raise ArgumentError(argument, f"no {key!r}", accepted)
    for key in found:
        if key not in required and key not in optional:
            raise ArgumentError(argument, f"{key!r}", accepted)
    return found


def label(argument: str, value: object) -> str:
    """A name that a person reads: printable, without space around it, of 1 to `LONGEST_NAME` characters."""
    if isinstance(value, str) and 0 < len(value) <= LONGEST_NAME and value.isprintable() and value == value.strip():
        return str(value)
    given = value if not isinstance(value, str) or len(value) <= LONGEST_NAME else f"{len(value)} characters"
    raise ArgumentError(argument, repr(given), f"a name: 1 to {LONGEST_NAME} printable characters")


def inside(where: str, key: str) -> str:
    """The place of a key: "plan.json: chosen" in a file, "attempt.name" in a value; the key itself in no place."""
    return f"{where}: {key}" if where.endswith(".json") else f"{where}.{key}" if where else key

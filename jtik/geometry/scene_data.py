"""Obstacles as plain data, and the TOML of a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from jtik.arguments import non_negative_number
from jtik.errors import ArgumentError
from jtik.geometry.flat import HalfSpace, Polygon
from jtik.geometry.solids import Box, Capsule, Circle, Cylinder, Point, Solid, Sphere

SHAPES: dict[str, tuple[Callable[..., Solid], tuple[str, ...], tuple[str, ...]]] = {
    "point": (Point, ("center",), ()),
    "circle": (Circle, ("center", "radius"), ()),
    "sphere": (Sphere, ("center", "radius"), ()),
    "capsule": (Capsule, ("start", "end", "radius"), ()),
    "cylinder": (Cylinder, ("start", "end", "radius"), ()),
    "box": (Box.at, ("center", "half"), ("rotation",)),
    "half_space": (HalfSpace, ("point", "normal"), ()),
    "polygon": (Polygon, ("vertices",), ()),
}
"""What makes the obstacle of a shape, the keys that it needs, and those that it may have."""

_NAMES = {Point: "point", Circle: "circle", Sphere: "sphere", Capsule: "capsule", Cylinder: "cylinder"}
_NAMES |= {Box: "box", HalfSpace: "half_space", Polygon: "polygon"}


def obstacle_to(obstacle: Solid) -> dict[str, Any]:
    """An obstacle as texts, numbers and lists.

    Raises:
        ArgumentError: when it is of no shape of jtik's.
    """
    shape = _NAMES.get(type(obstacle))
    if shape is None:
        raise ArgumentError("obstacle", obstacle, f"one of the shapes {', '.join(SHAPES)}")
    _, needed, optional = SHAPES[shape]
    return {"shape": shape, **{key: np.asarray(getattr(obstacle, key)).tolist() for key in (*needed, *optional)}}


def obstacle_from(where: str, data: object) -> tuple[Solid, float]:
    """The obstacle of `obstacle_to`, and its gain, 1 by default.

    Args:
        where: what is in front of the key that an error names.
        data: the table.

    Raises:
        ArgumentError: when a key is missing, unknown or has a wrong value.
    """
    table = read_table(where, data)
    shape = table.get("shape")
    if not isinstance(shape, str) or shape not in SHAPES:
        raise ArgumentError(f"{where}.shape", repr(shape) if "shape" in table else "nothing", f"one of {list(SHAPES)}")
    make, needed, optional = SHAPES[shape]
    read_table(where, table, ("shape", *needed), (*optional, "gain"))
    values = {key: table[key] for key in (*needed, *optional) if key in table}
    try:
        obstacle = make(**values)
    except ArgumentError as error:
        raise ArgumentError(f"{where}.{error.argument}", error.given, error.accepted) from None
    return obstacle, non_negative_number(f"{where}.gain", table.get("gain", 1.0))


def read_table(
    where: str, data: object, needed: tuple[str, ...] | None = None, optional: tuple[str, ...] = ()
) -> dict[str, Any]:
    """A table whose keys are texts, with all the keys that it needs, and no others than these and the optional ones.

    Raises:
        ArgumentError: for anything else.
    """
    if not isinstance(data, Mapping) or not all(isinstance(key, str) and key for key in data):
        raise ArgumentError(where, data, "a table: keys and their values")
    if needed is not None:
        for key in needed:
            if key not in data:
                raise ArgumentError(f"{where}.{key}", "nothing: the key is missing", f"the keys {', '.join(needed)}")
        for key in data:
            if key not in (*needed, *optional):
                raise ArgumentError(f"{where}.{key}", "an unknown key", f"the keys {', '.join((*needed, *optional))}")
    return dict(data)


def from_json(text: str) -> Any:
    """The data of a JSON text. Raises ValueError where it is none, or has a key twice in one object."""
    import json

    return json.loads(text, object_pairs_hook=_distinct)


def _distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        raise ValueError(f"the key {next(key for key in keys if keys.count(key) > 1)!r} is there twice")
    return found


def to_json(data: Mapping[str, Any]) -> str:
    """The JSON of a scene."""
    import json

    return json.dumps(data, indent=2) + "\n"


def from_toml(text: str) -> dict[str, Any]:
    """The data of a TOML text. Raises ValueError where it is none."""
    import tomllib

    return tomllib.loads(text)


def to_toml(data: Mapping[str, Any]) -> str:
    """The TOML of a scene: tables of texts, numbers and lists of numbers, whose JSON is TOML, too."""
    import json

    lines = []
    for section, rows in data.items():
        if not rows:
            lines.append(f"[{section}]\n")
        for name, row in rows.items():
            quoted = json.dumps(name, ensure_ascii=False).replace("\x7f", "\\u007f")  # TOML has no such character
            lines.append(f"[{section}.{quoted}]")
            lines += [*(f"{key} = {json.dumps(value)}" for key, value in row.items()), ""]
    return "\n".join(lines)

"""The robot of a command or of a document: a built-in one, one made of unit links, or a file."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from jtik.cli.checks import InputError, call, checked_name, checked_table
from jtik.errors import ArgumentError, UnknownNameError
from jtik.robot import Robot, gallery

BUILDERS: dict[str, Callable[..., Robot]] = {
    "planar": Robot.planar,
    "vehicle": Robot.vehicle,
    "dh": Robot.from_dh,
    "builtin": Robot.builtin,
}
"""Kinds of robots that are described by numbers or a name, and the functions that build them."""

LOADERS: dict[str, Callable[..., Robot]] = {"urdf": Robot.from_urdf, "mjcf": Robot.from_mjcf}
"""Kinds of robots that a file describes; [robot] path is the file."""

KINDS = (*BUILDERS, *LOADERS)

SUFFIXES = {".urdf": "urdf", ".xacro": "urdf", ".xml": "mjcf"}
"""Kind of a file by its suffix."""

MAX_LINKS = 1000
"""Largest number of links of ``planar:N`` and ``vehicle:N``, far beyond what can be solved in reasonable time."""

ACCEPTED = "a built-in robot (see jtik list robots), planar:10, planar:1,0.8,0.5, vehicle:3, or a .urdf, .xacro or .xml"


def robot_table(specification: str) -> dict[str, Any]:
    """The table [robot] for a robot that is given as one text.

    Args:
        specification: ``planar:10``, ``planar:1,0.8,0.5``, ``vehicle:3``, the name of a built-in robot, or the path of
            a file.

    Raises:
        ArgumentError: when it is none of those.
        UnknownNameError: when it is a name, but of no built-in robot.
    """
    suffix = Path(specification).suffix.lower()
    if suffix in SUFFIXES:
        return {"kind": SUFFIXES[suffix], "path": specification}
    kind, colon, links = specification.partition(":")
    if kind not in ("planar", "vehicle"):
        if not colon and kind and kind == Path(kind).stem:
            return {"kind": "builtin", "name": gallery.describe(kind).name}
        raise ArgumentError("robot", specification, ACCEPTED)
    try:
        lengths = [float(length) for length in links.split(",")]
        return {"kind": kind, "links": int(links) if links.strip().isdecimal() else lengths}
    except ValueError:
        raise ArgumentError("robot", specification, ACCEPTED) from None


def read_robot(given: Any) -> Robot:
    """The robot of a section [robot], or of its short form."""
    table = dict(robot_table(given) if isinstance(given, str) else checked_table("[robot]", given))
    kind = checked_name("[robot] kind", table.pop("kind", None), KINDS)
    if kind not in KINDS:
        raise UnknownNameError("robot kind", kind, KINDS)
    where = f"[robot] {kind}"
    if kind in LOADERS:
        path = table.pop("path", None)
        if not isinstance(path, str):
            raise ArgumentError(f"{where} path", "nothing" if path is None else path, "the path of a file")
        return call(where, partial(LOADERS[kind], Path(path)), table)
    for key in ("links", "rows"):
        _check_links(f"{where}: {key}", table.get(key))
    return call(where, BUILDERS[kind], table)


def _check_links(where: str, links: Any) -> None:
    """Raise InputError for more links than can be used, given as their number or as a list."""
    number = links if isinstance(links, int) else len(links) if isinstance(links, list) else 0
    if number > MAX_LINKS:
        raise InputError(f"{where}: given {number}; accepted: at most {MAX_LINKS} links")

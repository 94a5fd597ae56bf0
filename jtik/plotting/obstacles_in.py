"""Obstacles as they are in live parameters of criteria and clearances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from jtik.arguments import instances
from jtik.geometry import Box, Capsule, Circle, Cylinder, HalfSpace, Point, Polygon, Scene, Solid, Sphere
from jtik.geometry.kinds import KINDS, Kind
from jtik.types import Array

GAINS = "gains"
"""Name of the parameter with the gain of each obstacle."""


def obstacles_in(parameters: Mapping[str, Any]) -> tuple[Solid, ...]:
    """The obstacles of criteria and clearances, each once, without those whose gain is 0.

    Args:
        parameters: live parameters by name, such as ``ik.parameters``.
    """
    found: dict[bytes, Solid] = {}
    for owner in dict.fromkeys(name.rpartition(".")[0] for name in parameters):
        rows = list(_rows(parameters, owner))
        gains = np.ravel(parameters.get(f"{owner}.{GAINS}", np.ones(len(rows))))
        for (kind, numbers), gain in zip(rows, gains, strict=False):
            if gain > 0:
                solid = _solid(kind, numbers)
                found.setdefault(repr(kind.name).encode() + np.concatenate(numbers).tobytes(), solid)
    return tuple(found.values())


def shown_obstacles(given: Any) -> tuple[Solid, ...]:
    """The obstacles of an argument: one, several, or a Scene without those whose gain is 0.

    Raises:
        ArgumentError: for anything else.
    """
    if isinstance(given, Scene):
        return tuple(given[name] for name in given.names if given.gains[name] > 0)
    return instances("obstacles", given, Solid, "obstacles, such as jtik.Sphere or jtik.Box, or a jtik.Scene")


def obstacle_parameters(parameters: Mapping[str, Any]) -> dict[str, Array]:
    """Those of live parameters that describe obstacles."""
    endings = {GAINS, *(name for kind in KINDS for name in kind.parameters)}
    return {name: np.array(value) for name, value in parameters.items() if name.rpartition(".")[2] in endings}


def _rows(parameters: Mapping[str, Any], owner: str) -> Iterator[tuple[Kind, list[Array]]]:
    """The numbers of each obstacle of a criterion or clearance, in the order of its gains."""
    for kind in KINDS:
        names = [f"{owner}.{name}" for name in kind.parameters]
        if all(name in parameters for name in names):
            tables = [np.asarray(parameters[name], dtype=float) for name in names]
            for i in range(len(tables[0])):
                yield kind, [np.ravel(table[i]) for table in tables]


def _solid(kind: Kind, numbers: list[Array]) -> Solid:
    if kind.name == "ball":
        center, radius = numbers[0], float(numbers[1][0])
        if radius == 0:
            return Point(center)
        return Circle(center, radius) if len(center) == 2 else Sphere(center, radius)
    if kind.name in ("capsule", "cylinder"):
        start, end, radius = numbers[0], numbers[1], float(numbers[2][0])
        return Cylinder(start, end, radius) if kind.name == "cylinder" else Capsule(start, end, radius)
    if kind.name == "box":
        turned = numbers[2]
        return Box.at(numbers[0], numbers[1], turned if len(turned) == 4 else float(turned[0]))
    if kind.name == "half_space":
        return HalfSpace(numbers[0], numbers[1])
    corners = numbers[0].reshape(-1, 2)
    return Polygon(corners[[True, *np.any(np.diff(corners, axis=0) != 0, axis=1)]])

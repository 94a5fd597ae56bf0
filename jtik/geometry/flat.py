"""Solids with flat sides that only obstacles have: half-spaces and convex polygons."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from jtik.arguments import array_of, finite_array
from jtik.errors import ArgumentError
from jtik.geometry.solids import Solid, read_only
from jtik.types import Array


@dataclass(frozen=True, eq=False, repr=False)
class HalfSpace(Solid):
    """All points on one side of a plane, or of a line in the plane: a floor, a wall, a table top.

    Attributes:
        point: a point of the surface, (2,) or (3,) [m].
        normal: the direction out of the solid, of the same shape; it is scaled to length 1.

    Raises:
        ArgumentError: when a number is not finite, the normal is zero, or an argument has another shape.
    """

    point: Array
    normal: Array

    def __post_init__(self) -> None:
        point = array_of("point", self.point, [(2,), (3,)], "finite coordinates [m] of shape (2,) or (3,)")
        normal = finite_array("normal", self.normal, point.shape)
        largest = np.abs(normal).max()
        if not largest > 0:
            raise ArgumentError("normal", normal.tolist(), "a direction that is not zero")
        if abs(np.linalg.norm(normal) - 1) > ROUNDING:  # a copy has the same numbers
            normal = normal / largest
            normal = normal / np.linalg.norm(normal)
        object.__setattr__(self, "point", read_only(point))
        object.__setattr__(self, "normal", read_only(normal))

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), self.point, self.normal), ()

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return len(self.point)


@dataclass(frozen=True, eq=False, repr=False)
class Polygon(Solid):
    """A convex polygon in the plane.

    Attributes:
        vertices: its corners in order around it, (k, 2) [m], k from 3; they are kept counterclockwise.

    Raises:
        ArgumentError: when a number is not finite, there are fewer than three corners, it has no area, or it is not
            convex.
    """

    vertices: Array

    def __post_init__(self) -> None:
        accepted = "at least three corners (k, 2) [m] in order around a convex polygon"
        vertices = array_of("vertices", self.vertices, [(None, 2)], accepted)
        if len(vertices) < 3:
            raise ArgumentError("vertices", f"{len(vertices)} corners", accepted)
        edges = np.roll(vertices, -1, axis=0) - vertices
        following = np.roll(edges, -1, axis=0)
        turns = edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0]
        size = float(np.abs(vertices - vertices.mean(axis=0)).max())
        relative = vertices - vertices[0]
        area = float(np.sum(relative[:-1, 0] * relative[1:, 1] - relative[:-1, 1] * relative[1:, 0])) / 2
        if not abs(area) > SMALLEST_AREA * size**2:
            raise ArgumentError("vertices", f"a polygon with the area {abs(area):g} m^2", f"{accepted}, with an area")
        turned = np.arctan2(turns, np.sum(edges * following, axis=1))
        convex = np.sign(area) * turns >= -SMALLEST_AREA * size**2
        if not convex.all() or abs(abs(turned.sum()) - 2 * np.pi) > 1e-6:
            raise ArgumentError("vertices", "corners of a polygon that is not convex", accepted)
        object.__setattr__(self, "vertices", read_only(vertices if area > 0 else vertices[::-1].copy()))

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), self.vertices), ()

    @property
    def dimension(self) -> int:
        """2: a polygon is in the plane."""
        return 2


ROUNDING = 1e-15
"""Difference from 1 up to which the length of a normal counts as 1."""

SMALLEST_AREA = 1e-9
"""Area of a polygon, in squares of its size, below which it counts as degenerate."""

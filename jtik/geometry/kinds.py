"""Kinds of obstacles: their numbers as live parameters, and their distances as expressions of these parameters."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from jtik.errors import ArgumentError
from jtik.geometry.boxes import in_axes, point_to_box, segment_to_box
from jtik.geometry.cylinders import Axis, point_to_cylinder, segment_to_cylinder
from jtik.geometry.distances import (
    point_to_ball,
    point_to_capsule,
    point_to_half_space,
    segment_to_ball,
    segment_to_capsule,
    segment_to_half_space,
)
from jtik.geometry.flat import HalfSpace, Polygon
from jtik.geometry.polygons import Sides, corners, point_to_polygon, segment_to_polygon
from jtik.geometry.solids import Ball, Box, Capsule, Circle, Cylinder, Solid, Sphere
from jtik.symbolic import TINY, Expression, cos, if_else, sin, sqrt, stack, sumsqr
from jtik.types import Array


@dataclass(frozen=True)
class Distances:
    """Distances to one obstacle as expressions.

    Attributes:
        point: signed distance [m] of a point (d, 1) [m].
        segment: signed distance [m] of a segment between two points.
        rounding: radius of the ball that rounds the obstacle [m]: it is all points within it of a convex set, a number
            or an expression; infinity for a half-space.
    """

    point: Callable[[Expression], Expression]
    segment: Callable[[Expression, Expression], Expression]
    rounding: Expression = 0.0

    def of(self, *points: Expression) -> Expression:
        """Signed distance [m] of a body without thickness: of one point (d, 1), or of the segment between two.

        Args:
            points: the point, or start and end of the segment, (d, 1) [m] each.
        """
        return self.point(*points) if len(points) == 1 else self.segment(*points)


class Kind(ABC):
    """A kind of obstacle with live parameters.

    Attributes:
        name: its name in the counts of `Slots`.
        solid: the class of its solids.
        parameters: names of its parameters, each with one row, or one number, for each obstacle.
        sizes: those of them that are not negative.
        judged: those of them whose rows `accepted_instead` judges.
        dimensions: 2 for the plane, 3 for space.
    """

    name: ClassVar[str]
    solid: ClassVar[type[Solid]]
    parameters: ClassVar[tuple[str, ...]]
    sizes: ClassVar[tuple[str, ...]] = ()
    judged: ClassVar[tuple[str, ...]] = ()
    dimensions: ClassVar[tuple[int, ...]] = (2, 3)

    @abstractmethod
    def absent(self, dimension: int) -> Solid:
        """What a slot holds that is not used."""

    @abstractmethod
    def numbers(self, obstacle: Any) -> tuple[Any, ...]:
        """The numbers of an obstacle, in the order of ``parameters``."""

    @abstractmethod
    def distances(self, *numbers: Expression) -> Distances:
        """The distances to an obstacle of these numbers: scalars and columns, in the order of ``parameters``."""

    def values(self, obstacles: Sequence[Solid], dimension: int, corner_count: int) -> dict[str, Array]:
        """The values of its parameters for these obstacles."""
        rows = [self.numbers(each) for each in (*obstacles, self.absent(dimension))]
        return {
            name: np.array(column)[:-1] for name, column in zip(self.parameters, zip(*rows, strict=True), strict=True)
        }

    def accepted_instead(self, row: Array) -> str | None:
        """What would be accepted instead of a row of a judged parameter; None where the row is accepted."""
        return None

    def at(self, parameters: Mapping[str, Expression], i: int) -> Distances:
        """The distances to the obstacle i of these parameters."""
        return self.distances(*(parameters[name][i, :].T for name in self.parameters))


class BallKind(Kind):
    """Points, circles and spheres."""

    name, solid, parameters, sizes = "ball", Ball, ("centers", "radii"), ("radii",)

    def absent(self, dimension: int) -> Solid:
        """A ball of radius 0."""
        return Circle(np.zeros(2)) if dimension == 2 else Sphere(np.zeros(3))

    def numbers(self, obstacle: Ball) -> tuple[Any, ...]:
        """Centre and radius."""
        return obstacle.center, obstacle.radius

    def distances(self, *numbers: Expression) -> Distances:
        """Of a ball."""
        center, radius = numbers
        return Distances(
            lambda point: point_to_ball(point, center, radius),
            lambda start, end: segment_to_ball(start, end, center, radius),
            radius,
        )


class CapsuleKind(Kind):
    """Capsules."""

    name, solid, parameters = "capsule", Capsule, ("capsule_starts", "capsule_ends", "capsule_radii")
    sizes = ("capsule_radii",)

    def absent(self, dimension: int) -> Solid:
        """A capsule around a point."""
        return Capsule(np.zeros(dimension), np.zeros(dimension), 1.0)

    def numbers(self, obstacle: Capsule) -> tuple[Any, ...]:
        """Ends and radius."""
        return obstacle.start, obstacle.end, obstacle.radius

    def distances(self, *numbers: Expression) -> Distances:
        """Of a capsule."""
        first, last, radius = numbers
        return Distances(
            lambda point: point_to_capsule(point, first, last, radius),
            lambda start, end: segment_to_capsule(start, end, first, last, radius),
            radius,
        )


class BoxKind(Kind):
    """Boxes: a centre, halves of the edges, and a quaternion (w, x, y, z) or in the plane an angle [rad]."""

    name, solid, parameters = "box", Box, ("box_centers", "box_halves", "box_rotations")
    sizes, judged = ("box_halves",), ("box_rotations",)

    def absent(self, dimension: int) -> Solid:
        """A box of edges of 2 m."""
        return Box.at(np.zeros(dimension), np.ones(dimension))

    def numbers(self, obstacle: Box) -> tuple[Any, ...]:
        """Centre, half edges, rotation."""
        return obstacle.center, obstacle.half, obstacle.rotation

    def accepted_instead(self, row: Array) -> str | None:
        """A quaternion is not zero."""
        return "quaternions (w, x, y, z) that are not zero" if row.size == 4 and not row.any() else None

    def distances(self, *numbers: Expression) -> Distances:
        """Of a box."""
        center, half, turned = numbers
        rotation = _rotation(turned)

        def local(point: Expression) -> Expression:
            return in_axes(point, center, rotation)

        return Distances(
            lambda point: point_to_box(local(point), half),
            lambda start, end: segment_to_box(local(start), local(end), half),
        )


class HalfSpaceKind(Kind):
    """Half-spaces; the live normals need not be of length 1."""

    name, solid, parameters = "half_space", HalfSpace, ("half_space_points", "half_space_normals")
    judged = ("half_space_normals",)

    def absent(self, dimension: int) -> Solid:
        """A half-space below the origin."""
        return HalfSpace(np.zeros(dimension), np.eye(dimension)[-1])

    def numbers(self, obstacle: HalfSpace) -> tuple[Any, ...]:
        """Point and normal."""
        return obstacle.point, obstacle.normal

    def accepted_instead(self, row: Array) -> str | None:
        """A normal is not zero."""
        return None if row.any() else "normals that are not zero"

    def distances(self, *numbers: Expression) -> Distances:
        """Of a half-space."""
        origin, normal = numbers
        unit = normal / sqrt(sumsqr(normal) + TINY)
        return Distances(
            lambda point: point_to_half_space(point, origin, unit),
            lambda start, end: segment_to_half_space(start, end, origin, unit),
            math.inf,
        )


class PolygonKind(Kind):
    """Convex polygons: a row of coordinates x0, y0, x1, y1, ... each; the last corner is repeated."""

    name, solid, parameters, dimensions = "polygon", Polygon, ("polygon_vertices",), (2,)
    judged = parameters

    def absent(self, dimension: int) -> Solid:
        """A triangle."""
        return Polygon(np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]))

    def numbers(self, obstacle: Any) -> tuple[Any, ...]:
        """Its corners in a row."""
        return (obstacle.vertices.ravel(),)

    def values(self, obstacles: Sequence[Solid], dimension: int, corner_count: int) -> dict[str, Array]:
        """The corners, as many for each polygon."""
        rows = []
        for each in obstacles:
            vertices = np.asarray(self.numbers(each)[0]).reshape(-1, 2)
            rows.append(np.pad(vertices, ((0, corner_count - len(vertices)), (0, 0)), mode="edge").ravel())
        return {"polygon_vertices": np.array(rows).reshape(-1, 2 * corner_count)}

    def accepted_instead(self, row: Array) -> str | None:
        """The corners are those of a convex polygon, counterclockwise."""
        vertices = row.reshape(-1, 2)
        repeated = (vertices == np.roll(vertices, -1, axis=0)).all(axis=1)
        try:
            polygon = Polygon(vertices[~repeated])
        except ArgumentError:
            return COUNTERCLOCKWISE
        return None if np.array_equal(polygon.vertices, vertices[~repeated]) else COUNTERCLOCKWISE

    def distances(self, *numbers: Expression) -> Distances:
        """Of a convex polygon."""
        sides = Sides(corners(numbers[0]))
        return Distances(
            lambda point: point_to_polygon(point, sides), lambda start, end: segment_to_polygon(start, end, sides)
        )


class CylinderKind(Kind):
    """Cylinders with flat ends."""

    name, solid, parameters = "cylinder", Cylinder, ("cylinder_starts", "cylinder_ends", "cylinder_radii")
    sizes, dimensions = ("cylinder_radii",), (3,)

    def absent(self, dimension: int) -> Solid:
        """A cylinder of radius and length 1 m."""
        return Cylinder(np.zeros(3), np.eye(3)[2], 1.0)

    def numbers(self, obstacle: Cylinder) -> tuple[Any, ...]:
        """Ends of the axis and radius."""
        return obstacle.start, obstacle.end, obstacle.radius

    def distances(self, *numbers: Expression) -> Distances:
        """Of a cylinder."""
        axis = Axis.between(*numbers)
        return Distances(
            lambda point: point_to_cylinder(point, axis), lambda start, end: segment_to_cylinder(start, end, axis)
        )


KINDS: tuple[Kind, ...] = (BallKind(), CapsuleKind(), BoxKind(), HalfSpaceKind(), PolygonKind(), CylinderKind())
"""The kinds of obstacles, in the order of the slots."""


COUNTERCLOCKWISE = "in each row the corners x0, y0, x1, y1, ... of a convex polygon with an area, counterclockwise"
"""Corners of live polygons, for errors."""


def _rotation(turned: Expression) -> Expression:
    """The rotation matrix of a quaternion (w, x, y, z) of any length, or of an angle [rad]; none of zeros."""
    if turned.numel() == 1:
        cosine, sine = cos(turned), sin(turned)
        return stack([[cosine, -sine], [sine, cosine]])
    w, x, y, z = (turned[i] for i in range(4))
    square = sumsqr(turned)
    s = if_else(square > 0, 2 / (square + TINY), 0)
    return stack(
        [
            [1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
            [s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)],
            [s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)],
        ]
    )

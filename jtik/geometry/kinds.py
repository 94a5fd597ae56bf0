"""Kinds of obstacles: their numbers as live parameters, and their distances as expressions of these parameters."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from jtik.errors import ArgumentError
from jtik.geometry.boxes import point_to_box, segment_to_box
from jtik.geometry.centers import beside
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
from jtik.geometry.pair_functions import Distances
from jtik.geometry.polygons import Sides, corners, point_to_polygon, segment_to_polygon
from jtik.geometry.solids import Ball, Box, Capsule, Circle, Cylinder, Solid, Sphere
from jtik.symbolic import TINY, Expression, cos, if_else, reshape, sin, sqrt, stack, sumsqr, vec
from jtik.symbolic.held import Hold, not_held
from jtik.types import Array


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
    def distance(self, points: Sequence[Expression], *figures: Expression, hold: Hold = not_held) -> Expression:
        """Signed distance [m] of one point (d, 1), or of the segment between two, to an obstacle of these figures."""

    def figures(self, *numbers: Expression) -> tuple[Expression, ...]:
        """What the distances to an obstacle of these numbers are computed from, columns: the numbers themselves."""
        return numbers

    def rounding(self, *numbers: Expression) -> Expression:
        """Radius of the ball that rounds an obstacle of these numbers [m]; infinity for a half-space."""
        return 0.0

    def distances(self, *numbers: Expression) -> Distances:
        """The distances to an obstacle of these numbers: scalars and columns, in the order of ``parameters``."""
        return Distances(self.name, self.distance, self.figures(*numbers), self.rounding(*numbers))

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

    def distance(self, points: Sequence[Expression], *figures: Expression, hold: Hold = not_held) -> Expression:
        """To a ball."""
        center, radius = figures
        if len(points) == 1:
            return point_to_ball(points[0], center, radius)
        return segment_to_ball(points[0], points[1], center, radius, hold)

    def rounding(self, *numbers: Expression) -> Expression:
        """Its radius."""
        return numbers[1]


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

    def distance(self, points: Sequence[Expression], *figures: Expression, hold: Hold = not_held) -> Expression:
        """To a capsule."""
        return _of(points, point_to_capsule, segment_to_capsule)(*points, *figures, hold)

    def rounding(self, *numbers: Expression) -> Expression:
        """Its radius."""
        return numbers[2]


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

    def figures(self, *numbers: Expression) -> tuple[Expression, ...]:
        """A point beside its centre, half edges, and the entries of the rotation matrix."""
        center, half, turned = numbers
        return beside(center), half, vec(_rotation(turned))

    def distance(self, points: Sequence[Expression], *figures: Expression, hold: Hold = not_held) -> Expression:
        """To a box."""
        center, half, entries = figures
        size = half.shape[0]
        rotation = reshape(entries, size, size)
        local = [rotation.T @ (point - center) for point in points]
        return _of(points, point_to_box, segment_to_box)(*local, half, hold)


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

    def figures(self, *numbers: Expression) -> tuple[Expression, ...]:
        """A point of the boundary and the unit normal."""
        origin, normal = numbers
        return origin, normal / sqrt(sumsqr(normal) + TINY)

    def distance(self, points: Sequence[Expression], *figures: Expression, hold: Hold = not_held) -> Expression:
        """To a half-space."""
        origin, normal = figures
        if len(points) == 1:
            return point_to_half_space(points[0], origin, normal)
        return segment_to_half_space(points[0], points[1], origin, normal, hold)

    def rounding(self, *numbers: Expression) -> Expression:
        """Infinity."""
        return math.inf


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

    def distance(self, points: Sequence[Expression], *figures: Expression, hold: Hold = not_held) -> Expression:
        """To a convex polygon."""
        sides = Sides(corners(figures[0]))
        return _of(points, point_to_polygon, segment_to_polygon)(*points, sides, hold)


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

    def figures(self, *numbers: Expression) -> tuple[Expression, ...]:
        """Those of its axis."""
        axis = Axis.between(*numbers)
        return axis.center, axis.direction, axis.half, axis.radius

    def distance(self, points: Sequence[Expression], *figures: Expression, hold: Hold = not_held) -> Expression:
        """To a cylinder."""
        return _of(points, point_to_cylinder, segment_to_cylinder)(*points, Axis(*figures), hold)


KINDS: tuple[Kind, ...] = (BallKind(), CapsuleKind(), BoxKind(), HalfSpaceKind(), PolygonKind(), CylinderKind())
"""The kinds of obstacles, in the order of the slots."""


def _of(
    points: Sequence[Expression], point: Callable[..., Expression], segment: Callable[..., Expression]
) -> Callable[..., Expression]:
    """The function for one point, or that for a segment."""
    return point if len(points) == 1 else segment


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

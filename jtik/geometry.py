"""Shapes in the workspace and signed distances to them, as CasADi expressions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError, finite_array
from jtik.symbolic import TINY, Expression, dot, fmax, fmin, norm, sumsqr
from jtik.types import Array


class Solid:
    """A body in the workspace, or on a link of a robot in the coordinates of its frame."""


@dataclass(frozen=True, init=False, eq=False)
class Ball(Solid):
    """All points within ``radius`` [m] of ``center`` [m]; radius 0 is a point. Circle in the plane, Sphere in space."""

    center: Array
    radius: float

    dimensions: ClassVar[tuple[int, ...]] = (2, 3)

    def __init__(self, center: ArrayLike, radius: float = 0.0) -> None:
        array = np.array(center, dtype=float)
        sizes = " or ".join(f"({size},)" for size in self.dimensions)
        if array.shape not in [(size,) for size in self.dimensions] or not np.all(np.isfinite(array)):
            raise ArgumentError("center", center, f"finite coordinates [m] of shape {sizes}")
        length = float(finite_array("radius", radius, ()))
        if length < 0:
            raise ArgumentError("radius", radius, "a finite length [m] from 0")
        array.setflags(write=False)
        object.__setattr__(self, "center", array)
        object.__setattr__(self, "radius", length)

    def __repr__(self) -> str:
        return f"{type(self).__name__}(center={tuple(self.center.tolist())}, radius={self.radius})"


class Point(Ball):
    """A point obstacle, as in the paper, in the plane or in space."""

    def __init__(self, center: ArrayLike) -> None:
        super().__init__(center, 0.0)


class Circle(Ball):
    """A disc in the plane of a planar robot: center (2,) [m] and radius [m]."""

    dimensions = (2,)


class Sphere(Ball):
    """A ball in space: center (3,) [m] and radius [m]."""

    dimensions = (3,)


@dataclass(frozen=True, eq=False)
class _Rounded(Solid):
    """A segment with a radius: ends (3,) [m] and radius [m]."""

    start: Array
    end: Array
    radius: float

    def __post_init__(self) -> None:
        for name in ("start", "end"):
            object.__setattr__(self, name, _read_only(finite_array(name, getattr(self, name), (3,))))
        object.__setattr__(self, "radius", _positive("radius", self.radius))

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), self.start, self.end, self.radius), ()


class Capsule(_Rounded):
    """All points within ``radius`` [m] of the segment from ``start`` to ``end``, (3,) [m] each."""


class Cylinder(_Rounded):
    """A cylinder with flat ends: the ends of its axis ``start`` and ``end``, (3,) [m], and its ``radius`` [m]."""


@dataclass(frozen=True, eq=False)
class Box(Solid):
    """A box: the pose (4, 4) [m] of its centre, axes along its edges, and half of each edge's length, (3,) [m]."""

    pose: Array
    half: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose", _read_only(finite_array("pose", self.pose, (4, 4))))
        half = finite_array("half", self.half, (3,))
        if half.min() <= 0:
            raise ArgumentError("half", half.tolist(), "three positive lengths [m]")
        object.__setattr__(self, "half", _read_only(half))

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), self.pose, self.half), ()


def enclosing_segment(solid: Solid) -> tuple[Array, Array, float]:
    """Ends (3,) [m] and radius [m] of a capsule that holds the solid: the tightest one about its longest axis."""
    if isinstance(solid, _Rounded):
        return solid.start, solid.end, solid.radius
    if isinstance(solid, Ball):
        center = np.pad(solid.center, (0, 3 - len(solid.center)))
        return center, center, solid.radius
    if isinstance(solid, Box):
        longest = int(np.argmax(solid.half))
        reach = solid.half[longest] * solid.pose[:3, longest]
        across = float(np.linalg.norm(np.delete(solid.half, longest)))
        return solid.pose[:3, 3] - reach, solid.pose[:3, 3] + reach, across
    raise ArgumentError("solid", solid, "a jtik.Sphere, Capsule, Cylinder or Box")


def _read_only(array: Array) -> Array:
    array.flags.writeable = False
    return array


def _positive(argument: str, value: object) -> float:
    length = float(finite_array(argument, value, ()))
    if length <= 0:
        raise ArgumentError(argument, value, "a positive length [m]")
    return length


Obstacle: TypeAlias = Ball


def centers_and_radii(obstacles: Iterable[Obstacle], dimension: int) -> tuple[Array, Array]:
    """Centres (k, dimension) and radii (k,) of obstacles. Raises ArgumentError for shapes of another dimension."""
    chosen = list(obstacles)
    for obstacle in chosen:
        if not isinstance(obstacle, Ball) or obstacle.center.shape != (dimension,):
            wanted = "jtik.Point or jtik.Circle with center (2,)" if dimension == 2 else "jtik.Point or jtik.Sphere"
            raise ArgumentError("obstacles", obstacle, f"{wanted} on this {dimension}-dimensional robot")
    centers = np.array([obstacle.center for obstacle in chosen]).reshape(-1, dimension)
    return centers, np.array([obstacle.radius for obstacle in chosen])


def point_to_ball(point: Expression, center: Expression, radius: Expression) -> Expression:
    """Signed distance [m] from a point to a ball's surface; negative inside."""
    return norm(point - center) - radius


def segment_to_ball(start: Expression, end: Expression, center: Expression, radius: Expression) -> Expression:
    """Signed distance [m] from the closest point of a segment to a ball's surface; negative inside."""
    along = end - start
    parameter = fmin(fmax(dot(center - start, along) / (sumsqr(along) + TINY), 0), 1)
    return point_to_ball(start + parameter * along, center, radius)

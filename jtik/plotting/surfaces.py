"""Surfaces of solids as triangles, for pictures."""

from __future__ import annotations

import math
from functools import singledispatch
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from jtik.errors import ArgumentError
from jtik.geometry import Ball, Box, Capsule, Cylinder, HalfSpace, Solid
from jtik.plotting.scenery import outline
from jtik.types import Array

SIDES = 20
"""Corners of a circle."""

POINT = 0.01
"""Radius with which a point is drawn [m]."""


class Surface(NamedTuple):
    """A closed surface.

    Attributes:
        vertices: its corners, (n, 3) [m].
        faces: the corners of each triangle, (m, 3), anticlockwise seen from outside.
        smooth: whether it has no edges, so that its shading is smooth.
    """

    vertices: Array
    faces: NDArray[np.int64]
    smooth: bool

    def at(self, pose: Array) -> Surface:
        """The surface at a pose (4, 4) [m]."""
        return self._replace(vertices=self.vertices @ pose[:3, :3].T + pose[:3, 3])


@singledispatch
def surface(solid: object) -> Surface:
    """The surface of a solid in space.

    Raises:
        ArgumentError: for a solid that cannot be drawn in space.
    """
    raise ArgumentError("solid", solid, "a solid in space, such as jtik.Sphere, Capsule, Cylinder or Box")


FLAT, DEPTH = 0.02, 0.12
"""Half of the height of an obstacle in the plane, and how deep a half-space is drawn, as shares of a radius."""


class Extent(NamedTuple):
    """A ball around what is drawn: how far a half-space is drawn, and how high an obstacle in the plane.

    Attributes:
        middle: its middle, (3,) [m].
        radius: its radius [m].
    """

    middle: Array
    radius: float


def extent_of(points: Array) -> Extent:
    """The ball around the box of points (k, 3) [m]."""
    low, high = points.min(axis=0), points.max(axis=0)
    return Extent((low + high) / 2, max(float(np.linalg.norm(high - low)) / 2, 1e-3))


def obstacle_surface(solid: Solid, extent: Extent) -> Surface:
    """The surface of an obstacle: a half-space is a patch, and an obstacle in the plane is a disc.

    Args:
        solid: the obstacle.
        extent: what else is drawn.

    Raises:
        ArgumentError: for a solid that cannot be drawn.
    """
    radius = extent.radius
    if isinstance(solid, HalfSpace):
        normal = np.pad(solid.normal, (0, 3 - len(solid.normal)))
        point = np.pad(solid.point, (0, 3 - len(solid.point)))
        pose = np.eye(4)
        pose[:3, :3] = along(np.zeros(3), normal)
        depth = DEPTH * radius if solid.dimension == 2 else 0.01 * radius
        pose[:3, 3] = extent.middle - ((extent.middle - point) @ normal + depth) * normal
        if solid.dimension == 2:
            pose[:3, :3] = np.stack([np.cross([0.0, 0.0, 1.0], normal), [0.0, 0.0, 1.0], normal], axis=1)
            return box(np.array([1.2 * radius, FLAT * radius, depth])).at(pose)
        return box(np.array([1.2 * radius, 1.2 * radius, depth]), 10).at(pose)
    if solid.dimension == 3:
        return surface(solid)
    if isinstance(solid, Ball):
        x, y = solid.center.tolist()
        height = FLAT * radius
        return surface(Cylinder((x, y, -height), (x, y, height), solid.radius or POINT))  # type: ignore[arg-type]
    return prism(outline(solid), FLAT * radius)


def prism(corners: Array, half: float) -> Surface:
    """The surface of a prism over a convex polygon (k, 2) [m] about z = 0, of half a height [m]."""
    count, here = len(corners), np.arange(len(corners))
    following = (here + 1) % count
    vertices = np.concatenate([np.column_stack([corners, np.full(count, z)]) for z in (-half, half)])
    fan = np.stack([np.zeros(count - 2, dtype=np.int64), here[1:-1], here[2:]], axis=1)
    above = following + count
    sides = [np.stack([here, following, above], axis=1), np.stack([here, above, here + count], axis=1)]
    return Surface(vertices, np.concatenate([fan[:, ::-1], fan + count, *sides]), smooth=False)


@surface.register
def _ball(solid: Ball) -> Surface:
    if solid.center.shape != (3,):
        raise ArgumentError("solid", solid, "a ball in space, with center (3,)")
    return _capsule(solid.center, solid.center, solid.radius or POINT)


@surface.register
def _of_capsule(solid: Capsule) -> Surface:
    return _capsule(solid.start, solid.end, solid.radius)


@surface.register
def _of_cylinder(solid: Cylinder) -> Surface:
    length = float(np.linalg.norm(solid.end - solid.start))
    pieces = _pieces(length, solid.radius)
    side = [(solid.radius, length * k / pieces) for k in range(pieces + 1)]
    return _revolved(solid.start, solid.end, [(0.0, 0.0), *side, (0.0, length)], smooth=False)


@surface.register
def _of_box(solid: Box) -> Surface:
    return box(solid.half).at(solid.pose)


def box(half: Array, pieces: int = 6) -> Surface:
    """The surface of a box about the origin, each side of it in pieces.

    Args:
        half: half of the length of each edge, (3,) [m].
        pieces: number of pieces along each edge.
    """
    ticks = np.linspace(-1.0, 1.0, pieces + 1)
    u, v = (each.ravel() for each in np.meshgrid(ticks, ticks, indexing="ij"))
    corner = np.arange((pieces + 1) ** 2).reshape(pieces + 1, pieces + 1)
    a, b, c, d = (part.ravel() for part in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]))
    outward = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    vertices: list[Array] = []
    faces: list[NDArray[np.int64]] = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            side = np.zeros((len(u), 3))
            side[:, axis], side[:, (axis + 1) % 3], side[:, (axis + 2) % 3] = sign, u, v
            faces.append((outward if sign > 0 else outward[:, ::-1]) + len(u) * len(vertices))
            vertices.append(side)
    return Surface(np.concatenate(vertices) * half, np.concatenate(faces), smooth=False)


def _capsule(start: Array, end: Array, radius: float) -> Surface:
    length = float(np.linalg.norm(end - start))
    turns = np.linspace(0.0, math.pi / 2, SIDES // 4 + 1)
    below = [(radius * math.sin(t), -radius * math.cos(t)) for t in turns]
    above = [(r, length - z) for r, z in reversed(below)]
    pieces = _pieces(length, radius)
    between = [(radius, length * k / pieces) for k in range(1, pieces)]
    return _revolved(start, end, [*below, *between, *(above if length > 0 else above[1:])], smooth=True)


def capsule(start: Array, end: Array, radius: float) -> Surface:
    """The surface of all points within ``radius`` [m] of the segment from ``start`` to ``end``, (3,) [m] each."""
    return _capsule(start, end, radius)


def _pieces(length: float, radius: float) -> int:
    """In how many pieces a side is divided: long triangles cannot be drawn in the order of their depth."""
    return int(min(12, max(1, math.ceil(length / (2 * radius)))))


def _revolved(start: Array, end: Array, profile: list[tuple[float, float]], *, smooth: bool) -> Surface:
    """A profile of (distance from the axis, height above ``start``), revolved about the axis to ``end``.

    Its first and its last point are on the axis.
    """
    angles = 2 * math.pi * np.arange(SIDES) / SIDES
    circle = np.stack([np.cos(angles), np.sin(angles), np.zeros(SIDES)], axis=1)
    rings = [radius * circle + [0.0, 0.0, height] for radius, height in profile[1:-1]]
    ends = [[0.0, 0.0, profile[0][1]], [0.0, 0.0, profile[-1][1]]]
    vertices = np.concatenate([*rings, ends])
    here, following = np.arange(SIDES), (np.arange(SIDES) + 1) % SIDES
    first, last, top = len(vertices) - 2, len(vertices) - 1, (len(rings) - 1) * SIDES
    faces = [np.stack([following, here, np.full(SIDES, first)], axis=1)]
    for k in range(len(rings) - 1):
        low, high = k * SIDES, (k + 1) * SIDES
        faces.append(np.stack([low + here, low + following, high + following], axis=1))
        faces.append(np.stack([low + here, high + following, high + here], axis=1))
    faces.append(np.stack([top + here, top + following, np.full(SIDES, last)], axis=1))
    return Surface(vertices @ along(start, end).T + start, np.concatenate(faces), smooth)


def along(start: Array, end: Array) -> Array:
    """A rotation (3, 3) whose z axis points from ``start`` to ``end``; the identity where they coincide."""
    length = np.linalg.norm(end - start)
    if length == 0:
        return np.eye(3)
    z = (end - start) / length
    x = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = x - (x @ z) * z
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)

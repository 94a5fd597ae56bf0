"""Simple solids around others: the capsules that the bodies of a robot are measured by, and coordinate bounds."""

from __future__ import annotations

import numpy as np

from jtik.errors import ArgumentError
from jtik.geometry.flat import HalfSpace, Polygon
from jtik.geometry.solids import Ball, Box, Capsule, Cylinder, Solid
from jtik.types import Array


def enclosing_segment(solid: Solid) -> tuple[Array, Array, float]:
    """The smallest capsule around a solid about its longest axis.

    A ball and a capsule are themselves. Around a cylinder of radius r it adds at its rims nothing, at the middle of
    each end r. Around a box with the half edges a >= b >= c its radius is sqrt(b^2 + c^2): it adds up to
    sqrt(b^2 + c^2) - c beside the box, and its radius beyond each end. A rod of square section becomes thicker by 41 %,
    and a cube's capsule extends 1.41 half edges beyond two of its sides.

    Args:
        solid: a sphere, capsule, cylinder or box.

    Returns:
        The ends of its axis, (3,) [m] each, and its radius [m].

    Raises:
        ArgumentError: when ``solid`` is not a Sphere, Capsule, Cylinder or Box.
    """
    if isinstance(solid, (Capsule, Cylinder)):
        return _in_space(solid.start), _in_space(solid.end), solid.radius
    if isinstance(solid, Ball):
        center = _in_space(solid.center)
        return center, center, solid.radius
    if isinstance(solid, Box):
        longest = int(np.argmax(solid.half))
        axis = solid.half[longest] * solid.pose[:-1, longest]
        radius = float(np.linalg.norm(np.delete(solid.half, longest)))
        return _in_space(solid.center - axis), _in_space(solid.center + axis), radius
    raise ArgumentError("solid", solid, "a jtik.Sphere, Capsule, Cylinder or Box")


def enclosing_balls(solid: Solid) -> list[tuple[Array, float]]:
    """Balls that cover a box, and add less to its sides than the capsule of `enclosing_segment`.

    The box is divided into cells whose edges are about twice its shortest half edge c, each in a ball: they add up to
    0.73 c beside the box, more where that would be over 64 balls. Where the capsule about the longest axis is not
    thicker, as for a rod or a cube, and for every solid but a box, there are none: the capsule is tighter.

    Args:
        solid: a sphere, capsule, cylinder or box.

    Returns:
        Centre (3,) [m] and radius [m] of each ball.

    Raises:
        ArgumentError: when ``solid`` is not a Sphere, Capsule, Cylinder or Box.
    """
    _, _, thickness = enclosing_segment(solid)
    if not isinstance(solid, Box):
        return []
    smallest = float(solid.half.min())
    counts = np.ceil(solid.half / smallest * (1 - 1e-9)).astype(int)
    while counts.prod() > MOST_BALLS:
        smallest *= 1.1
        counts = np.maximum(np.ceil(solid.half / smallest), 1).astype(int)
    radius = float(np.linalg.norm(solid.half / counts))
    if radius >= thickness:
        return []
    cells = np.array(list(np.ndindex(*counts)))
    centers = ((2 * cells + 1) / counts - 1) * solid.half
    return [(_in_space(solid.pose[:-1, :-1] @ each + solid.center), radius) for each in centers]


MOST_BALLS = 64
"""Largest number of balls around one box."""


def bounds(solid: Solid) -> tuple[Array, Array]:
    """The smallest and the largest coordinates of a solid, (2,) or (3,) [m] each; of a half-space those of its point.

    Args:
        solid: the solid.

    Raises:
        ArgumentError: when ``solid`` is none of jtik's.
    """
    if isinstance(solid, HalfSpace):
        return solid.point, solid.point
    if isinstance(solid, Polygon):
        return solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    if isinstance(solid, Ball):
        return solid.center - solid.radius, solid.center + solid.radius
    if isinstance(solid, Box):
        reach = np.abs(solid.pose[:-1, :-1]) @ solid.half
        return solid.center - reach, solid.center + reach
    if isinstance(solid, (Capsule, Cylinder)):
        low, high = np.minimum(solid.start, solid.end), np.maximum(solid.start, solid.end)
        reach = np.full(len(low), solid.radius)
        if isinstance(solid, Cylinder):
            axis = (solid.end - solid.start) / np.linalg.norm(solid.end - solid.start)
            reach = solid.radius * np.sqrt(np.maximum(1 - axis**2, 0))
        return low - reach, high + reach
    raise ArgumentError("solid", solid, "a solid of jtik.geometry")


def _in_space(point: Array) -> Array:
    """A point of the plane or of space, (3,)."""
    return np.pad(point, (0, 3 - len(point)))

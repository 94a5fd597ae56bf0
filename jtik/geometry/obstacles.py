"""Obstacles: the solids that a criterion can measure distances to."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

import numpy as np

from jtik.arguments import several
from jtik.errors import ArgumentError
from jtik.geometry.solids import Ball, Solid
from jtik.types import Array

Obstacle: TypeAlias = Solid
"""A point, circle, sphere, capsule, box, half-space, cylinder or convex polygon."""


def centers_and_radii(obstacles: Iterable[Obstacle], dimension: int) -> tuple[Array, Array]:
    """Centres (k, dimension) [m] and radii (k,) [m] of balls.

    Args:
        obstacles: points, circles or spheres.
        dimension: 2 for the plane, 3 for space.

    Raises:
        ArgumentError: when one is not a point, circle or sphere of that dimension.
    """
    accepted = "jtik.Point or jtik.Circle with center (2,)" if dimension == 2 else "jtik.Point or jtik.Sphere"
    chosen = several("obstacles", obstacles, accepted)
    for obstacle in chosen:
        if not isinstance(obstacle, Ball) or obstacle.center.shape != (dimension,):
            raise ArgumentError("obstacles", obstacle, f"{accepted} on this {dimension}-dimensional robot")
    centers = np.array([obstacle.center for obstacle in chosen]).reshape(-1, dimension)
    return centers, np.array([obstacle.radius for obstacle in chosen])

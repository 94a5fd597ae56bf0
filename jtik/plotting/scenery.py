"""Obstacles, paths and the base of an arm, drawn on axes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import finite_array, instances, positive_number
from jtik.errors import ArgumentError
from jtik.geometry import Ball, Box, Capsule, HalfSpace, Obstacle, Polygon
from jtik.plotting.figure import Axes
from jtik.plotting.style import BACKGROUND, INK, LINK_WIDTH, OBSTACLE_EDGE, OBSTACLE_FACE
from jtik.types import Array

PLANAR = "points, circles, capsules, boxes, half-spaces and polygons in the plane"
"""What can be drawn, for errors."""


def draw_obstacles(axes: Axes, obstacles: Iterable[Obstacle]) -> None:
    """Draw obstacles in the plane: points as crosses, half-spaces as far as the axes reach, all others filled.

    Args:
        axes: axes to draw on.
        obstacles: points, circles, capsules, boxes, half-spaces and polygons.

    Raises:
        ArgumentError: when an obstacle is not in the plane.
    """
    for obstacle in instances("obstacles", obstacles, Obstacle, PLANAR):
        if obstacle.dimension != 2:
            raise ArgumentError("obstacles", obstacle, PLANAR)
        if isinstance(obstacle, Ball) and obstacle.radius == 0:
            axes.plot(*obstacle.center, "x", color=OBSTACLE_EDGE, markersize=9, markeredgewidth=2, zorder=1)
        elif isinstance(obstacle, HalfSpace):
            _draw_half_space(axes, obstacle)
        else:
            axes.add_patch(_patch(obstacle))


def _patch(obstacle: Obstacle) -> Any:
    """A circle, or the outline of any other obstacle."""
    from matplotlib.patches import Circle
    from matplotlib.patches import Polygon as Outline

    style = {"facecolor": OBSTACLE_FACE, "edgecolor": OBSTACLE_EDGE, "linewidth": 1.2, "zorder": 1}
    if isinstance(obstacle, Ball):
        return Circle(tuple(obstacle.center), obstacle.radius, **style)
    return Outline(outline(obstacle), closed=True, **style)


def outline(obstacle: Obstacle) -> Array:
    """The corners around a capsule, a box or a polygon in the plane, (k, 2) [m].

    Raises:
        ArgumentError: for anything else.
    """
    if isinstance(obstacle, Polygon):
        return obstacle.vertices
    if isinstance(obstacle, Box) and obstacle.dimension == 2:
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * obstacle.half
        return np.asarray(corners @ obstacle.pose[:2, :2].T + obstacle.center)
    if isinstance(obstacle, Capsule) and obstacle.dimension == 2:
        along = obstacle.end - obstacle.start
        half_turn = np.linspace(-np.pi / 2, np.pi / 2, 33)
        direction = np.arctan2(along[1], along[0])
        ends = [(obstacle.end, direction + half_turn), (obstacle.start, direction + np.pi + half_turn)]
        arcs = [end + obstacle.radius * np.stack([np.cos(a), np.sin(a)], axis=1) for end, a in ends]
        return np.concatenate(arcs)
    raise ArgumentError("obstacle", obstacle, "a capsule, box or polygon in the plane")


def _draw_half_space(axes: Axes, obstacle: HalfSpace) -> None:
    """Fill the part of a half-space that the axes show now; the view stays as it is."""
    from matplotlib.patches import Polygon as Outline

    view = (*axes.get_xlim(), *axes.get_ylim())
    reach = 2 * float(np.hypot(view[1] - view[0], view[3] - view[2])) + float(
        np.linalg.norm(obstacle.point - [(view[0] + view[1]) / 2, (view[2] + view[3]) / 2])
    )
    along = reach * np.array([-obstacle.normal[1], obstacle.normal[0]])
    below = reach * obstacle.normal
    corners = [obstacle.point + each for each in (along, -along, -along - below, along - below)]
    style = {"facecolor": OBSTACLE_FACE, "edgecolor": OBSTACLE_EDGE, "linewidth": 1.2, "zorder": 1}
    axes.add_artist(Outline(corners, closed=True, clip_on=True, **style))
    axes.set_xlim(*view[:2])
    axes.set_ylim(*view[2:])


def draw_path(axes: Axes, points: ArrayLike, **style: Any) -> Any:
    """Draw a path as a thin dashed line.

    Args:
        axes: axes to draw on.
        points: positions (k, 2) [m].
        style: matplotlib's line properties.

    Returns:
        The line.

    Raises:
        ArgumentError: when the points are not (k, 2) and finite.
    """
    x, y = finite_array("points", points, (None, 2)).T
    return axes.plot(x, y, **{"color": INK, "linewidth": 1.1, "linestyle": (0, (5, 3)), "zorder": 2, **style})[0]


def draw_base(axes: Axes, position: ArrayLike = (0.0, 0.0), size: float = LINK_WIDTH) -> None:
    """Draw the base of an arm as a ring.

    Args:
        axes: axes to draw on.
        position: its centre (2,) [m].
        size: a third of its diameter [m].

    Raises:
        ArgumentError: when the position is not (2,) and finite, or the size is not positive.
    """
    from matplotlib.patches import Circle

    (x, y), size = finite_array("position", position, (2,)), positive_number("size", size)
    axes.add_patch(Circle((x, y), 1.5 * size, facecolor=INK, edgecolor=BACKGROUND, linewidth=1.5, zorder=5))
    axes.add_patch(Circle((x, y), 0.45 * size, facecolor=BACKGROUND, zorder=5.1))

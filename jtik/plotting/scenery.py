"""Obstacles, paths and the base of an arm, drawn on axes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from numpy.typing import ArrayLike

from jtik.arguments import finite_array, instances, positive_number
from jtik.errors import ArgumentError
from jtik.geometry import Obstacle
from jtik.plotting.figure import Axes
from jtik.plotting.style import BACKGROUND, INK, LINK_WIDTH, OBSTACLE_EDGE, OBSTACLE_FACE


def draw_obstacles(axes: Axes, obstacles: Iterable[Obstacle]) -> None:
    """Draw circles as discs and points as crosses.

    Args:
        axes: axes to draw on.
        obstacles: points and circles.

    Raises:
        ArgumentError: when an obstacle is not in the plane.
    """
    from matplotlib.patches import Circle

    for obstacle in instances("obstacles", obstacles, Obstacle, "points and circles with center (2,)"):
        if obstacle.center.shape != (2,):
            raise ArgumentError("obstacles", obstacle, "points and circles with center (2,)")
        if obstacle.radius > 0:
            style = {"facecolor": OBSTACLE_FACE, "edgecolor": OBSTACLE_EDGE, "linewidth": 1.2, "zorder": 1}
            axes.add_patch(Circle(tuple(obstacle.center), obstacle.radius, **style))
        else:
            axes.plot(*obstacle.center, "x", color=OBSTACLE_EDGE, markersize=9, markeredgewidth=2, zorder=1)


def draw_path(axes: Axes, points: ArrayLike, **style: Any) -> Any:
    """Draw a path as a thin dashed line.

    Args:
        axes: axes to draw on.
        points: positions (k, 2) [m].
        style: matplotlib's line properties.

    Returns:
        The line.
    """
    x, y = finite_array("points", points, (None, 2)).T
    return axes.plot(x, y, **{"color": INK, "linewidth": 1.1, "linestyle": (0, (5, 3)), "zorder": 2, **style})[0]


def draw_base(axes: Axes, position: ArrayLike = (0.0, 0.0), size: float = LINK_WIDTH) -> None:
    """Draw the base of an arm as a ring.

    Args:
        axes: axes to draw on.
        position: its centre (2,) [m].
        size: a third of its diameter [m].
    """
    from matplotlib.patches import Circle

    (x, y), size = finite_array("position", position, (2,)), positive_number("size", size)
    axes.add_patch(Circle((x, y), 1.5 * size, facecolor=INK, edgecolor=BACKGROUND, linewidth=1.5, zorder=5))
    axes.add_patch(Circle((x, y), 0.45 * size, facecolor=BACKGROUND, zorder=5.1))

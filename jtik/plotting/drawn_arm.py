"""An arm drawn on axes: links, joints, and a posture that can be changed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from numpy.typing import ArrayLike

from jtik.arguments import finite_array, positive_number
from jtik.constructors import Constructed
from jtik.errors import ArgumentError
from jtik.plotting.figure import Axes, points_per_metre
from jtik.plotting.skeleton import Skeleton
from jtik.plotting.style import BACKGROUND, COLORMAP, INK, LINK_WIDTH, shades
from jtik.robot import Robot


class DrawnArm(metaclass=Constructed):
    """An arm on axes: rounded links and joints. ``move`` changes its configuration.

    Args:
        axes: axes to draw on, whose limits are set.
        robot: a planar robot, or its Skeleton.
        color: colour of the links.
        width: width of a link [m].
        joints: whether to mark the joints.
        zorder: matplotlib's drawing order.
        halo: whether to draw a light outline, which separates the arm from what is below it.

    Raises:
        ArgumentError: when the robot is not planar.
    """

    def __init__(
        self,
        axes: Axes,
        robot: Robot | Skeleton,
        *,
        color: Any = INK,
        width: float = LINK_WIDTH,
        joints: bool = True,
        zorder: float = 3.0,
        halo: bool = True,
    ) -> None:
        from matplotlib.collections import LineCollection

        self._skeleton = robot if isinstance(robot, Skeleton) else Skeleton(robot)
        if self._skeleton.robot.dimension != 2:
            raise ArgumentError("robot", self._skeleton.robot, "a planar robot")
        thick = positive_number("width", width) * points_per_metre(axes)
        outline = [(BACKGROUND, thick + 1.8)] if halo else []
        self._links = [
            axes.add_collection(
                LineCollection([], colors=[tint], linewidths=points, capstyle="round", zorder=zorder),
                autolim=False,
            )
            for tint, points in [*outline, (color, thick)]
        ]
        marks = {"marker": "o", "linestyle": "none", "markeredgewidth": 0, "zorder": zorder}
        self._joints = axes.plot([], [], color=BACKGROUND, markersize=0.42 * thick, **marks)[0] if joints else None

    def move(self, q: ArrayLike) -> DrawnArm:
        """Draw the arm at a configuration.

        Args:
            q: configuration (nq,) [rad] or [m].

        Raises:
            ArgumentError: when ``q`` has another shape or is not finite.
        """
        links = self._skeleton.links(finite_array("q", q, (self._skeleton.robot.nq,)))
        for collection in self._links:
            collection.set_segments(links)
        if self._joints is not None:
            self._joints.set_data(*links[:, 0].T)
        return self

    def recolor(self, colors: Sequence[Any]) -> None:
        """Change the colours of the links: one for each.

        Args:
            colors: one colour for each link, in any form that matplotlib accepts.
        """
        self._links[-1].set_color(colors)


def draw_postures(
    axes: Axes,
    robot: Robot | Skeleton,
    configurations: ArrayLike,
    *,
    colormap: str = COLORMAP,
    width: float = LINK_WIDTH,
) -> list[DrawnArm]:
    """Draw several configurations, from light (first) to dark (last).

    Args:
        axes: axes to draw on, whose limits are set.
        robot: a planar robot, or its Skeleton.
        configurations: (k, nq).
        colormap: name of a matplotlib colour map.
        width: width of a link [m].

    Returns:
        The drawn arms, in the order of the configurations.

    Raises:
        ArgumentError: when the robot is not planar, or the configurations have another shape.
    """
    skeleton = robot if isinstance(robot, Skeleton) else Skeleton(robot)
    table = finite_array("configurations", configurations, (None, skeleton.robot.nq))
    return [
        DrawnArm(axes, skeleton, color=color, width=width, zorder=3 + k / (len(table) + 1)).move(q)
        for k, (q, color) in enumerate(zip(table, shades(len(table), colormap), strict=True))
    ]

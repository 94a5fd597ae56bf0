"""Drawing of a planar or spatial robot with the obstacles of a case and the path of the end effector."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from jtik.geometry import Solid
from jtik.plotting import (
    INK,
    LINK_WIDTH,
    SINGLE,
    Axes,
    Skeleton,
    Window,
    draw_base,
    draw_obstacles,
    draw_path,
    draw_postures,
    label_axes,
    shades,
    window_around,
)
from jtik.plotting.body import Body
from jtik.plotting.postures import MOST, path_of, spaced
from jtik.plotting.spatial import VIEW, SpatialScene
from jtik.robot import Robot
from jtik.types import Array


class RobotDrawing:
    """Draws a robot on axes that are large enough for given configurations.

    Args:
        robot: a planar or spatial robot.
        configurations: all configurations to draw, (k, nq) each.
        obstacles: obstacles to draw.
    """

    def __init__(self, robot: Robot, configurations: Sequence[Array], obstacles: Sequence[Solid] = ()) -> None:
        self.robot, self.obstacles = robot, tuple(obstacles)
        self.is_planar = robot.dimension == 2
        self._skeleton = Skeleton(robot)
        some = np.concatenate([spaced(q, 40) for q in configurations])
        points = self._skeleton.links(some).reshape(-1, robot.dimension)
        self.window: Window | None = window_around(points, self.obstacles) if self.is_planar else None
        self._bodies = None if self.is_planar else (Body(robot, "shapes"), Body(robot, "links"))
        self._all = [] if self._bodies is None else [each for q in some for each in self._bodies[1].surfaces(q)]

    @property
    def projection(self) -> dict[str, Any]:
        """Options for creating the axes."""
        return {} if self.is_planar else {"subplot_kw": {"projection": "3d", "elev": VIEW[0], "azim": VIEW[1]}}

    def draw(self, axes: Axes, q: Array, title: str = "", *, path: Array | None = None) -> None:
        """Draw configurations (k, nq) from light to dark, and the end-effector path of ``path`` (of q by default)."""
        line = path_of(self.robot, q if path is None else path)
        if self.is_planar:
            self._draw_planar(axes, q, line)
        else:
            self._draw_spatial(axes, q, line)
        axes.set_title(title, color=INK, fontsize=10.5, loc="left")

    def _draw_planar(self, axes: Axes, q: Array, line: Array) -> None:
        assert self.window is not None
        left, right, bottom, top = self.window
        axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
        axes.grid(False)
        axes.set_axisbelow("line")  # the numbers are within the frame, above a half-space
        label_axes(axes, 8.0)
        draw_obstacles(axes, self.obstacles)
        size = min(LINK_WIDTH, 0.012 * (right - left))
        draw_path(axes, line, linewidth=0.9)
        draw_postures(axes, self._skeleton, spaced(q, MOST[2]), width=size)
        draw_base(axes, self._skeleton.links(q[0])[0, 0], size)

    def _draw_spatial(self, axes: Axes, q: Array, line: Array) -> None:
        assert self._bodies is not None
        some = spaced(q, MOST[3])
        body, colors = (self._bodies[0], [SINGLE]) if len(some) == 1 else (self._bodies[1], shades(len(some)))
        scene = SpatialScene(axes, 7.0)
        scene.line(line, linewidth=0.9)
        scene.include(self._all)
        scene.fix(self.obstacles, self._all)
        scene.show([(body.surfaces(each), color) for each, color in zip(some, colors, strict=True)])
        scene.frame()

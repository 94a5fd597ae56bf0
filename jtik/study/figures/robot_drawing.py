"""Drawing of a planar or spatial robot with the obstacles of a case and the path of the end effector."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from jtik.geometry import Ball
from jtik.plotting.planar import (
    INK,
    LINK_WIDTH,
    MUTED,
    OBSTACLE_FACE,
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
from jtik.problems import Case, obstacles_of
from jtik.robot import Robot
from jtik.types import Array

MAX_POSTURES = 12
"""Maximum number of configurations drawn from a sequence, evenly spaced."""


def obstacles_in(case: Case) -> tuple[Ball, ...]:
    """The circles or spheres of a case; empty if it has none."""
    owners = [name.rsplit(".", 1)[0] for name in case.parameters if name.endswith(".centers")]
    for owner in owners:
        if f"{owner}.radii" in case.parameters:
            return obstacles_of(case, owner)
    return ()


def thinned(q: Array, max_count: int = MAX_POSTURES) -> Array:
    """Evenly spaced configurations of a sequence, including the first and the last."""
    places = np.unique(np.round(np.linspace(0, len(q) - 1, min(max_count, len(q)))).astype(int))
    chosen: Array = q[places]
    return chosen


class RobotDrawing:
    """Draws a robot on axes that are large enough for given configurations.

    Args:
        robot: a planar or spatial robot.
        configurations: all configurations to draw, (k, nq) each.
        obstacles: circles or spheres to draw.
    """

    def __init__(self, robot: Robot, configurations: Sequence[Array], obstacles: Sequence[Ball] = ()) -> None:
        self.robot, self.skeleton, self.obstacles = robot, Skeleton(robot), tuple(obstacles)
        points = np.concatenate([self.skeleton.links(q).reshape(-1, robot.dimension) for q in configurations])
        self._points = points
        self.is_planar = robot.dimension == 2
        self.window: Window | None = window_around(points, self.obstacles) if self.is_planar else None

    @property
    def projection(self) -> dict[str, Any]:
        """Options for creating the axes."""
        return {} if self.is_planar else {"subplot_kw": {"projection": "3d"}}

    def draw(self, axes: Axes, q: Array, title: str = "", *, path: Array | None = None) -> None:
        """Draw configurations (k, nq) from light to dark, and the end-effector path of ``path`` (of q by default)."""
        line = self._tip(q if path is None else path)
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
        label_axes(axes, 8.0)
        draw_obstacles(axes, self.obstacles)
        size = min(LINK_WIDTH, 0.012 * (right - left))
        draw_path(axes, line, linewidth=0.9)
        draw_postures(axes, self.skeleton, thinned(q), width=size)
        draw_base(axes, self.skeleton.links(q[0])[0, 0], size)

    def _draw_spatial(self, axes: Axes, q: Array, line: Array) -> None:
        some = thinned(q, 6)
        for configuration, color in zip(some, shades(len(some)), strict=True):
            for start, end in self.skeleton.links(configuration):
                axes.plot(*np.array([start, end]).T, color=color, linewidth=2.6, solid_capstyle="round")
        axes.plot(*line.T, color=INK, linewidth=0.9, linestyle=(0, (5, 3)))
        for ball in self.obstacles:
            turn, lift = np.meshgrid(np.linspace(0, 2 * np.pi, 17), np.linspace(0, np.pi, 9))
            shell = np.array([np.cos(turn) * np.sin(lift), np.sin(turn) * np.sin(lift), np.cos(lift)])
            x, y, z = ball.center[:, None, None] + ball.radius * shell
            axes.plot_surface(x, y, z, color=OBSTACLE_FACE, alpha=0.6, linewidth=0)
        middle = (self._points.min(axis=0) + self._points.max(axis=0)) / 2
        half = float(np.ptp(self._points, axis=0).max()) / 2
        axes.set(**{f"{name}lim": (at - half, at + half) for name, at in zip("xyz", middle, strict=True)})
        for name in "xyz":
            getattr(axes, f"set_{name}label")(f"{name} [m]", color=MUTED, fontsize=8)
        axes.tick_params(labelsize=7, labelcolor=MUTED)
        axes.set_box_aspect((1, 1, 1))

    def _tip(self, q: Array) -> Array:
        return np.asarray(self.skeleton.links(q))[:, -1, 1]

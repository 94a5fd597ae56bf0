"""A figure of one posture or several, with obstacles and a path."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import array_of, finite_array, instances
from jtik.errors import ArgumentError
from jtik.geometry import Obstacle
from jtik.plotting.drawn_arm import draw_postures
from jtik.plotting.figure import Figure, Window, blank_figure, label_axes, window_around
from jtik.plotting.scenery import draw_obstacles, draw_path
from jtik.plotting.skeleton import Skeleton
from jtik.robot import Robot


def posture_figure(
    robot: Robot,
    configurations: ArrayLike,
    *,
    obstacles: Iterable[Obstacle] = (),
    path: ArrayLike | None = None,
    window: Window | None = None,
    width: float = 12.0,
) -> Figure:
    """A figure of one configuration, or of several from light (first) to dark (last).

    Args:
        robot: a planar robot.
        configurations: (nq,) or (k, nq), such as the ``q`` of a Solution or of a Trajectory.
        obstacles: points and circles.
        path: positions (k, 2) [m] to draw as a line.
        window: (left, right, bottom, top) [m]; by default one that shows everything.
        width: width of the figure [inch].

    Raises:
        ArgumentError: when the robot is not planar or an argument has another shape.
        MissingExtraError: when matplotlib is not installed.
    """
    skeleton, discs = Skeleton(robot), instances("obstacles", obstacles, Obstacle, "points and circles")
    if robot.dimension != 2:
        raise ArgumentError("robot", robot, "a planar robot")
    shapes = [(robot.nq,), (None, robot.nq)]
    table = array_of("configurations", configurations, shapes, f"shape ({robot.nq},) or (any, {robot.nq})")
    links = skeleton.links(table).reshape(-1, 2)
    seen = links if path is None else np.concatenate([links, finite_array("path", path, (None, 2))])
    figure, axes = blank_figure(window_around(seen, discs) if window is None else window, width)
    label_axes(axes)
    draw_obstacles(axes, discs)
    if path is not None:
        draw_path(axes, path)
    draw_postures(axes, skeleton, np.atleast_2d(table))
    return figure

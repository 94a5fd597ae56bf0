"""A figure of one posture or several, with obstacles and a path: of planar robots from above, of others in space."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import array_of, choice, finite_array, instance, positive_number, shape_of
from jtik.errors import ArgumentError
from jtik.geometry import Scene, Solid
from jtik.plotting.body import Body
from jtik.plotting.drawn_arm import draw_postures
from jtik.plotting.figure import Figure, Window, blank_figure, label_axes, window_around
from jtik.plotting.obstacles_in import shown_obstacles
from jtik.plotting.scenery import draw_base, draw_obstacles, draw_path
from jtik.plotting.skeleton import Skeleton
from jtik.plotting.spatial import VIEW, SpatialScene, spatial_figure
from jtik.plotting.style import LINK_WIDTH, SINGLE, shades
from jtik.result import Solution, Trajectory
from jtik.robot import Robot
from jtik.types import Array

SHOWS = ("shapes", "links")
"""What can be drawn of a spatial robot: its solids, or rounded links between its joints."""

MOST = {2: 12, 3: 6}
"""How many postures of a trajectory are drawn, by the dimension of the robot."""

LINK_SHARE = 0.012
"""Largest width of a link, as a share of the window's larger side."""


def posture_figure(
    robot: Robot,
    configurations: ArrayLike | Solution | Trajectory,
    *,
    obstacles: Iterable[Solid] | Scene = (),
    path: ArrayLike | None = None,
    window: Window | None = None,
    width: float | None = None,
    view: tuple[float, float] = VIEW,
    show: str | None = None,
) -> Figure:
    """A figure of one configuration, or of several from light (first) to dark (last).

    Args:
        robot: the robot.
        configurations: (nq,), (k, nq), a Solution, or a Trajectory, of which evenly spaced postures are drawn with the
            path of the end effector.
        obstacles: the obstacles, or a `Scene`.
        path: positions (k, 2) or (k, 3) [m] to draw as a line.
        window: (left, right, bottom, top) [m] of a planar robot; by default one that shows everything.
        width: width of the figure [inch]; 12 for a planar robot, 6 for a spatial one by default.
        view: elevation and azimuth from which a spatial robot is seen [degrees].
        show: "shapes" or "links" of a spatial robot: its solids, or rounded links between its joints. By default the
            solids of a single posture, and the links of several.

    Raises:
        ArgumentError: when an argument has another shape, or an obstacle is not in the robot's space.
        MissingExtraError: when matplotlib is not installed.

    Example::

        arm = jtik.Robot.builtin("panda")
        figure = jtik.plotting.posture_figure(arm, arm.home, obstacles=[jtik.Sphere((0.5, 0.2, 0.4), 0.1)])
        figure.savefig("panda.pdf")
    """
    instance("robot", robot, Robot, "a jtik.Robot")
    whole = configurations_of(robot, configurations)
    table = spaced(whole, MOST[robot.dimension]) if isinstance(configurations, Trajectory) else whole
    line = None if path is None else finite_array("path", path, (None, robot.dimension))
    if path is None and isinstance(configurations, Trajectory):
        line = path_of(robot, whole)
    discs = shown_obstacles(obstacles)
    shown = choice("show", default_show(len(table)) if show is None else show, SHOWS)
    view = read_view(view)
    if robot.dimension == 2:
        return _planar(robot, table, discs, line, window, 12.0 if width is None else width)
    if window is not None:
        raise ArgumentError("window", window, "None for a spatial robot: the figure shows everything")
    body = Body(robot, shown)
    colors = [SINGLE] if len(table) == 1 else shades(len(table))

    def draw(scene: SpatialScene) -> None:
        bodies = [(body.surfaces(q), color) for q, color in zip(table, colors, strict=True)]
        if line is not None:
            scene.line(line)
        scene.fix(discs, [each for own, _ in bodies for each in own])
        scene.show(bodies)

    return spatial_figure(view, positive_number("width", 6.0 if width is None else width), draw)


def _planar(
    robot: Robot, table: Array, discs: tuple[Any, ...], line: Array | None, window: Window | None, width: float
) -> Figure:
    skeleton = Skeleton(robot)
    links = skeleton.links(table).reshape(-1, 2)
    seen = links if line is None else np.concatenate([links, line])
    figure, axes = blank_figure(window_around(seen, discs) if window is None else window, width)
    label_axes(axes)
    draw_obstacles(axes, discs)
    if line is not None:
        draw_path(axes, line)
    draw_postures(axes, skeleton, table, width=link_width(axes))
    draw_base(axes, skeleton.links(table[0])[0, 0], link_width(axes))
    return figure


def link_width(axes: Any) -> float:
    """Width of a link on axes [m]: no wider than a share of what they show."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    return float(min(LINK_WIDTH, LINK_SHARE * max(right - left, top - bottom)))


def configurations_of(robot: Robot, given: Any, argument: str = "configurations") -> Array:
    """The configurations (k, nq) of what `posture_figure` accepts; a Trajectory begins with its start.

    Args:
        robot: the robot.
        given: a configuration, several, a Solution or a Trajectory.
        argument: name of the argument, for errors.

    Raises:
        ArgumentError: when it is nothing of these, of another shape, or not finite.
    """
    if isinstance(given, Trajectory):
        rows = given.q if np.isnan(given.start).any() else np.concatenate([given.start[None], given.q])
        given = rows
    elif isinstance(given, Solution):
        given = given.q
    if isinstance(given, Mapping) or len(shape_of(given) or ()) == 1:
        return np.atleast_2d(robot.configuration(given, argument=argument))
    accepted = f"shape ({robot.nq},) or (any, {robot.nq})"
    return np.atleast_2d(array_of(argument, given, [(robot.nq,), (None, robot.nq)], accepted))


def path_of(robot: Robot, table: Array) -> Array:
    """Positions (k, dimension) [m] of the end effector at configurations (k, nq)."""
    return np.array([robot.position(q) for q in table])


def spaced(table: Array, most: int) -> Array:
    """Evenly spaced rows, the first and the last among them."""
    places = np.unique(np.round(np.linspace(0, len(table) - 1, min(most, len(table)))).astype(int))
    return np.asarray(table[places])


def default_show(count: int) -> str:
    """What is drawn of a robot in so many postures."""
    return "shapes" if count == 1 else "links"


def read_view(view: Any) -> tuple[float, float]:
    """Elevation and azimuth [degrees]."""
    elevation, azimuth = finite_array("view", view, (2,), "elevation and azimuth [degrees]").tolist()
    return elevation, azimuth

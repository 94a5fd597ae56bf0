"""Figures and animations of a Trajectory: joints by time, and the robot on its way."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import choice, instance, positive_number
from jtik.arguments import path as read_path
from jtik.errors import ArgumentError
from jtik.geometry import Scene, Solid
from jtik.plotting.animation import write_animation
from jtik.plotting.body import Body
from jtik.plotting.curves import decimal_axes, panels_above_each_other
from jtik.plotting.drawn_arm import DrawnArm
from jtik.plotting.figure import Figure, blank_figure, label_axes, window_around
from jtik.plotting.obstacles_in import shown_obstacles
from jtik.plotting.postures import SHOWS, configurations_of, link_width, path_of, read_view
from jtik.plotting.scenery import draw_base, draw_obstacles, draw_path
from jtik.plotting.skeleton import Skeleton
from jtik.plotting.spatial import VIEW, SpatialScene, spatial_figure
from jtik.plotting.style import INK, MUTED, SINGLE, line_colors
from jtik.result import Trajectory
from jtik.robot import Robot
from jtik.types import Array

MOST_NAMES = 24
"""How many names a column of the legend has."""

MOST_FRAMES = 400
"""Largest number of frames of an animation."""


def trajectory_figure(trajectory: Trajectory, *, width: float = 6.0) -> Figure:
    """Joint positions, velocities and the task error of a trajectory by time.

    Crosses mark the targets that were not reached.

    Args:
        trajectory: the trajectory, of at least one row.
        width: width of the figure [inch].

    Raises:
        ArgumentError: for a trajectory without a row.
        MissingExtraError: when matplotlib is not installed.
    """
    instance("trajectory", trajectory, Trajectory, "a jtik.Trajectory")
    if not len(trajectory):
        raise ArgumentError("trajectory", trajectory, "a trajectory of at least one row")
    figure, (positions, speeds, errors) = panels_above_each_other(3, positive_number("width", width), "time [s]")
    times, q = trajectory.times, trajectory.q
    if not np.isnan(trajectory.start).any():
        times, q = np.concatenate([[0.0], times]), np.concatenate([trajectory.start[None], q])
    names = columns_of(trajectory)
    for k, (name, color) in enumerate(zip(names, line_colors(len(names)), strict=True)):
        positions.plot(times, q[:, k], color=color, linewidth=1.3, label=name)
    for k, color in enumerate(line_colors(trajectory.dq.shape[1])):
        speeds.step(trajectory.times, trajectory.dq[:, k], where="pre", color=color, linewidth=1.1)
    error = np.maximum(trajectory.error_norm, 1e-17)
    errors.plot(trajectory.times, error, color=INK, linewidth=1.2)
    missed = ~trajectory.reached
    errors.plot(trajectory.times[missed], error[missed], "x", color="#d55e00", markersize=5, label="not reached")
    errors.set_yscale("log")
    decimal_axes(errors)
    labels = ("joint position\n[rad, m]", "joint velocity\n[rad/s, m/s]", "task error\n[m, rad]")
    for axes, label in zip((positions, speeds, errors), labels, strict=True):
        axes.set_ylabel(label, color=INK, fontsize=9)
        axes.set_xlim(0.0, float(times[-1]))
    handles = positions.get_legend_handles_labels()[0] + (errors.get_legend_handles_labels()[0] if missed.any() else [])
    columns = -(-len(handles) // MOST_NAMES)
    figure.legend(
        handles=handles, loc="outside right upper", frameon=False, fontsize=8, labelcolor=MUTED, ncols=columns
    )
    return figure


def columns_of(trajectory: Trajectory) -> list[str]:
    """A name for each entry of q: that of its joint, with a number where the joint has several."""
    sizes = trajectory.joint_sizes or (1,) * len(trajectory.joint_names)
    if sum(sizes) != trajectory.q.shape[1]:
        return [f"q[{k}]" for k in range(trajectory.q.shape[1])]
    return [
        name if size == 1 else f"{name}[{k}]"
        for name, size in zip(trajectory.joint_names, sizes, strict=True)
        for k in range(size)
    ]


def write_motion(
    path: str | Path,
    robot: Robot,
    trajectory: Trajectory | ArrayLike,
    *,
    obstacles: Iterable[Solid] | Scene = (),
    speed: float = 1.0,
    rate: float = 20.0,
    width: float = 5.0,
    view: tuple[float, float] = VIEW,
    show: str = "shapes",
) -> None:
    """Write an animation of a robot on a trajectory as a GIF that repeats.

    Args:
        path: the file to write, which ends in ".gif".
        robot: the robot.
        trajectory: a Trajectory, or configurations (k, nq), which are shown at ``rate``.
        obstacles: the obstacles, or a `Scene`.
        speed: seconds of the trajectory for each second of the animation.
        rate: frames for each second [1/s], at most 50; of a long animation the rate is lower.
        width: width of the animation [inch]; an inch has 100 pixels.
        view: elevation and azimuth from which a spatial robot is seen [degrees].
        show: "shapes" for the solids of a spatial robot, "links" for rounded links between its joints.

    Raises:
        ArgumentError: for another suffix, or an argument that cannot be used.
        MissingExtraError: when matplotlib or pillow is not installed.
        OSError: when the file cannot be written.
    """
    file = read_path("path", path)
    if file.suffix.lower() != ".gif":
        raise ArgumentError("path", str(file), "a file that ends in .gif")
    instance("robot", robot, Robot, "a jtik.Robot")
    rate, speed = positive_number("rate", rate, "frames for each second, at most 50"), positive_number("speed", speed)
    if rate > 50:
        raise ArgumentError("rate", rate, "frames for each second, at most 50")
    table, pause = (
        configurations_of(robot, trajectory, "trajectory"),
        round(1 / rate, 2),
    )  # a GIF counts hundredths of a second
    if isinstance(trajectory, Trajectory):
        times = trajectory.times if len(table) == len(trajectory) else np.concatenate([[0.0], trajectory.times])
        seconds = float(times[-1] - times[0]) / speed
        pause = max(pause, math.ceil(100 * seconds / MOST_FRAMES) / 100)
        table = resampled(robot, table, times, 1 + max(1, round(seconds / pause)))
    frames = table[:: -(-len(table) // (MOST_FRAMES + 1))]
    discs = shown_obstacles(obstacles)
    line, width = path_of(robot, table), positive_number("width", width)
    view, show = read_view(view), choice("show", show, SHOWS)
    if robot.dimension == 2:
        figure, draw = _planar(robot, frames, discs, line, width)
    else:
        figure, draw = _spatial(Body(robot, show), frames, discs, line, width, view)
    write_animation(file, figure, draw, len(frames), seconds=pause)


def resampled(robot: Robot, table: Array, times: Array, count: int) -> Array:
    """Configurations (count, nq) at evenly spaced times, on straight lines in joint space between those given."""
    steps = [robot.difference(start, end) for start, end in pairwise(table)]
    frames = []
    for time in np.linspace(times[0], times[-1], count):
        k = int(np.clip(np.searchsorted(times, time, side="right") - 1, 0, len(steps) - 1))
        share = (time - times[k]) / (times[k + 1] - times[k])
        frames.append(robot.integrate(table[k], share * steps[k]))
    return np.array(frames)


def _planar(robot: Robot, frames: Array, discs: tuple[Any, ...], line: Array, width: float) -> Any:
    skeleton = Skeleton(robot)
    seen = np.concatenate([skeleton.links(frames).reshape(-1, 2), line])
    figure, axes = blank_figure(window_around(seen, discs), width)
    label_axes(axes, 9.0)
    draw_obstacles(axes, discs)
    draw_path(axes, line)
    draw_base(axes, skeleton.links(frames[0])[0, 0], link_width(axes))
    arm = DrawnArm(axes, skeleton, color=SINGLE, width=1.5 * link_width(axes))
    return figure, lambda k: arm.move(frames[k]) and None


def _spatial(
    body: Body, frames: Array, discs: tuple[Solid, ...], line: Array, width: float, view: tuple[float, float]
) -> Any:
    scenes: list[SpatialScene] = []

    def draw(scene: SpatialScene) -> None:
        scenes.append(scene)
        scene.line(line)
        several = [body.surfaces(q) for q in frames[:: max(1, len(frames) // 20)]]
        scene.fix(discs, [each for own in several for each in own])
        for own in several:  # all of them have room
            scene.show([(own, SINGLE)])

    figure = spatial_figure(view, width, draw)
    return figure, lambda k: scenes[0].show([(body.surfaces(frames[k]), SINGLE)])

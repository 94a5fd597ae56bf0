"""Commit to an attempt: time it for a controller, check it, and write it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from jtik.arguments import choice, instance, non_negative_number, positive_number
from jtik.arguments import path as read_path
from jtik.constraints import Limits
from jtik.constraints.limits import Bounds
from jtik.errors import ArgumentError
from jtik.geometry import Scene
from jtik.planner.attempts.attempt import Attempt
from jtik.planner.attempts.motion import read_attempt
from jtik.planner.commit.checks import Finding, check
from jtik.planner.commit.commands import FORMATS, JointCommands, export
from jtik.planner.commit.timing import smoothed, timed_path
from jtik.planner.commit.trajectories import animation, figure
from jtik.robot import Robot
from jtik.types import Array

__all__ = ["PICTURES", "Committed", "Finding", "as_recorded", "check", "commit", "timed"]

SPEED = 1.0
"""Largest speed of a joint that has no limit of its own [rad/s] or [m/s]."""

ACCELERATION = 2.0
"""Largest acceleration where none is given [rad/s^2] or [m/s^2]."""

PERIOD = 0.01
"""Time between two commands [s]."""

SMOOTHING = (0.02, 0.005, 0.0)
"""How far joints may be from the recorded path by default [rad] or [m]: the first of these that nears no obstacle."""

PICTURES = {"figure": ".png", "animation": ".gif"}
"""What `commit` writes besides files of joint commands, and how the names of these files end."""


@dataclass(frozen=True, eq=False)
class Committed:
    """What was written.

    Attributes:
        path: the file.
        commands: the joint commands.
        findings: what is wrong with them; none for good ones.
    """

    path: Path
    commands: JointCommands
    findings: tuple[Finding, ...]


def commit(
    attempt: Attempt,
    robot: Robot,
    path: str | Path,
    format: str,
    *,
    limits: Limits | None = None,
    scene: Scene | Mapping[str, Any] | None = None,
    safe: float = 0.0,
    bodies: str | None = None,
    period: float = PERIOD,
    smoothing: float | None = None,
    recorded: bool = False,
) -> Committed:
    """Time an attempt, check the commands, and write them, whatever the check finds: it returns the findings.

    Args:
        attempt: the attempt.
        robot: a robot of revolute and prismatic joints.
        path: the file to write.
        format: "csv", "json", "npz", "ros2_json" or "ros2_yaml", see `jtik.planner.commit.commands.export`; "figure"
            for a picture, whose kind follows from the suffix; "animation" for a GIF.
        limits: limits of the commands, see `timed`.
        scene: the obstacles, a `jtik.Scene` or its dict; by default those of the attempt when it ended.
        safe: smallest distance allowed of any body to any obstacle [m].
        bodies: what may not come close to obstacles; by default "shapes", else "links", else "joints".
        period: time between two commands [s].
        smoothing: how far a joint may be from the recorded path [rad] or [m], see `timed`. By default 0.02, without
            which a path that was guided by hand takes several times as long as it was recorded; where the smoothed path
            is nearer to an obstacle than ``safe``, 0.005, and at last the path as it was recorded.
        recorded: whether the times of the attempt are kept.

    Raises:
        ArgumentError: for an argument that cannot be used, or an attempt in which no joint moves.
        MissingExtraError: for a picture without matplotlib.
        OSError: when the file cannot be written.
    """
    format, file = choice("format", format, (*FORMATS, *PICTURES)), read_path("path", path)
    held = Limits() if limits is None else limits
    if not recorded:
        bounds, _ = _assumed(robot, limits)
        held = replace(held, velocity=bounds.velocity, acceleration=bounds.acceleration)
    shown = (attempt.scene_at(attempt.duration) or {}) if scene is None else scene
    for tolerance in SMOOTHING if smoothing is None and not recorded else (smoothing or 0.0,):
        commands = (
            as_recorded(attempt, robot)
            if recorded
            else timed(attempt, robot, limits=limits, period=period, smoothing=tolerance)
        )
        findings = check(commands, robot, limits=held, scene=shown, safe=safe, bodies=bodies)
        if all(each.kind != "clearance" for each in findings):
            break
    if format == "figure":
        figure(commands, robot, scene=shown).savefig(file)
    elif format == "animation":
        animation(file, commands, robot, scene=shown)
    else:
        export(commands, file, format)
    return Committed(file, commands, findings)


def timed(
    attempt: Attempt,
    robot: Robot,
    *,
    limits: Limits | None = None,
    period: float = PERIOD,
    smoothing: float = 0.0,
    method: str | None = None,
) -> JointCommands:
    """Joint commands that follow the path of an attempt as fast as the limits allow, from rest to rest.

    The path goes through the samples, without those that are less than a thousandth of a radian or metre away from the
    one before; no joint leaves the range between two samples, so that position limits hold where they hold at the
    samples. Limits of velocity and acceleration hold at all times (`jtik.planner.commit.timing`). Near obstacles
    `check` the result.

    Args:
        attempt: the attempt.
        robot: a robot of revolute and prismatic joints.
        limits: the limits; the robot's own velocities by default. Where the robot has none, 1 rad/s or 1 m/s is
            assumed, and where no acceleration is given, 2 rad/s^2 or 2 m/s^2; `JointCommands.note` says so.
        period: time between two commands [s].
        smoothing: how far a joint may be from the recorded path [rad] or [m]. Where a path was guided by hand, 0.02 rad
            can make it several times as fast.
        method: "toppra" or "trapezoid"; by default the faster of both, without the package toppra the second.

    Raises:
        ArgumentError: for a robot with ball or free joints, or an attempt in which no joint moves.
    """
    period, units = positive_number("period", period), _units(attempt, robot)
    bounds, notes = _assumed(robot, limits)
    tolerance = non_negative_number("smoothing", smoothing, "a non-negative angle or length [rad] or [m]")
    waypoints = smoothed(attempt.configurations, tolerance) if tolerance else attempt.configurations
    if tolerance:
        notes.append(f"the path is smoothed: a joint is at most {tolerance:g} rad or m away from where it was")
    path = timed_path(waypoints, bounds.velocity, bounds.acceleration, method=method)
    if path.method == "trapezoid" and method is None and not _has_toppra():
        notes.append("a trapezoid was used, which is slower than what toppra finds: pip install 'jtik[timing]'")
    count = math.ceil(path.duration / period)
    path = path.slower(count * period / path.duration)
    times: Array = np.arange(count + 1, dtype=np.float64) * period
    positions, velocities, accelerations = path.at(times)
    positions[-1], velocities[-1] = attempt.configurations[-1], 0.0
    return JointCommands(
        name=attempt.name,
        times=times,
        positions=positions,
        velocities=velocities,
        accelerations=accelerations,
        joint_names=robot.joint_names,
        units=units,
        method=path.method,
        note="; ".join(notes),
    )


def as_recorded(attempt: Attempt, robot: Robot) -> JointCommands:
    """Joint commands at the times of an attempt. Raises ArgumentError for a robot with ball or free joints."""
    units, q, times = _units(attempt, robot), attempt.configurations, attempt.times
    several = len(times) > 1
    velocities = np.gradient(q, times, axis=0) if several else np.zeros_like(q)
    return JointCommands(
        name=attempt.name,
        times=times,
        positions=q,
        velocities=velocities,
        accelerations=np.gradient(velocities, times, axis=0) if several else np.zeros_like(q),
        joint_names=robot.joint_names,
        units=units,
    )


def _units(attempt: Attempt, robot: Robot) -> tuple[str, ...]:
    """Unit of each joint. Raises ArgumentError where one has several numbers, or the attempt is of another robot."""
    read_attempt(attempt, robot)
    if len(robot.scalar_q) != robot.nq:
        given = f"{robot!r}, which has ball or free joints"
        raise ArgumentError("robot", given, "a robot of revolute and prismatic joints")
    return tuple("rad" if turns else "m" for turns in robot.rotational)


def _has_toppra() -> bool:
    try:
        import toppra  # noqa: F401
    except ImportError:
        return False
    return True


def _assumed(robot: Robot, limits: Limits | None) -> tuple[Bounds, list[str]]:
    """The limits, with what is assumed where there are none, and sentences that say so."""
    given = Limits() if limits is None else instance("limits", limits, Limits, "a jtik.Limits, or None")
    bounds, notes = given.of(robot), []
    velocity, acceleration = bounds.velocity.copy(), bounds.acceleration.copy()
    if given.velocity is True and not np.isfinite(velocity).all():
        notes.append(f"joints without a speed limit move at most at {SPEED:g} rad/s or m/s")
        velocity[~np.isfinite(velocity)] = SPEED
    if not np.isfinite(acceleration).all():
        notes.append(f"joints without an acceleration limit accelerate at most at {ACCELERATION:g} rad/s^2 or m/s^2")
        acceleration[~np.isfinite(acceleration)] = ACCELERATION
    return replace(bounds, velocity=velocity, acceleration=acceleration), notes

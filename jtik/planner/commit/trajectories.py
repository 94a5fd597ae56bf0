"""An attempt as a `jtik.Trajectory`, with its files and figures, and pictures of the motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from jtik.arguments import instance, positive_number
from jtik.geometry import Scene
from jtik.planner.attempts.attempt import Attempt
from jtik.planner.attempts.clearances import present
from jtik.planner.attempts.motion import Motion, placements, read_attempt
from jtik.planner.commit.commands import JointCommands
from jtik.plotting import Figure
from jtik.result import Status, Trajectory
from jtik.robot import Robot
from jtik.types import Array

REACHED = 1e-3
"""Distance up to which a target counts as reached [m]."""


def as_trajectory(attempt: Attempt, robot: Robot, *, frame: str | None = None) -> Trajectory:
    """An attempt as a `jtik.Trajectory`: its first sample is the start, every other one a row.

    A target counts as reached within a millimetre; one that is not has the status ITERATION_LIMIT, as the solver makes
    one step for each target. The errors are those of the position.

    Args:
        attempt: the attempt.
        robot: the robot of its configurations.
        frame: name of the end effector's frame; the tip when None.
    """
    q, rows = read_attempt(attempt, robot).configurations, len(attempt) - 1
    positions, _ = placements(robot, q, frame=frame, pose=False)
    error = np.linalg.norm(positions - attempt.targets[:, : robot.dimension], axis=1)[1:]
    return Trajectory(
        times=attempt.times[1:],
        start=q[0],
        q=q[1:],
        dq=Motion.of(robot, attempt.times, q).velocities,
        error_norm=error,
        position_error=error,
        orientation_error=np.full(rows, np.nan),
        status=tuple(Status.REACHED if each <= REACHED else Status.ITERATION_LIMIT for each in error.tolist()),
        iterations=np.ones(rows, dtype=np.int64),
        seconds=np.full(rows, np.nan),
        joint_names=robot.joint_names,
        joint_sizes=tuple(joint.type.nq for joint in robot.independent_joints),
    )


def figure(
    motion: Attempt | JointCommands, robot: Robot, *, scene: Scene | Mapping[str, Any] | None = None, **options: Any
) -> Figure:
    """A figure of evenly spaced postures, the path of the end effector and the obstacles.

    Args:
        motion: an attempt, or joint commands.
        robot: the robot.
        scene: the obstacles, a `jtik.Scene` or its dict; by default those of the attempt when it ended.
        options: those of `jtik.plotting.posture_figure`.

    Raises:
        MissingExtraError: when matplotlib is not installed.
    """
    from jtik.plotting.postures import MOST, path_of, posture_figure, spaced

    solids, q = _obstacles(motion, scene), motion.configurations
    postures, line = spaced(q, MOST[robot.dimension]), path_of(robot, q)
    return posture_figure(robot, postures, obstacles=solids, path=line, **options)


def animation(
    path: str | Path,
    motion: Attempt | JointCommands,
    robot: Robot,
    *,
    scene: Scene | Mapping[str, Any] | None = None,
    speed: float = 1.0,
    rate: float = 20.0,
    **options: Any,
) -> None:
    """Write an animation of the motion as a GIF.

    Args:
        path: the file to write, which ends in ".gif".
        motion: an attempt, or joint commands.
        robot: the robot.
        scene: the obstacles, a `jtik.Scene` or its dict; by default those of the attempt when it ended.
        speed: seconds of the motion for each second of the animation.
        rate: frames for each second [1/s], at most 50.
        options: those of `jtik.plotting.write_motion`.

    Raises:
        MissingExtraError: when matplotlib or pillow is not installed.
        OSError: when the file cannot be written.
    """
    from jtik.plotting.motion import MOST_FRAMES, resampled, write_motion

    speed, rate = positive_number("speed", speed), positive_number("rate", rate)
    solids, times, q = _obstacles(motion, scene), motion.times, motion.configurations
    seconds = float(times[-1]) / speed
    pause = max(round(100 / rate), math.ceil(100 * seconds / (MOST_FRAMES - 1)), 2) / 100  # a GIF counts hundredths
    count = 1 + round(seconds / pause)
    frames: Array = q[:1] if count < 2 or len(q) < 2 else resampled(robot, q, times, count)
    write_motion(path, robot, frames, obstacles=solids, rate=1 / pause, **options)


def _obstacles(motion: Attempt | JointCommands, scene: Scene | Mapping[str, Any] | None) -> tuple[Any, ...]:
    instance("motion", motion, (Attempt, JointCommands), "an Attempt, or JointCommands")
    if scene is None:
        scene = motion.scene_at(float(motion.times[-1])) if isinstance(motion, Attempt) else None
    return tuple(present(scene or {}).values())

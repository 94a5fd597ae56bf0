"""The target that a configuration meets exactly, which makes a drawn target reachable by construction."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from jtik.errors import ArgumentError
from jtik.robot import Robot
from jtik.task import AxisTask, CenterOfMassTask, LookAtTask, PlacementTask, RelativeFrameTask, Task
from jtik.types import Array

LOOK_DISTANCE = 1.0
"""Distance of the target of a `LookAtTask` from the frame [m]."""


def target_of(task: Task, robot: Robot, q: Array) -> Any:
    """The target of ``task`` that ``q`` (nq,) meets exactly, up to rounding.

    A task of your own is supported if it has a method ``target_at(robot, q)``.

    Raises:
        ArgumentError: for any other task.
    """
    own = getattr(task, "target_at", None)
    if callable(own):
        return own(robot, q)
    if isinstance(task, PlacementTask):
        pose = robot.pose(q, task.frame)
        if isinstance(task, RelativeFrameTask):
            pose = np.linalg.inv(robot.pose(q, task.reference)) @ pose
            pose[3] = 0, 0, 0, 1
        return _kept(pose, task.target_kind, robot.dimension)
    if isinstance(task, CenterOfMassTask):
        return robot.center_of_mass(q)
    if isinstance(task, (AxisTask, LookAtTask)):
        pose = robot.pose(q, task.frame)
        direction = pose[:3, :3] @ task.axis
        point = pose[:3, 3] + LOOK_DISTANCE * direction
        return (direction if isinstance(task, AxisTask) else point)[: robot.dimension]
    accepted = "a task of jtik, such as jtik.FrameTask, or a task with a method target_at(robot, q)"
    raise ArgumentError("task", task, accepted)


def _kept(pose: Array, kind: str, dimension: int) -> Any:
    """The part of a pose that a kind of placement task uses."""
    position = pose[:dimension, 3].copy()
    if kind == "position":
        return position
    if dimension == 3:
        return pose if kind == "pose" else pose[:3, :3].copy()
    angle = math.atan2(pose[1, 0], pose[0, 0])
    return angle if kind == "orientation" else np.array([*position, angle])

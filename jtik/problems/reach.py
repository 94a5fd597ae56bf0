"""Upper bound on the distance of a robot's frames from its first joint, valid at every configuration."""

from __future__ import annotations

import math

import numpy as np

from jtik.robot import JointType, Robot
from jtik.robot.stroke import stroke
from jtik.types import Array

UNBOUNDED_LENGTH = 1.0
"""Length counted for a prismatic joint without limits, or a free base, in the size of a robot [m]."""


def center(robot: Robot, frame: str) -> Array:
    """Position of the first joint that moves the frame, in the base frame, (dimension,) [m]."""
    pose = np.eye(4)
    for joint in robot.path(frame):
        pose = pose @ joint.origin
        if joint.is_moving:
            break
    return pose[: robot.dimension, 3].copy()


def bound(robot: Robot, frame: str) -> float:
    """Upper bound on the distance of the frame's origin from `center` [m].

    It is the sum of the lengths between the joints and of the strokes of prismatic joints (triangle inequality). It is
    infinite with a free base or an unlimited prismatic joint. It is attained if all links can lie on one line.
    """
    return sum(_lengths(robot, frame), 0.0)


def size(robot: Robot, frame: str) -> float:
    """Size of the robot [m]: `bound`, with `UNBOUNDED_LENGTH` for each length that has no bound."""
    return (
        sum((length if math.isfinite(length) else UNBOUNDED_LENGTH for length in _lengths(robot, frame)), 0.0)
        or UNBOUNDED_LENGTH
    )


def is_free_chain(robot: Robot, frame: str) -> bool:
    """Whether `bound` is the exact reach in every direction: a planar chain of revolute joints without limits."""
    moving = [joint for joint in robot.path(frame) if joint.is_moving]
    free = all(
        joint.type is JointType.REVOLUTE and joint.mimic is None and not math.isfinite(joint.upper - joint.lower)
        for joint in moving
    )
    # a joint with a single limit still reaches every direction
    return robot.dimension == 2 and free


def _lengths(robot: Robot, frame: str) -> list[float]:
    """Length that each moving joint on the path adds, including the fixed part after it [m]."""
    lengths: list[float] = []
    pose = np.eye(4)
    for joint in robot.path(frame):
        pose = pose @ joint.origin
        if joint.is_moving:
            lengths += [float(np.linalg.norm(pose[:3, 3])), float(stroke(robot, joint, robot.lower, robot.upper))]
            pose = np.eye(4)
    # nothing moves before the first joint
    return [*lengths[1:], float(np.linalg.norm(pose[:3, 3]))]

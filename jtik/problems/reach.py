"""How far a robot's frames can be from its first joint: a bound that holds at every configuration."""

from __future__ import annotations

import math

import numpy as np

from jtik.robot import Joint, JointType, Robot
from jtik.types import Array

VAST = 1.0
"""What a slide without limits, or a free base, counts as in the size of a robot [m]."""


def center(robot: Robot, frame: str) -> Array:
    """Where the first joint that moves the frame is, in the base frame [m], (dimension,)."""
    pose = np.eye(4)
    for joint in robot.path(frame):
        pose = pose @ joint.origin
        if joint.is_moving:
            break
    return pose[: robot.dimension, 3].copy()


def bound(robot: Robot, frame: str) -> float:
    """A distance [m] from `center` that the frame's origin cannot pass; infinite with a free base or endless slide.

    The sum of the lengths between the joints and of the strokes of slides (triangle inequality). It is reached where
    the joints let all links lie on one line.
    """
    return sum(_lengths(robot, frame), 0.0)


def size(robot: Robot, frame: str) -> float:
    """The size of the robot as seen from the frame [m]: `bound`, with `VAST` for what has no bound."""
    return sum((length if math.isfinite(length) else VAST for length in _lengths(robot, frame)), 0.0) or VAST


def is_free_chain(robot: Robot, frame: str) -> bool:
    """Whether `bound` is the reach, in every direction: a planar chain of hinges without limits."""
    moving = [joint for joint in robot.path(frame) if joint.is_moving]
    free = all(
        joint.type is JointType.REVOLUTE and joint.mimic is None and not math.isfinite(joint.upper - joint.lower)
        for joint in moving
    )
    # a joint with one limit has half a line of angles, which is every direction
    return robot.dimension == 2 and free


def _lengths(robot: Robot, frame: str) -> list[float]:
    """The length that each moving joint on the way adds, with what is fixed behind it [m]."""
    lengths: list[float] = []
    pose = np.eye(4)
    for joint in robot.path(frame):
        pose = pose @ joint.origin
        if joint.is_moving:
            lengths += [float(np.linalg.norm(pose[:3, 3])), _stroke(robot, joint)]
            pose = np.eye(4)
    # up to the first joint nothing moves
    return [*lengths[1:], float(np.linalg.norm(pose[:3, 3]))]


def _stroke(robot: Robot, joint: Joint) -> float:
    """How far a joint itself can carry its child [m]."""
    if joint.type is JointType.FREE:
        return math.inf
    if joint.type is not JointType.PRISMATIC:
        return 0.0
    place = robot.q_slice(joint.name)
    ends = np.array([robot.lower[place], robot.upper[place]]).ravel()
    if joint.mimic is not None:
        ends = joint.mimic.multiplier * ends + joint.mimic.offset
    return float(np.abs(ends).max())

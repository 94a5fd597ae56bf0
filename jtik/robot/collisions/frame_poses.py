"""Poses of frames at many configurations at once, in NumPy: for samples, where a compiled function is not worth it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from jtik.robot.joint_type import JointType
from jtik.robot.tree import Joint
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.robot.model import Robot


def frame_poses(robot: Robot, q: Array, frames: Iterable[str]) -> dict[str, Array]:
    """T_base_frame of frames at configurations (N, nq), (N, 4, 4) each; (1, 4, 4) of a frame that no joint moves."""
    found = {robot.base: np.eye(4)[None]}
    for frame in frames:
        for joint in robot.path(frame):
            if joint.child not in found:
                found[joint.child] = found[joint.parent] @ joint.origin @ _motion(robot, joint, q)
    return {frame: found[frame] for frame in frames}


def _motion(robot: Robot, joint: Joint, q: Array) -> Array:
    """The motion of a joint, (N, 4, 4), or (4, 4) of a fixed one."""
    if not joint.is_moving:
        return np.eye(4)
    position = q[:, robot.q_slice(joint.name)]
    if joint.mimic is not None:
        position = joint.mimic.multiplier * position + joint.mimic.offset
    motion = np.tile(np.eye(4), (len(q), 1, 1))
    if joint.type is JointType.PRISMATIC:
        motion[:, :3, 3] = position * joint.axis
    elif joint.type is JointType.REVOLUTE:
        half = position / 2
        motion[:, :3, :3] = _rotation(np.hstack([np.cos(half), np.sin(half) * joint.axis]))
    else:
        start = joint.type.quaternion_start
        assert start is not None
        motion[:, :3, :3] = _rotation(position[:, start:])
        motion[:, :start, 3] = position[:, :start]
    return motion


def _rotation(quaternion: Array) -> Array:
    """The rotations (N, 3, 3) of quaternions (N, 4) of any norm but zero."""
    unit = quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True)
    w, v = unit[:, 0, None, None], unit[:, 1:]
    skew = np.zeros((len(unit), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        skew[:, j, k], skew[:, k, j] = -v[:, i], v[:, i]
    rotation: Array = np.eye(3) + 2 * w * skew + 2 * skew @ skew
    return rotation

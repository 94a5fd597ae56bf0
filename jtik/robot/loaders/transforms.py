"""Transforms (4, 4) [m] as arrays, from positions and from quaternions (w, x, y, z) in MuJoCo's order."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from jtik.types import Array


def rotation_of(quaternion: Array) -> Array:
    """The rotation (3, 3) of a quaternion (4,) other than zero."""
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def pose_of(position: Array, quaternion: Array) -> Array:
    """The pose at ``position`` (3,) [m] with the rotation of ``quaternion`` (4,)."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation_of(quaternion), position
    return pose


def translation(offset: Array) -> Array:
    """The translation by ``offset`` (3,) [m]."""
    pose = np.eye(4)
    pose[:3, 3] = offset
    return pose


def rotation_about(axis: Array, angle: float) -> Array:
    """The rotation by ``angle`` [rad] about the unit vector ``axis`` (3,)."""
    return pose_of(np.zeros(3), np.array([math.cos(angle / 2), *(math.sin(angle / 2) * axis)]))


def rotation_of_angles(angles: Sequence[float]) -> Array:
    """The rotation (3, 3) by roll, pitch and yaw [rad] about the fixed axes x, then y, then z."""
    roll, pitch, yaw = (rotation_about(axis, angle) for axis, angle in zip(np.eye(3), angles, strict=True))
    rotation: Array = (yaw @ pitch @ roll)[:3, :3]
    return rotation

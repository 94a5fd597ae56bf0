"""Rotations as unit quaternions (w, x, y, z) in numbers, for targets and frames."""

from __future__ import annotations

import math

import numpy as np

from jtik.types import Array

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
"""No rotation."""
IDENTITY.flags.writeable = False


def product(a: Array, b: Array) -> Array:
    """The Hamilton product a b, normalised, (4,)."""
    (aw, ax, ay, az), (bw, bx, by, bz) = a.tolist(), b.tolist()
    found = np.array(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ]
    )
    return found / math.hypot(*found.tolist())


def turned(orientation: Array, vector: Array) -> Array:
    """The orientation (4,) after a rotation by the vector (3,) [rad] about the axes of the base."""
    angle = math.hypot(*vector.tolist())
    if angle == 0:
        return orientation
    return product(np.array([math.cos(angle / 2), *(vector * (math.sin(angle / 2) / angle)).tolist()]), orientation)


def angle(start: Array, end: Array) -> float:
    """The angle [rad] between two orientations, up to pi."""
    side = 1.0 if float(start @ end) >= 0 else -1.0
    return 4 * math.asin(min(1.0, float(np.linalg.norm(start - side * end)) / 2))


def slerp(start: Array, end: Array, share: float) -> Array:
    """The orientation at a share of the shortest rotation about one axis from start to end, (4,)."""
    whole = angle(start, end)
    side = 1.0 if float(start @ end) >= 0 else -1.0
    if whole < 1e-9:
        return side * end
    half = whole / 2
    found = (math.sin((1 - share) * half) * start + math.sin(share * half) * side * end) / math.sin(half)
    return found / math.hypot(*found.tolist())


def matrix(quaternion: Array) -> Array:
    """The rotation matrix of a unit quaternion, (3, 3)."""
    w, x, y, z = quaternion.tolist()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternions(matrices: Array) -> Array:
    """The unit quaternions (k, 4), w >= 0, of rotation matrices (k, 3, 3)."""
    xx, yy, zz = (matrices[:, i, i] for i in range(3))
    squares = np.stack([1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz], axis=1)
    low, high = matrices, matrices.transpose(0, 2, 1)
    wx, wy, wz = (low[:, i, j] - high[:, i, j] for i, j in ((2, 1), (0, 2), (1, 0)))
    xy, xz, yz = (low[:, i, j] + high[:, i, j] for i, j in ((0, 1), (0, 2), (1, 2)))
    # row i is the quaternion times four times its entry i; the largest entry divides best
    rows = np.stack(
        [
            np.stack([squares[:, 0], wx, wy, wz], axis=1),
            np.stack([wx, squares[:, 1], xy, xz], axis=1),
            np.stack([wy, xy, squares[:, 2], yz], axis=1),
            np.stack([wz, xz, yz, squares[:, 3]], axis=1),
        ],
        axis=1,
    )
    found = rows[np.arange(len(rows)), squares.argmax(axis=1)]
    found *= np.where(found[:, :1] < 0, -1.0, 1.0)
    normed: Array = found / np.linalg.norm(found, axis=1, keepdims=True)
    return normed

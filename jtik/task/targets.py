"""Targets of frame tasks as numbers: every form that a caller may give.

A position is a vector. A rotation is a matrix (3, 3), a quaternion (w, x, y, z), or an object whose ``as_matrix()``
gives a matrix (3, 3), such as those of SciPy and mink. A pose is a matrix (4, 4), seven numbers
(x, y, z, qw, qx, qy, qz), a pair (position, rotation), or an object whose ``as_matrix()`` gives a matrix (4, 4).
"""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np

from jtik.arguments import numeric_array
from jtik.errors import ArgumentError
from jtik.types import Array

Kind = Literal["position", "orientation", "pose"]

ROTATION_TOLERANCE = 1e-6
"""Tolerance on the orthonormality of a rotation and on the norm of a quaternion: the error of six printed digits."""

_FLOAT = np.dtype(np.float64)


def read_fast(target: Any, kind: Kind) -> Array | None:
    """The numbers of a valid float64 array (4, 4), (3, 3) or (3,) for a robot in space, in a few microseconds.

    Returns:
        3 numbers of a position, the 9 entries of R by columns of an orientation, or both of a pose. None for any other
        target, which `read_placement` reads or refuses.
    """
    if type(target) is not np.ndarray or target.dtype != _FLOAT:
        return None
    if target.shape == (4, 4):
        (xx, yx, zx, px), (xy, yy, zy, py), (xz, yz, zz, pz), (a, b, c, d) = target.tolist()
        if not (a == b == c == 0 and d == 1 and math.isfinite(px + py + pz)):
            return None
        if not is_rotation(xx, xy, xz, yx, yy, yz, zx, zy, zz):
            return None
        if kind == "pose":
            return np.array([px, py, pz, xx, xy, xz, yx, yy, yz, zx, zy, zz])
        return np.array([px, py, pz] if kind == "position" else [xx, xy, xz, yx, yy, yz, zx, zy, zz])
    if kind == "orientation" and target.shape == (3, 3):
        (xx, yx, zx), (xy, yy, zy), (xz, yz, zz) = target.tolist()
        if is_rotation(xx, xy, xz, yx, yy, yz, zx, zy, zz):
            return np.array([xx, xy, xz, yx, yy, yz, zx, zy, zz])
    elif kind == "position" and target.shape == (3,) and math.isfinite(sum(target.tolist())):
        return target.copy()
    return None


def is_rotation(
    xx: float, xy: float, xz: float, yx: float, yy: float, yz: float, zx: float, zy: float, zz: float
) -> bool:
    """Whether three columns x, y, z are orthonormal and right-handed; false for NaN."""
    return (
        abs(xx * xx + xy * xy + xz * xz - 1) <= ROTATION_TOLERANCE
        and abs(yx * yx + yy * yy + yz * yz - 1) <= ROTATION_TOLERANCE
        and abs(zx * zx + zy * zy + zz * zz - 1) <= ROTATION_TOLERANCE
        and abs(xx * yx + xy * yy + xz * yz) <= ROTATION_TOLERANCE
        and abs(yx * zx + yy * zy + yz * zz) <= ROTATION_TOLERANCE
        and abs(zx * xx + zy * xy + zz * xz) <= ROTATION_TOLERANCE
        and zx * (xy * yz - xz * yy) + zy * (xz * yx - xx * yz) + zz * (xx * yy - xy * yx) > 0
    )


def read_placement(target: Any, kind: Kind, dimension: int, accepted: str) -> Array:
    """A target in any of its forms as numbers.

    Args:
        target: the target as the caller passed it.
        kind: what the task uses; of a pose the other part is not used.
        dimension: 2 for a planar robot, else 3.
        accepted: what a target may be, for the error.

    Returns:
        The numbers of `read_fast`; those of (x, y), the angle, or (x, y, angle) on a planar robot.

    Raises:
        ArgumentError: for anything else.
    """
    given = target
    planar = dimension == 2
    if _has_matrix(target):
        target = target.as_matrix()
        numbers = None if planar else read_fast(target, kind)
        if numbers is not None:
            return numbers
    elif _is_pair(target):
        target = _from_pair(target[0], target[1], dimension, given, accepted)
    array = as_numbers(target, given, accepted)
    if array.shape == (7,):
        array = _from_pair(array[:3], array[3:], dimension, given, accepted)
    if kind == "orientation" and array.shape == (4,):
        array = from_quaternion(array, given)
    if array.shape == (4, 4):
        _check_pose(array, planar, given)
        return _numbers(array[:dimension, 3], array[:3, :3], kind, planar)
    if kind == "orientation" and array.shape == (3, 3):
        _check_rotation(array, planar, given)
        return _numbers(np.zeros(0), array, kind, planar)
    shapes: dict[Kind, list[tuple[int, ...]]] = {"position": [(dimension,)], "orientation": [(), (1,)], "pose": [(3,)]}
    if array.shape in shapes[kind] and (planar or kind == "position"):
        return array.reshape(-1)
    raise ArgumentError("target", given, accepted)


def unused_part(target: Any, kind: Kind) -> str | None:
    """The part of a valid target that a task of this kind does not use; None where it uses all of it."""
    if kind == "pose" or not _is_pose(target):
        return None
    return "orientation of the target" if kind == "position" else "position of the target"


def _is_pair(target: Any) -> bool:
    """Whether a target is a pair (position, rotation)."""
    if not isinstance(target, (tuple, list)) or len(target) != 2:
        return False
    return isinstance(target[0], (tuple, list, np.ndarray)) or _has_matrix(target[1])


def _has_matrix(target: Any) -> bool:
    """Whether a target is an object, not a class, with a method ``as_matrix``."""
    return hasattr(target, "as_matrix") and not isinstance(target, type)


def _is_pose(target: Any) -> bool:
    """Whether a valid target has both a position and an orientation."""
    if hasattr(target, "as_matrix"):
        target = target.as_matrix()
    return _is_pair(target) or np.shape(target) in ((4, 4), (7,))


def _numbers(position: Array, R: Array, kind: Kind, planar: bool) -> Array:
    """The numbers of the part of a pose that ``kind`` uses."""
    if kind == "position":
        return position
    orientation = np.array([np.arctan2(R[1, 0], R[0, 0])]) if planar else R.ravel(order="F")
    return orientation if kind == "orientation" else np.concatenate([position, orientation])


def as_numbers(target: Any, given: object, accepted: str) -> Array:
    """``target`` as a new float64 array. Raises ArgumentError, showing ``given``, unless it is finite numbers."""
    array = numeric_array(target)
    if array is None:
        raise ArgumentError("target", given, accepted)
    if not np.isfinite(array).all():
        raise ArgumentError("target", given, f"finite numbers: {accepted}")
    return array


def from_quaternion(quaternion: Array, given: object) -> Array:
    """The rotation (3, 3) of a quaternion (w, x, y, z), normalised. Raises ArgumentError if its norm is not 1."""
    norm = float(np.linalg.norm(quaternion))
    if abs(norm - 1) > ROTATION_TOLERANCE:
        raise ArgumentError("target", given, "a quaternion (w, x, y, z) of norm 1")
    w, x, y, z = (quaternion / norm).tolist()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _from_pair(position: Any, rotation: Any, dimension: int, given: object, accepted: str) -> Array:
    """The pose (4, 4) of a position and a rotation in any form; a planar position may be (x, y)."""
    if _has_matrix(rotation):
        rotation = rotation.as_matrix()
    p, R = as_numbers(position, given, accepted), as_numbers(rotation, given, accepted)
    if p.shape not in ((dimension,), (3,)) or R.shape not in ((4,), (3, 3)):
        raise ArgumentError("target", given, accepted)
    pose = np.eye(4)
    pose[:3, :3] = from_quaternion(R, given) if R.shape == (4,) else R
    pose[: len(p), 3] = p
    return pose


def _check_pose(pose: Array, planar: bool, given: object) -> None:
    _check_rotation(pose[:3, :3], planar, given)
    if np.abs(pose[3] - (0, 0, 0, 1)).max() > ROTATION_TOLERANCE:
        raise ArgumentError("target", given, "a pose with the last row (0, 0, 0, 1)")
    if planar and abs(pose[2, 3]) > ROTATION_TOLERANCE:
        raise ArgumentError("target", given, "a pose in the plane of this planar robot: z = 0, rotated about z only")


def _check_rotation(R: Array, planar: bool, given: object) -> None:
    if not is_rotation(*R.T.ravel().tolist()):
        raise ArgumentError("target", given, "a rotation: orthonormal columns, determinant +1")
    if planar and np.abs(R[2] - (0, 0, 1)).max() > ROTATION_TOLERANCE:
        raise ArgumentError("target", given, "a pose in the plane of this planar robot: z = 0, rotated about z only")

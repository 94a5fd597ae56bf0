"""Targets as numbers: every form a caller may hand over, the usual ones read in a few microseconds.

Positions are vectors; rotations are matrices (3, 3) or quaternions (w, x, y, z); poses are matrices (4, 4) or pairs
(position, quaternion). An object with ``as_matrix()``, such as those of mink and SciPy, counts as its matrix.
"""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np

from jtik.errors import ArgumentError
from jtik.types import Array

Kind = Literal["position", "orientation", "pose"]

ROTATION_TOLERANCE = 1e-6
"""How far a target's rotation may be from orthonormal, a quaternion's norm from 1: what six printed digits leave."""

_FLOAT = np.dtype(np.float64)


def usual(target: Any, kind: Kind) -> Array | None:
    """The numbers of a sound float64 array (4, 4), (3, 3) or (3,) on a robot in space, None for all else.

    A position is 3 numbers, an orientation the 9 entries of R by columns, a pose both.
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
    """A target in any of its forms as numbers: those of `usual`, or of (x, y, angle) on a planar robot.

    Raises:
        ArgumentError: for what is none of them; ``accepted`` tells what is.
    """
    given = target
    planar = dimension == 2
    if hasattr(target, "as_matrix"):
        target = target.as_matrix()
        numbers = None if planar else usual(target, kind)
        if numbers is not None:
            return numbers
    elif isinstance(target, (tuple, list)) and len(target) == 2 and isinstance(target[0], (tuple, list, np.ndarray)):
        target = _from_pair(target[0], target[1], dimension, given, accepted)
    array = as_numbers(target, given, accepted)
    if kind == "orientation" and array.shape == (4,):
        array = from_quaternion(array, given)
    if array.shape == (4, 4):
        _check_pose(array, planar, given)
        return _numbers(array[:dimension, 3], array[:3, :3], kind, planar)
    if kind == "orientation" and array.shape == (3, 3):
        _check_rotation(array, planar, given)
        return _numbers(np.zeros(0), array, kind, planar)
    plain: dict[Kind, list[tuple[int, ...]]] = {"position": [(dimension,)], "orientation": [(), (1,)], "pose": [(3,)]}
    if array.shape in plain[kind] and (planar or kind == "position"):
        return array.reshape(-1)
    raise ArgumentError("target", given, accepted)


def _numbers(position: Array, R: Array, kind: Kind, planar: bool) -> Array:
    """What ``kind`` keeps of a placement."""
    if kind == "position":
        return position
    turn = np.array([np.arctan2(R[1, 0], R[0, 0])]) if planar else R.ravel(order="F")
    return turn if kind == "orientation" else np.concatenate([position, turn])


def as_numbers(target: Any, given: object, accepted: str) -> Array:
    """``target`` as a new float64 array. Raises ArgumentError, showing ``given``, unless it is finite numbers."""
    try:
        raw = np.asarray(target)
    except ValueError:  # ragged
        raise ArgumentError("target", given, accepted) from None
    if raw.dtype.kind not in "fiu":
        raise ArgumentError("target", given, accepted)
    array = np.array(raw, dtype=np.float64)
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


def _from_pair(position: Any, quaternion: Any, dimension: int, given: object, accepted: str) -> Array:
    """The pose (4, 4) of a position and a quaternion; on a planar robot the position may lack its z."""
    place, turn = as_numbers(position, given, accepted), as_numbers(quaternion, given, accepted)
    if place.shape not in ((dimension,), (3,)) or turn.shape != (4,):
        raise ArgumentError("target", given, accepted)
    pose = np.eye(4)
    pose[:3, :3] = from_quaternion(turn, given)
    pose[: len(place), 3] = place
    return pose


def _check_pose(pose: Array, planar: bool, given: object) -> None:
    _check_rotation(pose[:3, :3], planar, given)
    if np.abs(pose[3] - (0, 0, 0, 1)).max() > ROTATION_TOLERANCE:
        raise ArgumentError("target", given, "a pose with the last row (0, 0, 0, 1)")
    if planar and abs(pose[2, 3]) > ROTATION_TOLERANCE:
        raise ArgumentError("target", given, "a pose in the plane of this planar robot: z = 0, turned about z")


def _check_rotation(R: Array, planar: bool, given: object) -> None:
    if not is_rotation(*R.T.ravel().tolist()):
        raise ArgumentError("target", given, "a rotation: orthonormal columns, determinant +1")
    if planar and np.abs(R[2] - (0, 0, 1)).max() > ROTATION_TOLERANCE:
        raise ArgumentError("target", given, "a pose in the plane of this planar robot: z = 0, turned about z")

"""Rotations and poses as callers have them: printed with few digits, or as objects of other libraries."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from jtik.arguments import numeric_array
from jtik.errors import ArgumentError
from jtik.types import Array

QUATERNION_TOLERANCE = 1e-2
"""Difference of the norm of a quaternion from 1 up to which it is normalised: two printed digits."""

MATRIX_TOLERANCE = 1e-3
"""Largest difference of an entry of a matrix from the nearest rotation up to which that is used: three digits."""

ROUNDING = 1e-6
"""Tolerance on the last row of a pose (4, 4)."""

FORMS = (
    "(4, 4) or (3, 4), seven numbers (x, y, z, qw, qx, qy, qz), a pair (position, rotation), or a pose of SciPy, mink, "
    "Pinocchio, spatialmath, Drake or ROS"
)
"""What a pose may be, for errors."""


def plain(value: Any) -> Any:
    """The numbers of a pose, rotation or position of another library; any other value itself.

    Those of SciPy and mink (``as_matrix``), Pinocchio (``homogeneous``, ``matrix``), spatialmath (``A``), Drake
    (``GetAsMatrix4``, ``matrix``, ``wxyz``) and the messages of ROS (``pose``, ``transform``, ``position`` and
    ``orientation``, ``translation`` and ``rotation``, or ``x``, ``y``, ``z`` and ``w``). The frame that a ROS message
    names is not read.
    """
    if value is None or isinstance(value, (np.ndarray, np.generic, list, tuple, int, float, str, dict, type)):
        return value
    for attribute in ("as_matrix", "homogeneous", "GetAsMatrix4", "A", "matrix", "wxyz"):
        found = getattr(value, attribute, None)
        if found is not None:
            return found() if callable(found) else found
    return _message(value)


def _message(value: Any) -> Any:
    """The seven numbers of a pose, the quaternion (w, x, y, z) or the position (x, y, z) of a message of ROS."""
    for inner in ("pose", "transform"):
        if hasattr(value, inner):
            return _message(getattr(value, inner))
    for position, rotation in (("position", "orientation"), ("translation", "rotation")):
        if hasattr(value, position) and hasattr(value, rotation):
            return [*_message(getattr(value, position)), *_message(getattr(value, rotation))]
    if all(hasattr(value, each) for each in "xyz"):
        return [getattr(value, each) for each in ("wxyz" if hasattr(value, "w") else "xyz")]
    return value


def is_pair(value: Any) -> bool:
    """Whether a value is a pair (position, rotation)."""
    if not isinstance(value, (tuple, list)) or len(value) != 2:
        return False
    return isinstance(value[0], (tuple, list, np.ndarray)) or any(plain(each) is not each for each in value)


def read_rotation(R: Array, given: object, argument: str = "target") -> Array:
    """The rotation (3, 3) nearest to a matrix, or that of a quaternion (w, x, y, z).

    Raises:
        ArgumentError: when it is farther off than `MATRIX_TOLERANCE` or `QUATERNION_TOLERANCE`; it says how far.
    """
    if R.shape == (4,):
        return _of_quaternion(R, given, argument)
    accepted = f"a rotation: orthonormal columns, determinant +1, to {MATRIX_TOLERANCE:g}; this one "
    U, _, Vt = np.linalg.svd(R)
    nearest: Array = U @ Vt
    if np.linalg.det(nearest) < 0:
        raise ArgumentError(argument, given, f"{accepted}has the determinant {np.linalg.det(R):.4g}")
    off = float(np.abs(R - nearest).max())
    if off > MATRIX_TOLERANCE:
        raise ArgumentError(argument, given, f"{accepted}differs from the nearest rotation by {off:.3g}")
    return nearest


def _of_quaternion(quaternion: Array, given: object, argument: str) -> Array:
    norm = float(np.linalg.norm(quaternion))
    if abs(norm - 1) > QUATERNION_TOLERANCE:
        accepted = f"a quaternion (w, x, y, z) of norm 1, to {QUATERNION_TOLERANCE:g}; this one has the norm {norm:.6g}"
        raise ArgumentError(argument, given, accepted)
    w, x, y, z = (quaternion / norm).tolist()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def as_numbers(value: Any, given: object, accepted: str, argument: str = "target") -> Array:
    """``value`` as a new float64 array. Raises ArgumentError, showing ``given``, unless it is finite numbers."""
    array = numeric_array(value)
    if array is None:
        raise ArgumentError(argument, given, accepted)
    if not np.isfinite(array).all():
        raise ArgumentError(argument, given, f"finite numbers: {accepted}")
    return array


def pose_of(
    value: Any,
    given: object,
    accepted: str,
    *,
    argument: str = "target",
    dimension: int = 3,
    is_rotation: Callable[[Array], bool] = lambda R: False,
) -> Array | None:
    """The pose (4, 4) of a value in one of `FORMS`; None where it has none of their shapes.

    Args:
        value: the value, after `plain`.
        given: the value as the caller gave it, for errors.
        accepted: what would have been accepted, for errors.
        argument: name of the argument, for errors.
        dimension: 2 where a position may be (x, y), and a pose a matrix (3, 3) of the plane.
        is_rotation: whether a matrix (3, 3) is used as it is.

    Raises:
        ArgumentError: when it is not finite numbers, or its rotation is none.
    """
    last: Array = np.zeros((0, 4))
    if is_pair(value):
        p, R = (as_numbers(plain(each), given, accepted, argument) for each in value)
        if p.shape not in ((dimension,), (3,)) or R.shape not in ((4,), (3, 3)):
            raise ArgumentError(argument, given, accepted)
    else:
        array = as_numbers(value, given, accepted, argument)
        if array.shape == (7,):
            p, R = array[:3], array[3:]
        elif array.shape in ((4, 4), (3, 4)):
            p, R = array[:3, 3], array[:3, :3]
            last = array[3:]
        elif dimension == 2 and array.shape == (3, 3) and np.abs(array[2] - (0, 0, 1)).max() <= ROUNDING:
            p, R = array[:2, 2], np.eye(3)
            R[:2, :2] = array[:2, :2]
        else:
            return None
    pose = np.eye(4)
    pose[:3, :3] = R if R.shape == (3, 3) and is_rotation(R) else read_rotation(R, given, argument)
    pose[: len(p), 3] = p
    if last.size and np.abs(last - (0, 0, 0, 1)).max() > ROUNDING:
        raise ArgumentError(argument, given, "a pose with the last row (0, 0, 0, 1)")
    return pose


def read_pose(value: Any, argument: str) -> Array:
    """The pose (4, 4) of an argument in one of `FORMS`.

    Raises:
        ArgumentError: for anything else.
    """
    accepted = f"a pose: {FORMS}"
    pose = pose_of(plain(value), value, accepted, argument=argument)
    if pose is None:
        raise ArgumentError(argument, value, accepted)
    return pose

"""Targets of frame tasks as numbers: every form that a caller may give.

A position is a vector. A rotation is a matrix (3, 3), a quaternion (w, x, y, z), or a rotation of another library. A
pose is a matrix (4, 4) or (3, 4), seven numbers (x, y, z, qw, qx, qy, qz), a pair (position, rotation), or a pose of
another library; see `jtik.robot.pose_input`, which also normalises numbers that were printed with few digits.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any, Literal

import numpy as np

from jtik.errors import ArgumentError
from jtik.robot.pose_input import as_numbers, is_pair, plain, pose_of, read_rotation
from jtik.symbolic import (
    SX,
    Function,
    cross,
    dot,
    function,
    identity,
    is_finite,
    logic_and,
    norm_inf,
    symbol,
    vec,
    vertcat,
)
from jtik.types import Array

Kind = Literal["position", "orientation", "pose"]

ROTATION_TOLERANCE = 1e-6
"""Tolerance on the orthonormality of a rotation that is used as it is; others are replaced by the nearest rotation."""

PLANE_TOLERANCE = 1e-6
"""How far a target of a planar robot may be out of the plane [m] or [rad]."""

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


@cache
def matrix_reader(kind: Kind) -> Function:
    """The function that reads a matrix (4, 4) as `read_fast` does: its memory, row by row -> numbers, whether valid."""
    memory = symbol("T", 4, 4)
    T = memory.T
    R, p = T[:3, :3], T[:3, 3]
    numbers = {"position": p, "orientation": vec(R), "pose": vertcat(p, vec(R))}[kind]
    off = norm_inf(vec(R.T @ R - identity(3)))
    is_pose = logic_and(norm_inf(memory[:, 3] - SX([0, 0, 0, 1])) == 0, is_finite(memory))
    is_rotation = logic_and(off <= ROTATION_TOLERANCE, dot(R[:, 2], cross(R[:, 0], R[:, 1])) > 0)
    return function("read_matrix", [memory], [numbers, logic_and(is_pose, is_rotation)])


MATRICES = 4096
"""Matrices that are checked at once: their entries stay in a cache of the processor."""

_ENTRIES = {"position": [3, 7, 11], "orientation": [0, 4, 8, 1, 5, 9, 2, 6, 10]}
"""The numbers of a target, as entries of a matrix (4, 4) row by row."""


def read_matrices(targets: Array, kind: Kind) -> Array | None:
    """The numbers of `read_fast` of many matrices (k, 4, 4), (k, size); None where one of them is not valid."""
    rows = targets.reshape(-1, 16)
    entries = _ENTRIES["position"] + _ENTRIES["orientation"] if kind == "pose" else _ENTRIES[kind]
    table = np.empty((len(rows), len(entries)))
    for begin in range(0, len(rows), MATRICES):
        part = rows[begin : begin + MATRICES]
        part.take(entries, axis=1, out=table[begin : begin + MATRICES], mode="clip")  # "raise" would copy it
        if not _are_poses(np.ascontiguousarray(part.T)):
            return None
    return table


def _are_poses(entries: Array) -> bool:
    """Whether matrices, whose entries are the rows (16, k), are finite poses."""
    x, y, z, p = entries[:12].reshape(3, 4, -1).transpose(1, 0, 2)
    with np.errstate(all="ignore"):
        if entries[12:15].any() or not (entries[15] == 1).all():
            return False
        if not np.isfinite(p.sum()):
            return False
        for a, b, inner in ((x, x, 1), (y, y, 1), (z, z, 1), (x, y, 0), (y, z, 0), (z, x, 0)):
            products = np.einsum("rk,rk->k", a, b)
            if not max(products.max() - inner, inner - products.min()) <= ROTATION_TOLERANCE:
                return False
        volume = z[0] * (x[1] * y[2] - x[2] * y[1]) + z[1] * (x[2] * y[0] - x[0] * y[2])
        return bool((volume + z[2] * (x[0] * y[1] - x[1] * y[0]) > 0).all())


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
    target = plain(target)
    if target is not given and not planar:
        numbers = read_fast(target, kind)
        if numbers is not None:
            return numbers
    turn = kind == "orientation"
    if turn and not is_pair(target):
        array = as_numbers(target, given, accepted)
        if array.shape == (4,) or (array.shape == (3, 3) and not planar):  # in the plane it is also a pose
            R = array if array.shape == (3, 3) and _is_rotation(array) else read_rotation(array, given)
            _check_planar(np.zeros(3), R, planar, given)
            return _numbers(np.zeros(0), R, kind, planar)
    pose = pose_of(target, given, accepted, dimension=dimension, is_rotation=_is_rotation)
    if pose is not None:
        _check_planar(pose[:3, 3], pose[:3, :3], planar, given)
        return _numbers(pose[:dimension, 3], pose[:3, :3], kind, planar)
    array = as_numbers(target, given, accepted)
    shapes: dict[Kind, list[tuple[int, ...]]] = {"position": [(dimension,)], "orientation": [(), (1,)], "pose": [(3,)]}
    if array.shape in shapes[kind] and (planar or kind == "position"):
        return array.reshape(-1)
    raise ArgumentError("target", given, accepted)


def unused_part(target: Any, kind: Kind) -> str | None:
    """The part of a valid target that a task of this kind does not use; None where it uses all of it."""
    if kind == "pose" or not _is_pose(target):
        return None
    return "orientation of the target" if kind == "position" else "position of the target"


def _is_pose(target: Any) -> bool:
    """Whether a valid target has both a position and an orientation."""
    target = plain(target)
    return is_pair(target) or np.shape(target) in ((4, 4), (3, 4), (7,))


def _is_rotation(R: Array) -> bool:
    return is_rotation(*R.T.ravel().tolist())


def _numbers(position: Array, R: Array, kind: Kind, planar: bool) -> Array:
    """The numbers of the part of a pose that ``kind`` uses."""
    if kind == "position":
        return position
    orientation = np.array([np.arctan2(R[1, 0], R[0, 0])]) if planar else R.ravel(order="F")
    return orientation if kind == "orientation" else np.concatenate([position, orientation])


def _check_planar(position: Array, R: Array, planar: bool, given: object) -> None:
    off = max(abs(float(position[2])), float(np.abs(R[2] - (0, 0, 1)).max()))
    if planar and off > PLANE_TOLERANCE:
        accepted = "a pose in the plane of this planar robot: z = 0, rotated about z only"
        raise ArgumentError("target", given, accepted)

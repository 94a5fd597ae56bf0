"""Whether two bodies can come near each other within the limits of the joints between them: by intervals.

The distance of two bodies depends on the joints between them, and changes by at most the length of the lever times the
motion of each. A box of joint positions whose centre has a larger distance than that bound leaves is out of reach; the
others are halved, until one centre is near or the number of boxes is used up.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from jtik.geometry import segment_distances
from jtik.robot.collisions.bodies import CollisionBody
from jtik.robot.collisions.frame_poses import frame_poses
from jtik.robot.joint_type import JointType
from jtik.robot.tree import Joint
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.robot.model import Robot

BOXES = 3000
"""Boxes that are tried for a pair; where they do not suffice the pair counts as one that can touch."""

MOST_JOINTS = 4
"""Most positions between two bodies for which a proof is tried: with more, next to none succeeds with so many boxes."""


def is_out_of_reach(robot: Robot, first: CollisionBody, second: CollisionBody, distance: float) -> bool:
    """Whether two bodies are provably never within ``distance`` [m] of each other."""
    levers = _levers(robot, first, second)
    if levers is None or len(levers) > MOST_JOINTS:
        return False
    columns, arms = np.array(list(levers), dtype=int), np.array(list(levers.values()))
    ranges = [_range(robot, column) for column in columns]
    if not np.isfinite(ranges).all() or not np.isfinite(arms).all():
        return False
    low, high = np.array(ranges).reshape(-1, 2).T
    centers, halves = (low + high)[None] / 2, (high - low)[None] / 2
    tried = 0
    while len(centers):
        tried += len(centers)
        gap = body_distances(robot, _configurations(robot, columns, centers), first, second)
        if gap.min() <= distance or tried > BOXES:
            return False
        left = gap - halves @ arms <= distance
        centers, halves = _halved(centers[left], halves[left], arms)
    return True


def body_distances(robot: Robot, q: Array, first: CollisionBody, second: CollisionBody) -> Array:
    """Signed distances (N,) of two bodies [m] at configurations (N, nq)."""
    poses = frame_poses(robot, q, [*first.frames, *second.frames])
    ends = [axis_point(poses, body, i, robot.dimension) for body in (first, second) for i in (0, 1)]
    return segment_distances(*np.broadcast_arrays(*ends)) - first.radius - second.radius


def axis_point(poses: dict[str, Array], body: CollisionBody, end: int, dimension: int) -> Array:
    """The start (0) or end (1) of a body's axis at poses of frames, (N, 3) [m]; on a planar robot with z = 0."""
    pose = poses[body.frames[end]]
    point: Array = pose[:, :3, :3] @ body.offsets[end] + pose[:, :3, 3]
    point[:, dimension:] = 0
    return point


def _levers(robot: Robot, first: CollisionBody, second: CollisionBody) -> dict[int, float] | None:
    """The largest motion of a point of one body in the other's frame per unit of each position between them.

    By the index of the position in q, [m/rad] or [m/m]. None where a ball or free joint is between them.
    """
    paths = [robot.path(frame) for body in (first, second) for frame in body.frames]
    shared = 0
    while all(len(path) > shared and path[shared] is paths[0][shared] for path in paths):
        shared += 1
    arms: dict[int, float] = {}
    for body, ways in ((first, paths[:2]), (second, paths[2:])):
        found = [
            _levers_on(robot, way[shared:], float(np.linalg.norm(offset)))
            for way, offset in zip(ways, body.offsets, strict=True)
        ]
        if found[0] is None or found[1] is None:
            return None
        for column in {*found[0], *found[1]}:
            arms[column] = arms.get(column, 0.0) + max(found[0].get(column, 0.0), found[1].get(column, 0.0))
    return arms


def _levers_on(robot: Robot, path: tuple[Joint, ...], beyond: float) -> dict[int, float] | None:
    """The same for a point at the end of a path, ``beyond`` [m] from the origin of its last frame."""
    arms: dict[int, float] = {}
    for joint in reversed(path):
        if joint.is_moving:
            if not joint.type.is_scalar:
                return None
            column = robot.q_slice(joint.name).start
            gain = 1.0 if joint.mimic is None else abs(joint.mimic.multiplier)
            translates = joint.type is JointType.PRISMATIC
            arms[column] = arms.get(column, 0.0) + gain * (1.0 if translates else beyond)
            if translates:
                offset = 0.0 if joint.mimic is None else abs(joint.mimic.offset)
                beyond += offset + gain * float(np.abs([robot.lower[column], robot.upper[column]]).max())
        beyond += float(np.linalg.norm(joint.origin[:3, 3]))
    return arms


def _range(robot: Robot, column: int) -> tuple[float, float]:
    """The range of an entry of q; one turn of a revolute joint without limits or with longer ones."""
    low, high = float(robot.lower[column]), float(robot.upper[column])
    turns = all(
        joint.type is JointType.REVOLUTE and (joint.mimic is None or abs(joint.mimic.multiplier) == 1)
        for joint in robot.joints
        if joint.is_moving and robot.q_slice(joint.name).start == column
    )
    return (-math.pi, math.pi) if turns and not high - low < 2 * math.pi else (low, high)


def _configurations(robot: Robot, columns: NDArray[np.int_], positions: Array) -> Array:
    """Configurations (N, nq) with these positions (N, k) at these indices, neutral elsewhere."""
    q = np.tile(robot.neutral, (len(positions), 1))
    q[:, columns] = positions
    return q


def _halved(centers: Array, halves: Array, arms: Array) -> tuple[Array, Array]:
    """Each box halved along the position that moves the bodies most."""
    if not len(centers):
        return centers, halves
    rows, widest = np.arange(len(centers)), np.argmax(halves * arms, axis=1)
    halves = halves.copy()
    halves[rows, widest] /= 2
    shift = np.zeros_like(halves)
    shift[rows, widest] = halves[rows, widest]
    return np.concatenate([centers - shift, centers + shift]), np.concatenate([halves, halves])

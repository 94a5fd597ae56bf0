"""The frames that represent the body of a robot: the points for obstacle avoidance, and the links to draw."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from jtik.robot.joint_type import JointType
from jtik.robot.tree import Joint
from jtik.symbolic import function, symbol, vertcat

if TYPE_CHECKING:
    from jtik.robot.model import Robot

NEGLIGIBLE = 1e-9
"""Lengths and displacements up to this [m] count as rounding errors."""

_SAMPLES = 4
_CARRYING = (JointType.PRISMATIC, JointType.FREE)


def moving_frames(robot: Robot) -> tuple[str, ...]:
    """The frames that carry a joint or the tip and whose origins move under q, in the robot's order.

    Of frames that always coincide only the last is kept. The inner frames of prismatic joints in series on the ground
    are left out: no part of the robot is there.
    """
    nodes = [frame for frame in _nodes(robot) if frame != robot.base]
    if not nodes:
        return ()
    q = symbol("q", robot.nq)
    kinematics = robot.at(q)
    points = function("points", [q], [vertcat(*[kinematics.position(frame) for frame in nodes])])
    generator = np.random.default_rng(0)
    samples = [points(robot.random_configuration(generator)).full() for _ in range(_SAMPLES)]
    spread = np.ptp(np.stack(samples), axis=0).reshape(len(nodes), -1).max(axis=1)
    return tuple(frame for frame, moved in zip(nodes, spread, strict=True) if moved > NEGLIGIBLE)


def segments(robot: Robot) -> tuple[tuple[str, str], ...]:
    """The links of the skeleton as pairs of frames (inner, outer), none of them always of length zero.

    The prismatic joints of a vehicle, or a free joint, between the ground and the body are not links.
    """
    origin = shared_origins(robot)
    nodes = _nodes(robot)
    kept = {origin[frame]: frame for frame in nodes}
    pairs = []
    for outer in nodes:
        path = robot.path(outer)
        inward = [origin[joint.parent] for joint in reversed(path)]
        inner = [each for each in inward if each in kept and each != origin[outer]]
        if inner and not _is_carried(path):
            pairs.append((kept[inner[0]], outer))
    return tuple(pairs)


def _nodes(robot: Robot) -> tuple[str, ...]:
    """The base, the frames that joints move, and the tip; one for each shared origin, in the order of the robot."""
    origin = shared_origins(robot)
    carriers = {j.parent for j in robot.joints if j.type is JointType.PRISMATIC and _is_short(j)}
    candidates = [robot.base]
    for joint in robot.joints:
        hidden = joint.child in carriers and _is_carried(robot.path(joint.child)) and joint.child != robot.tip
        if (joint.is_moving and not hidden) or joint.child == robot.tip:
            candidates.append(joint.child)
    last = {origin[frame]: frame for frame in candidates}
    last[origin[robot.tip]] = robot.tip
    return tuple(frame for frame in candidates if last[origin[frame]] == frame)


def shared_origins(robot: Robot) -> dict[str, str]:
    """For every frame the innermost frame whose origin always coincides with its own."""
    origin = {robot.base: robot.base}
    for frame in robot.frame_names:
        for joint in robot.path(frame):
            coincides = _is_short(joint) and joint.type not in _CARRYING
            origin.setdefault(joint.child, origin[joint.parent] if coincides else joint.child)
    return origin


def _is_short(joint: Joint) -> bool:
    """Whether the origin of the joint coincides with that of its parent."""
    return float(np.linalg.norm(joint.origin[:3, 3])) <= NEGLIGIBLE


def _is_carried(path: Sequence[Joint]) -> bool:
    """Whether only prismatic joints, a free joint and fixed joints carry the end of ``path``."""
    body = list(path)
    while body and body[-1].type not in _CARRYING and _is_short(body[-1]):
        body.pop()
    mounted = all(joint.type in (*_CARRYING, JointType.FIXED) for joint in body)
    return bool(body) and mounted and body[-1].type in _CARRYING

"""Which frames stand for the robot's body: the points an obstacle must not touch, and the links to draw."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from jtik.robot.joints import JointType
from jtik.robot.tree import Joint
from jtik.symbolic import function, symbol, vertcat

if TYPE_CHECKING:
    from jtik.robot.model import Robot

STILL = 1e-9
"""Lengths and movements up to this [m] are rounding."""

_SAMPLES = 4
_CARRYING = (JointType.PRISMATIC, JointType.FREE)


def moving_frames(robot: Robot) -> tuple[str, ...]:
    """The frames that carry a joint or the tip and whose origins move under q, in the robot's order.

    Of frames that always coincide only the last is kept. The inner frames of a stack of slides on the ground
    are left out: they are places on a drawing, not parts of a robot.
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
    return tuple(frame for frame, moved in zip(nodes, spread, strict=True) if moved > STILL)


def segments(robot: Robot) -> tuple[tuple[str, str], ...]:
    """The links of the skeleton as pairs of frames (inner, outer), none of them always of length zero.

    What a vehicle's slides or a free joint put between the ground and the body is not a link.
    """
    spot = _spots(robot)
    nodes = _nodes(robot)
    kept = {spot[frame]: frame for frame in nodes}
    found = []
    for outer in nodes:
        path = robot.path(outer)
        spots_inward = [spot[joint.parent] for joint in reversed(path)]
        inner = [at for at in spots_inward if at in kept and at != spot[outer]]
        if inner and not _is_carried(path):
            found.append((kept[inner[0]], outer))
    return tuple(found)


def _nodes(robot: Robot) -> tuple[str, ...]:
    """The base, the frames that joints move, and the tip; one a spot, in the robot's order."""
    spot = _spots(robot)
    carriers = {j.parent for j in robot.joints if j.type is JointType.PRISMATIC and _is_short(j)}
    wanted = [robot.base]
    for joint in robot.joints:
        hidden = joint.child in carriers and _is_carried(robot.path(joint.child)) and joint.child != robot.tip
        if (joint.is_moving and not hidden) or joint.child == robot.tip:
            wanted.append(joint.child)
    last = {spot[frame]: frame for frame in wanted}
    last[spot[robot.tip]] = robot.tip
    return tuple(frame for frame in wanted if last[spot[frame]] == frame)


def _spots(robot: Robot) -> dict[str, str]:
    """For every frame the innermost frame whose origin always coincides with its own."""
    spot = {robot.base: robot.base}
    for frame in robot.frame_names:
        for joint in robot.path(frame):
            together = _is_short(joint) and joint.type not in _CARRYING
            spot.setdefault(joint.child, spot[joint.parent] if together else joint.child)
    return spot


def _is_short(joint: Joint) -> bool:
    return float(np.linalg.norm(joint.origin[:3, 3])) <= STILL


def _is_carried(path: Sequence[Joint]) -> bool:
    """Whether slides or a free joint alone, on fixed mounts, carry the end of ``path``."""
    body = list(path)
    while body and body[-1].type not in _CARRYING and _is_short(body[-1]):
        body.pop()
    mounted = all(joint.type in (*_CARRYING, JointType.FIXED) for joint in body)
    return bool(body) and mounted and body[-1].type in _CARRYING

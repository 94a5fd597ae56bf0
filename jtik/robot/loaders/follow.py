"""Joints that follow others, folded into the joint that leads."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from jtik.robot.joints import JointType
from jtik.robot.loaders.robot_description import Follow, RobotDescription
from jtik.robot.loaders.transforms import moved_by, turned_by
from jtik.robot.tree import Joint, Mimic
from jtik.types import Array


def folded(description: RobotDescription) -> RobotDescription:
    """The same robot with every `Follow` worked into the joints.

    A joint that follows one that follows another follows that other; one that is held, or follows a held one,
    becomes fixed. Where several statements concern the same joint, or joints follow one another in a circle, the
    first ones count and the others are noted. The position limits of a joint that follows are those of its leader:
    its own are dropped.
    """
    stated, notes = _stated(description.follows)
    joints = []
    for joint in description.joints:
        if joint.name not in stated:
            joints.append(joint)
            continue
        follow = _end(stated[joint.name], stated)
        if follow.leader is None:
            held = joint.origin @ motion(joint, follow.offset)
            joints.append(Joint(joint.name, JointType.FIXED, joint.parent, joint.child, origin=held))
        else:
            mimic = Mimic(follow.leader, follow.multiplier, follow.offset)
            joints.append(replace(joint, mimic=mimic, lower=-math.inf, upper=math.inf))
    return replace(description, joints=tuple(joints), follows=(), notes=(*description.notes, *notes))


def motion(joint: Joint, position: float) -> Array:
    """What a hinge or a slide adds to its origin at ``position`` [rad] or [m], (4, 4)."""
    return turned_by(joint.axis, position) if joint.type is JointType.REVOLUTE else moved_by(position * joint.axis)


def _stated(follows: Iterable[Follow]) -> tuple[dict[str, Follow], list[str]]:
    """What each joint follows, by the first statement about it, and notes on the statements left out."""
    stated: dict[str, Follow] = {}
    notes = []
    for follow in follows:
        if follow.joint in stated or follow.joint in _chain(follow.leader, stated):
            why = "it follows another joint already, or would follow itself"
            notes.append(f"joint {follow.joint!r} does not follow {follow.leader!r}: {why}")
        else:
            stated[follow.joint] = follow
    return stated, notes


def _chain(joint: str | None, stated: dict[str, Follow]) -> list[str]:
    """``joint``, what it follows, what that follows ..."""
    chain = []
    while joint is not None:
        chain.append(joint)
        joint = stated[joint].leader if joint in stated else None
    return chain


def _end(follow: Follow, stated: dict[str, Follow]) -> Follow:
    while follow.multiplier != 0 and follow.leader in stated:
        above = stated[follow.leader]
        follow = replace(
            follow,
            leader=above.leader,
            multiplier=follow.multiplier * above.multiplier,
            offset=follow.multiplier * above.offset + follow.offset,
        )
    return follow if follow.multiplier != 0 and follow.leader is not None else replace(follow, leader=None)

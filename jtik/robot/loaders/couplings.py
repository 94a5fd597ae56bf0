"""Converts the joint couplings of a description to mimic joints and fixed joints."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from jtik.robot.joint_type import JointType
from jtik.robot.loaders.robot_description import JointCoupling, RobotDescription
from jtik.robot.loaders.transforms import rotation_about, translation
from jtik.robot.tree import Joint, Mimic
from jtik.types import Array


def with_mimic_joints(description: RobotDescription) -> RobotDescription:
    """The same robot whose couplings are mimic joints and fixed joints.

    A joint that follows a follower becomes a mimic of the last leader. A joint at a constant position, or a follower of
    one, becomes fixed. Of several couplings of one joint, and of couplings in a cycle, the first ones are used and the
    others are noted. A follower has the position limits of its leader: its own are dropped.
    """
    coupled, notes = _by_follower(description.couplings)
    joints = []
    for joint in description.joints:
        if joint.name not in coupled:
            joints.append(joint)
            continue
        coupling = _resolved(coupled[joint.name], coupled)
        if coupling.leader is None:
            origin = joint.origin @ motion(joint, coupling.offset)
            joints.append(Joint(joint.name, JointType.FIXED, joint.parent, joint.child, origin=origin))
        else:
            mimic = Mimic(coupling.leader, coupling.multiplier, coupling.offset)
            joints.append(replace(joint, mimic=mimic, lower=-math.inf, upper=math.inf))
    return replace(description, joints=tuple(joints), couplings=(), notes=(*description.notes, *notes))


def motion(joint: Joint, position: float) -> Array:
    """The motion (4, 4) of a revolute or prismatic joint at ``position`` [rad] or [m]."""
    if joint.type is JointType.REVOLUTE:
        return rotation_about(joint.axis, position)
    return translation(position * joint.axis)


def _by_follower(couplings: Iterable[JointCoupling]) -> tuple[dict[str, JointCoupling], list[str]]:
    """The first coupling of each joint, by its name, and notes on the couplings that are left out."""
    coupled: dict[str, JointCoupling] = {}
    notes = []
    for coupling in couplings:
        if coupling.joint in coupled or coupling.joint in _leaders(coupling.leader, coupled):
            why = "it follows another joint already, or would follow itself"
            notes.append(f"joint {coupling.joint!r} does not follow {coupling.leader!r}: {why}")
        else:
            coupled[coupling.joint] = coupling
    return coupled, notes


def _leaders(joint: str | None, coupled: dict[str, JointCoupling]) -> list[str]:
    """``joint``, its leader, the leader of that, and so on."""
    leaders = []
    while joint is not None:
        leaders.append(joint)
        joint = coupled[joint].leader if joint in coupled else None
    return leaders


def _resolved(coupling: JointCoupling, coupled: dict[str, JointCoupling]) -> JointCoupling:
    """The same coupling to the last leader; without a leader where the position is constant."""
    while coupling.multiplier != 0 and coupling.leader in coupled:
        above = coupled[coupling.leader]
        coupling = replace(
            coupling,
            leader=above.leader,
            multiplier=coupling.multiplier * above.multiplier,
            offset=coupling.multiplier * above.offset + coupling.offset,
        )
    constant = coupling.multiplier == 0 or coupling.leader is None
    return replace(coupling, leader=None) if constant else coupling

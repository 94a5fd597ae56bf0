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

ROUNDING = 1e-6
"""Relative reduction of the range of a leader that is not reported: the error of six printed digits."""


def with_mimic_joints(description: RobotDescription) -> RobotDescription:
    """The same robot whose couplings are mimic joints and fixed joints.

    A joint that follows a follower becomes a mimic of the last leader. A joint at a constant position, or a follower of
    one, becomes fixed. Of several couplings of one joint, and of couplings in a cycle, the first ones are used and the
    others are noted. A follower keeps its own position limits, which reduce those of its leader. Where that leaves the
    leader no range, those of the follower are dropped and noted.
    """
    coupled, notes = _by_follower(description.couplings)
    leaders = _Leaders(description.joints)
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
            lower, upper = leaders.limits_of_follower(joint, mimic)
            joints.append(replace(joint, mimic=mimic, lower=lower, upper=upper))
    return replace(
        description,
        joints=tuple(joints),
        couplings=(),
        notes=(*description.notes, *notes, *leaders.notes),
        changes=(*description.changes, *leaders.changes()),
    )


class _Leaders:
    """The ranges of the joints that others follow, which the limits of the followers reduce.

    Attributes:
        notes: one sentence for each follower whose limits are dropped.
    """

    def __init__(self, joints: Iterable[Joint]) -> None:
        self._stated = {joint.name: (joint.lower, joint.upper) for joint in joints}
        self._left = dict(self._stated)
        self._reducing: dict[str, list[str]] = {}
        self.notes: list[str] = []

    def limits_of_follower(self, follower: Joint, mimic: Mimic) -> tuple[float, float]:
        """The limits that a follower keeps: its own, or none where its leader would have no range left."""
        ends = sorted((limit - mimic.offset) / mimic.multiplier for limit in (follower.lower, follower.upper))
        lower, upper = self._left[mimic.joint]
        low, high = max(lower, ends[0]), min(upper, ends[1])
        rounding = ROUNDING * min(upper - lower, 2 * math.pi)
        if low > high or (low == high and lower < upper):
            limits = f"its limits, {follower.lower:g} to {follower.upper:g}, are not kept"
            why = f"following {mimic.joint!r}, which moves from {lower:g} to {upper:g}, it would have no range"
            self.notes.append(f"joint {follower.name!r}: {limits}: {why}")
            return -math.inf, math.inf
        self._left[mimic.joint] = low, high
        if low > lower + rounding or high < upper - rounding:
            self._reducing.setdefault(mimic.joint, []).append(follower.name)
        return follower.lower, follower.upper

    def changes(self) -> list[str]:
        """One sentence for each leader whose range its followers reduce."""
        found = []
        for leader, followers in self._reducing.items():
            lower, upper = (f"{limit:g}" for limit in self._left[leader])
            before = " to ".join(f"{limit:g}" for limit in self._stated[leader])
            who = ", ".join(map(repr, followers))
            found.append(f"joint {leader!r} moves from {lower} to {upper}, not {before}: {who} would leave its limits")
        return found


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

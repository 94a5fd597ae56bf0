"""Locking joints: the same robot with fewer of them free."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from jtik.errors import UnknownNameError, finite_array
from jtik.robot.joints import JointType
from jtik.robot.tree import Joint
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.robot.model import Robot


def locked_joints(robot: Robot, keep: Iterable[str], at: object) -> tuple[Joint, ...]:
    """The robot's joints, with all but ``keep`` fixed where they are at the configuration ``at``.

    A joint that mimics a locked one is fixed with it.

    Raises:
        ArgumentError: when ``at`` is not a configuration.
        UnknownNameError: when a joint to keep is no joint with a position of its own.
    """
    kept = {keep} if isinstance(keep, str) else set(keep)
    for name in sorted(kept.difference(robot.joint_names)):
        raise UnknownNameError("independent joint", name, robot.joint_names)
    q = robot.neutral if at is None else finite_array("at", at, (robot.nq,))

    def locked(joint: Joint) -> Joint:
        leader = joint.name if joint.mimic is None else joint.mimic.joint
        if not joint.is_moving or leader in kept:
            return joint
        return Joint(joint.name, JointType.FIXED, joint.parent, joint.child, origin=_held(robot, joint, q))

    return tuple(locked(joint) for joint in robot.joints)


def _held(robot: Robot, joint: Joint, q: Array) -> Array:
    """T_parent_child at ``q``, (4, 4), from this joint alone: no rounding comes from the others."""
    position = q[robot.q_slice(joint.name)]
    if joint.mimic is not None:
        position = joint.mimic.multiplier * position + joint.mimic.offset
    alone = replace(joint, parent="base", child="child", mimic=None)
    held: Array = type(robot)([alone]).pose(position)
    return held

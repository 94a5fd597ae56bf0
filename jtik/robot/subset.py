"""Locked joints: the same robot with fewer free joints."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from jtik.arguments import names
from jtik.errors import UnknownNameError
from jtik.robot.joint_type import JointType
from jtik.robot.tree import Joint, frozen
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.robot.model import Robot


@dataclass(frozen=True, eq=False)
class Reduction:
    """What a robot made by `Robot.subset` keeps of the robot it was made from.

    Attributes:
        full: the robot it was made from.
        locked: configuration (full.nq,) at which its other joints are locked, read-only.
        indices: indices (nq,) of the free joints' positions in the configuration of ``full``.
    """

    full: Any
    locked: Array
    indices: NDArray[np.intp]

    @classmethod
    def of(cls, full: Robot, locked: Array, joints: Iterable[str]) -> Reduction:
        """The reduction of ``full`` to ``joints``, in the order of q."""
        numbers = np.arange(full.nq)
        return cls(full, frozen(locked.copy()), np.concatenate([numbers[full.q_slice(joint)] for joint in joints]))

    def expanded(self, q: Array) -> Array:
        """The configuration (full.nq,) for a configuration (nq,) of the reduced robot."""
        full = self.locked.copy()
        full[self.indices] = q
        return full


def locked_joints(robot: Robot, keep: Iterable[str], q: Array) -> tuple[Joint, ...]:
    """The robot's joints, with all but ``keep`` fixed at the configuration ``q`` (nq,).

    A joint that mimics a locked one is fixed with it.

    Raises:
        UnknownNameError: when a joint to keep is no joint with a position of its own.
    """
    kept = set(names("joints", keep, "names of joints"))
    for name in sorted(kept.difference(robot.joint_names)):
        raise UnknownNameError("independent joint", name, robot.joint_names)

    def locked(joint: Joint) -> Joint:
        leader = joint.name if joint.mimic is None else joint.mimic.joint
        if not joint.is_moving or leader in kept:
            return joint
        return Joint(joint.name, JointType.FIXED, joint.parent, joint.child, origin=_pose_at(robot, joint, q))

    return tuple(locked(joint) for joint in robot.joints)


def _pose_at(robot: Robot, joint: Joint, q: Array) -> Array:
    """T_parent_child at ``q``, (4, 4), computed from this joint alone: the other joints add no rounding errors."""
    position = q[robot.q_slice(joint.name)]
    if joint.mimic is not None:
        position = joint.mimic.multiplier * position + joint.mimic.offset
    alone = replace(joint, parent="base", child="child", mimic=None)
    pose: Array = type(robot)([alone]).pose(position)
    return pose

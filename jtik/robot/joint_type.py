"""Joint types: the sizes of position and velocity, and how a displacement changes the position.

A joint has nq numbers of position and nv numbers of velocity. The two differ for joints with a quaternion:

=========  ==  ==  ======================================
type       nq  nv  position
=========  ==  ==  ======================================
FIXED      0   0   none
REVOLUTE   1   1   angle [rad] about the axis
PRISMATIC  1   1   distance [m] along the axis
BALL       4   3   unit quaternion (w, x, y, z)
FREE       7   6   position [m], then the unit quaternion
=========  ==  ==  ======================================

The velocity of a revolute or prismatic joint is the rate of its position. The velocity of a quaternion is the angular
velocity [rad/s] in the moving frame. The linear velocity [m/s] of a free joint comes first and is in the fixed axes of
the joint. This is MuJoCo's convention.
"""

from __future__ import annotations

import warnings
from enum import Enum, EnumMeta
from typing import TYPE_CHECKING, Any

import numpy as np

from jtik.robot import quaternion
from jtik.symbolic import SX, Expression, vertcat
from jtik.types import Array

_OLD_MEMBERS = {"HINGE": "REVOLUTE", "SLIDE": "PRISMATIC"}
_MUJOCO_VALUES = {"hinge": "revolute", "slide": "prismatic"}


class _JointTypeMeta(EnumMeta):
    """Resolves the old member names `HINGE` and `SLIDE`, with a `DeprecationWarning`."""

    def __getitem__(cls, name: str) -> Any:
        return super().__getitem__(_renamed(name))

    if not TYPE_CHECKING:  # a type checker must still refuse names that do not exist

        def __getattr__(cls, name: str) -> Any:
            if name in _OLD_MEMBERS:
                return cls.__members__[_renamed(name)]
            raise AttributeError(f"{cls.__name__} has no member {name!r}; members: {', '.join(cls.__members__)}")


def _renamed(name: str) -> str:
    """The present name of a member."""
    if name not in _OLD_MEMBERS:
        return name
    text = f"JointType.{name} is now JointType.{_OLD_MEMBERS[name]}"
    warnings.warn(text, DeprecationWarning, stacklevel=3)
    return _OLD_MEMBERS[name]


class JointType(Enum, metaclass=_JointTypeMeta):
    """The motion that a joint allows its child frame.

    ``JointType("hinge")`` and ``JointType("slide")`` are read as "revolute" and "prismatic": MuJoCo has these words,
    and so have files that were saved by earlier versions.

    Attributes:
        FIXED: no motion.
        REVOLUTE: a rotation about one axis.
        PRISMATIC: a translation along one axis.
        BALL: any rotation.
        FREE: any rotation and any translation.
    """

    FIXED = "fixed"
    REVOLUTE = "revolute"
    PRISMATIC = "prismatic"
    BALL = "ball"
    FREE = "free"

    @classmethod
    def _missing_(cls, value: object) -> JointType | None:
        return cls(_MUJOCO_VALUES[value]) if isinstance(value, str) and value in _MUJOCO_VALUES else None

    @property
    def nq(self) -> int:
        """Length of its position."""
        return _SIZES[self][0]

    @property
    def nv(self) -> int:
        """Length of its velocity."""
        return _SIZES[self][1]

    @property
    def is_scalar(self) -> bool:
        """Whether its position is one number. Only such joints can have limits, mimic and be mimicked."""
        return self in (JointType.REVOLUTE, JointType.PRISMATIC)

    @property
    def rotational(self) -> tuple[bool, ...]:
        """For each velocity entry: True for a rotation [rad], False for a translation [m]; nv entries."""
        return (False,) * _LINEAR[self] + (True,) * (self.nv - _LINEAR[self])

    @property
    def quaternion_start(self) -> int | None:
        """Index in its position at which the quaternion starts; None for a joint without one."""
        return self.nq - 4 if self in (JointType.BALL, JointType.FREE) else None

    @property
    def neutral(self) -> Array:
        """The position at which the joint's motion is the identity, shape (nq,)."""
        position = np.zeros(self.nq)
        if self.quaternion_start is not None:
            position[self.quaternion_start] = 1.0
        return position

    def tangent(self, q: Expression) -> Expression:
        """The map T(q) with dq/dt = T(q) v, shape (nq, nv)."""
        block = SX.eye(self.nq) if self.nq == self.nv else SX(self.nq, self.nv)
        if self.quaternion_start is not None:
            linear = self.nv - 3
            block[:linear, :linear] = SX.eye(linear)
            block[linear:, linear:] = quaternion.tangent(q[self.quaternion_start :])
        return block

    def integrate(self, q: Expression, dq: Expression) -> Expression:
        """The position after the displacement ``dq`` [rad] or [m] from ``q``, shape (nq, 1)."""
        if self.quaternion_start is None:
            return q + dq
        linear = self.nv - 3
        return vertcat(q[:linear] + dq[:linear], quaternion.integrate(q[linear:], dq[linear:]))

    def difference(self, start: Expression, end: Expression) -> Expression:
        """The displacement [rad] or [m] that integrates ``start`` to ``end``, shape (nv, 1)."""
        if self.quaternion_start is None:
            return end - start
        linear = self.nv - 3
        rotation = quaternion.difference(start[linear:], end[linear:])
        return vertcat(end[:linear] - start[:linear], rotation)


_SIZES = {
    JointType.FIXED: (0, 0),
    JointType.REVOLUTE: (1, 1),
    JointType.PRISMATIC: (1, 1),
    JointType.BALL: (4, 3),
    JointType.FREE: (7, 6),
}
_LINEAR = {
    JointType.FIXED: 0,
    JointType.REVOLUTE: 0,
    JointType.PRISMATIC: 1,
    JointType.BALL: 0,
    JointType.FREE: 3,
}

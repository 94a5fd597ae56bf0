"""The kinds of joints: how many numbers each takes and how its position changes.

A joint has nq numbers of position and nv of velocity. They differ where a quaternion is involved:

======  ==  ==  ==========================================
type    nq  nv  position
======  ==  ==  ==========================================
FIXED   0   0
REVOLUTE   1   1   angle [rad] about the axis
PRISMATIC   1   1   distance [m] along the axis
BALL    4   3   unit quaternion (w, x, y, z)
FREE    7   6   position [m], then the unit quaternion
======  ==  ==  ==========================================

The velocity of a hinge or slide is the rate of its position. A quaternion's is the angular velocity [rad/s]
in the moving frame; a free joint's linear velocity [m/s], which comes first, is in the joint's own fixed
axes.
This is MuJoCo's convention.
"""

from __future__ import annotations

from enum import Enum

import numpy as np

from jtik.robot import quaternion
from jtik.symbolic import SX, Expression, vertcat
from jtik.types import Array


class JointType(Enum):
    """What a joint lets its child frame do; see the module's table for nq, nv and conventions."""

    FIXED = "fixed"
    REVOLUTE = "hinge"
    PRISMATIC = "slide"
    BALL = "ball"
    FREE = "free"

    @property
    def nq(self) -> int:
        """How many numbers its position takes."""
        return _SIZES[self][0]

    @property
    def nv(self) -> int:
        """How many numbers its velocity takes."""
        return _SIZES[self][1]

    @property
    def is_scalar(self) -> bool:
        """Whether one number is its position, so that it can have limits and can be mimicked."""
        return self in (JointType.REVOLUTE, JointType.PRISMATIC)

    @property
    def rotational(self) -> tuple[bool, ...]:
        """For each velocity entry whether it is a rotation [rad], else a translation [m]; nv entries."""
        return (False,) * _LINEAR[self] + (True,) * (self.nv - _LINEAR[self])

    @property
    def quaternion_start(self) -> int | None:
        """Where in its position the quaternion starts, or None when it has none."""
        return self.nq - 4 if self in (JointType.BALL, JointType.FREE) else None

    @property
    def neutral(self) -> Array:
        """The position in which the joint moves nothing, shape (nq,)."""
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
        turn = quaternion.difference(start[linear:], end[linear:])
        return vertcat(end[:linear] - start[:linear], turn)


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

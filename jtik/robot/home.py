"""The home configuration: where a solve begins that is given no start.

A joint at its limit blocks every step towards that limit. From the neutral configuration, whose fourth joint is at its
limit, a Panda reaches one in ten of the poses around its usual posture; from mid-range it reaches all of them. An arm
that is straight inside its limits stays straight, although that is singular: at least 99 % of the poses around it are
reached so. With every joint moved by 0.1 or 0.3 rad from there it was not more, and with `newton` on a UR5e 87 to 97 %.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from jtik.robot.joint_type import JointType
from jtik.robot.tree import frozen
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.robot.model import Robot

NEAR = 0.2
"""Share of a joint's range within which a limit is near.

Measured on 22 arms: up to 0.1, one whose elbow is at 14 % of its range fails at a third of the poses around its home
with `newton`; from 0.2 to 0.3 the shares reached are the same.
"""

LONGEST_RANGE = {JointType.REVOLUTE: 2 * math.pi, JointType.PRISMATIC: 2.0}
"""Range [rad] or [m] from the limit that counts where the other limit is missing or farther away: that from which
`Robot.random_configuration` draws a joint with one limit."""


def home_of(robot: Robot) -> Array:
    """The keyframe "home" or, without one, the neutral configuration away from its limits; see `Robot.home`."""
    if "home" in robot.keyframes:
        return robot.keyframes["home"]
    q = robot.neutral.copy()
    for joint in robot.independent_joints:
        if joint.type.is_scalar:
            i = robot.q_slice(joint.name).start
            q[i] = _off_limits(float(q[i]), float(robot.lower[i]), float(robot.upper[i]), LONGEST_RANGE[joint.type])
    return frozen(q)


def _off_limits(position: float, lower: float, upper: float, longest: float) -> float:
    """``position``, or the middle of the range where a limit is near."""
    width = min(upper - lower, longest)
    if position - lower <= NEAR * width:
        return lower + width / 2
    if upper - position <= NEAR * width:
        return upper - width / 2
    return position

"""How far a joint itself translates, on the straight path between two configurations."""

from __future__ import annotations

from jtik.robot.joint_type import JointType
from jtik.robot.model import Robot
from jtik.robot.tree import Joint
from jtik.symbolic import Expression, fabs, fmax, norm


def stroke(robot: Robot, joint: Joint, start: Expression, end: Expression) -> Expression:
    """Largest translation of a joint from its origin between two configurations [m]; 0 without a translation.

    It is attained at one of the two ends, because a translation is linear along the path. A mimic joint is resolved.
    With the limits of the robot as ``start`` and ``end`` it is the largest translation at all, infinite without limits.

    Args:
        robot: the robot.
        joint: one of its joints.
        start: configuration (nq,), numbers or an expression.
        end: configuration (nq,), numbers or an expression.
    """
    if joint.type not in (JointType.PRISMATIC, JointType.FREE):
        return 0.0
    first = robot.q_slice(joint.name).start
    if joint.type is JointType.FREE:
        return fmax(*(norm(q[first : first + 3]) for q in (start, end)))
    ends = (start[first], end[first])
    if joint.mimic is not None:
        ends = tuple(joint.mimic.multiplier * q + joint.mimic.offset for q in ends)
    return fmax(*map(fabs, ends))

"""The displacement of all joints from a reference configuration, smooth in q."""

from __future__ import annotations

from jtik.robot import JointType, Robot, quaternion
from jtik.symbolic import Expression, fmax, sqrt, sumsqr, vertcat

_SMALLEST_SQUARE = 1e-12
"""Smallest squared norm of a live reference quaternion that is divided by."""


def displacement(robot: Robot, q: Expression, reference: Expression) -> Expression:
    """d (n, 1) [rad] and [m]: of a rotation by the angle theta about the axis a it has 2 sin(theta / 2) a.

    Args:
        robot: the robot.
        q: configuration (nq, 1).
        reference: the reference (nq, 1); its quaternions may have any length.
    """
    parts: list[Expression] = []
    for joint in robot.independent_joints:
        entries = robot.q_slice(joint.name)
        here, there = q[entries], reference[entries]
        if joint.type is JointType.FREE:
            parts.append(here[:3] - there[:3])
            here, there = here[3:], there[3:]
        if joint.type.is_scalar:
            parts.append(here - there)
            continue
        turned = quaternion.product(quaternion.conjugate(there), here)
        parts.append(2 * turned[1:] / sqrt(fmax(sumsqr(there), _SMALLEST_SQUARE)))
    return vertcat(*parts)

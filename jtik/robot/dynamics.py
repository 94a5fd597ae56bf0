"""Gravity torques and the mass matrix as expressions of one q, by composite rigid bodies (formulations/dynamics.md)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from jtik.errors import ArgumentError
from jtik.robot.joint_type import JointType
from jtik.robot.masses_and_shapes import Mass
from jtik.robot.rigid_bodies import moving_joints
from jtik.robot.tree import Joint
from jtik.symbolic import SX, Expression, cross, dot, stack, sumsqr, vertcat
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.robot.kinematics import Kinematics

STANDARD_GRAVITY = 9.81
"""Magnitude of gravity by default [m/s^2]."""


def standard_gravity(dimension: int) -> Array:
    """Gravity (3,) along -z, or (2,) along -y of a planar robot [m/s^2]."""
    gravity = np.zeros(dimension)
    gravity[-1] = -STANDARD_GRAVITY
    return gravity


_UPPER = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Rows and columns of the entries of a symmetric matrix that are computed."""


@dataclass(frozen=True)
class _Composite:
    """A rigid body about the reference point, in base axes.

    Attributes:
        mass: mass [kg].
        moment: mass times the position of the centre of mass, (3, 1) [kg m].
        inertia: entries of the inertia about the reference point, in the order of `_UPPER` (6, 1) [kg m^2]; None where
            it is not needed.
    """

    mass: float
    moment: Expression
    inertia: Expression | None

    def __add__(self, other: _Composite) -> _Composite:
        both = None if self.inertia is None or other.inertia is None else self.inertia + other.inertia
        return _Composite(self.mass + other.mass, self.moment + other.moment, both)


class Dynamics:
    """What the masses of a robot add to its kinematics at one q.

    Positions are taken from a reference point that moves with the joints at the base which shift everything, so that a
    robot far from the origin loses no digits.

    Args:
        kinematics: the kinematics.

    Raises:
        ArgumentError: when no joint moves a mass.
    """

    def __init__(self, kinematics: Kinematics) -> None:
        robot = kinematics.robot
        if not robot.bodies:
            given = f"{robot!r}, whose frames {', '.join(robot.massless_frames)} move no mass"
            raise ArgumentError("robot", given, "a robot with masses; Robot.with_masses adds them")
        self._kinematics, self._robot = kinematics, robot
        self._joints = moving_joints(robot)
        self._reference = self._reference_point()
        self._columns = {
            joint.name: list(kinematics.joint_columns(joint, self._reference)) for joint, _ in self._joints
        }

    def first_moment_jacobian(self) -> Expression:
        """The derivative of the mass times the centre of mass, (3, n) [kg m/rad] or [kg]."""
        composites = self._composites(with_inertia=False)
        J = SX(3, self._robot.n)
        for joint, _ in self._joints:
            body = composites.get(joint.name)
            if body is None:
                continue
            for k, gain, column in self._entries(joint):
                J[:, k] += gain * (body.mass * column[:3] + cross(column[3:], body.moment))
        return J

    def mass_matrix(self) -> Expression:
        """M (n, n), symmetric: the kinetic energy is 1/2 v' M v."""
        composites = self._composites(with_inertia=True)
        inward = {joint.name: before for joint, before in self._joints}
        M = SX(self._robot.n, self._robot.n)
        for joint, _ in self._joints:
            body = composites.get(joint.name)
            if body is None:
                continue
            own = list(self._entries(joint))
            forces = [(k, gain * _momentum(body, column)) for k, gain, column in own]
            for first, (k, force) in enumerate(forces):
                for i, gain, column in own[: first + 1]:
                    _add(M, i, k, gain * dot(column, force), twice=i != k)
            before = inward[joint.name]
            while before is not None:
                for i, gain, column in self._entries(before):
                    for k, force in forces:
                        _add(M, i, k, gain * dot(column, force), twice=True)
                before = inward[before.name]
        return M

    def kinetic_energy(self, v: Expression) -> Expression:
        """1/2 v' M v [J] without M, which takes a third of the operations."""
        twists: dict[str, Expression] = {}
        total: Expression = 0
        for joint, before in self._joints:
            twist = SX.zeros(6) if before is None else twists[before.name]
            for k, gain, column in self._entries(joint):
                twist = twist + gain * v[k] * column
            twists[joint.name] = twist
            mass = self._robot.bodies.get(joint.child)
            if mass is not None:
                center = self._kinematics.space_point(joint.child, mass.center) - self._reference
                speed = twist[:3] + cross(twist[3:], center)
                turning = self._kinematics.rotation(joint.child).T @ twist[3:]
                total += mass.mass * sumsqr(speed) + dot(turning, mass.inertia @ turning)
        return total / 2

    def _entries(self, joint: Joint) -> list[tuple[int, float, Expression]]:
        """Velocity entry, ratio and column (6, 1) of each column of a joint."""
        gain = 1.0 if joint.mimic is None else joint.mimic.multiplier
        first = self._robot.v_slice(joint.name).start
        return [(first + k, gain, column) for k, column in enumerate(self._columns[joint.name])]

    def _composites(self, *, with_inertia: bool) -> dict[str, _Composite]:
        """Everything that each joint moves, by its name."""
        bodies = self._robot.bodies
        found: dict[str, _Composite] = {}
        for joint, before in reversed(self._joints):
            if joint.child in bodies:
                own = self._body(joint.child, bodies[joint.child], with_inertia)
                found[joint.name] = found[joint.name] + own if joint.name in found else own
            if before is not None and joint.name in found:
                inner = found.get(before.name)
                found[before.name] = found[joint.name] if inner is None else inner + found[joint.name]
        return found

    def _body(self, frame: str, mass: Mass, with_inertia: bool) -> _Composite:
        center = self._kinematics.space_point(frame, mass.center) - self._reference
        if not with_inertia:
            return _Composite(mass.mass, mass.mass * center, None)
        R = self._kinematics.rotation(frame)
        turned, square = R @ mass.inertia, dot(center, center)
        entries = []
        for i, j in _UPPER:
            shift = (square if i == j else 0) - center[i] * center[j]
            entries.append(dot(turned[i, :].T, R[j, :].T) + mass.mass * shift)
        return _Composite(mass.mass, mass.mass * center, vertcat(*entries))

    def _reference_point(self) -> Expression:
        """The origin of the frame after the joints at the base that shift the whole robot."""
        robot, frame = self._robot, self._robot.base
        while True:
            after = [joint for joint in robot.joints if joint.parent == frame]
            if len(after) != 1 or after[0].type in (JointType.REVOLUTE, JointType.BALL):
                return self._kinematics.space_point(frame)
            frame = after[0].child


def _momentum(body: _Composite, column: Expression) -> Expression:
    """Linear and angular momentum (6, 1) about the reference point, of a motion of the same form."""
    v, w = column[:3], column[3:]
    return vertcat(body.mass * v + cross(w, body.moment), _symmetric(body.inertia) @ w + cross(body.moment, v))


def _symmetric(entries: Expression) -> Expression:
    """The matrix (3, 3) of the entries of `_UPPER`."""
    xx, xy, xz, yy, yz, zz = (entries[k] for k in range(6))
    return stack([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _add(M: Expression, i: int, k: int, value: Expression, *, twice: bool) -> None:
    """Add to a symmetric matrix: to the entry and, for two columns, to its mirror image, or twice to the diagonal."""
    M[i, k] += value
    if twice:
        M[k, i] += value

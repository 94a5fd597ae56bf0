"""Poses, positions and Jacobians of any frame, as expressions of one q that are built once and shared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from jtik.errors import ArgumentError
from jtik.robot import quaternion
from jtik.robot.joints import JointType
from jtik.robot.rotation import Rotation
from jtik.robot.tree import Joint
from jtik.symbolic import SX, Expression, cross, horzcat, vertcat
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.robot.model import Robot


@dataclass(frozen=True)
class _Placement:
    rotation: Rotation
    origin: Expression


class Kinematics:
    """The kinematics of a robot at one symbolic configuration.

    Made by `Robot.at`. A task and ten criteria that take it share every expression: asking for the same frame
    twice gives the same one.
    """

    def __init__(self, robot: Robot, q: Expression) -> None:
        self._robot = robot
        self._q = q
        self._placements = {robot.base: _Placement(Rotation(), SX.zeros(3))}
        self._rotations: dict[str, Expression] = {}
        self._jacobians: dict[str, Expression] = {}

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self._robot

    @property
    def q(self) -> Expression:
        """The configuration, shape (nq, 1)."""
        return self._q

    def pose(self, frame: str | None = None) -> Expression:
        """T_base_frame, shape (4, 4) [m]; ``frame`` is the tip when None.

        Raises:
            UnknownNameError: when there is no such frame.
        """
        upper = horzcat(self.rotation(frame), self._place(self._robot.frame(frame)).origin)
        return vertcat(upper, SX([[0, 0, 0, 1]]))

    def rotation(self, frame: str | None = None) -> Expression:
        """R_base_frame, shape (3, 3); ``frame`` is the tip when None.

        Raises:
            UnknownNameError: when there is no such frame.
        """
        frame = self._robot.frame(frame)
        if frame not in self._rotations:
            self._rotations[frame] = self._place(frame).rotation.matrix()
        return self._rotations[frame]

    def position(self, frame: str | None = None) -> Expression:
        """The frame's origin in the base frame [m], shape (3, 1), or (2, 1) of a planar robot.

        Raises:
            UnknownNameError: when there is no such frame.
        """
        origin = self._place(self._robot.frame(frame)).origin
        return origin[:2] if self._robot.dimension == 2 else origin

    def point(self, frame: str, offset: Array) -> Expression:
        """The point at ``offset`` (3,) [m] in ``frame``, in the base frame, shape (3, 1), or (2, 1) of a planar robot.

        Raises:
            UnknownNameError: when there is no such frame.
        """
        placed = self._place(self._robot.frame(frame))
        point = placed.origin + placed.rotation.apply(offset)
        return point[:2] if self._robot.dimension == 2 else point

    def center_of_mass(self, _: str | None = None) -> Expression:
        """The centre of mass in the base frame [m], shape (3, 1), or (2, 1) of a planar robot.

        Raises:
            ArgumentError: when the robot has no masses.
        """
        masses = self._robot.masses
        if not masses:
            raise ArgumentError("robot", self._robot, "a robot with masses")
        total = sum(body.mass for body in masses.values())
        return sum(body.mass / total * self.point(frame, body.center) for frame, body in masses.items())

    def relative(self, frame: str, reference: str) -> tuple[Expression, Expression]:
        """Rotation (3, 3) and origin (3, 1) [m] of ``frame`` in ``reference``; joints that carry both do not appear.

        Raises:
            UnknownNameError: when there is no such frame.
        """
        shared = 0
        there, here = self._robot.path(frame), self._robot.path(reference)
        while shared < min(len(there), len(here)) and there[shared] is here[shared]:
            shared += 1
        root = there[shared - 1].child if shared else self._robot.base
        seen, base = self._from(root, frame), self._from(root, reference)
        turn = base.rotation.matrix().T
        return turn @ seen.rotation.matrix(), turn @ (seen.origin - base.origin)

    def _from(self, root: str, frame: str) -> _Placement:
        """The frame placed in ``root``, a frame that carries it."""
        placed = _Placement(Rotation(), SX.zeros(3))
        path = self._robot.path(frame)
        for joint in path[len(self._robot.path(root)) :]:
            placed = self._moved(placed, joint)
        return placed

    def jacobian(self, frame: str | None = None) -> Expression:
        """The geometric Jacobian, shape (6, n): velocity of the frame's origin, then angular velocity.

        Both in base axes, of velocities v = dq/dt in the tangent space: [m/rad] or [m/m], then [rad/rad] or
        [rad/m]. The columns are the joints' axes and their moments, which is (dx/dq) T(q) written out.

        Raises:
            UnknownNameError: when there is no such frame.
        """
        frame = self._robot.frame(frame)
        if frame not in self._jacobians:
            self._jacobians[frame] = self._build_jacobian(frame)
        return self._jacobians[frame]

    def _build_jacobian(self, frame: str) -> Expression:
        columns = [SX.zeros(6) for _ in range(self._robot.n)]
        end = self._place(frame).origin
        for joint in self._robot.path(frame):
            if not joint.is_moving:
                continue
            gain = 1.0 if joint.mimic is None else joint.mimic.multiplier
            first = self._robot.v_slice(joint.name).start
            for offset, column in enumerate(self._columns(joint, end)):
                columns[first + offset] += gain * column
        return horzcat(SX(6, 0), *columns)  # still six rows where nothing moves

    def _columns(self, joint: Joint, end: Expression) -> Iterator[Expression]:
        placed = self._place(joint.child)
        arm = end - placed.origin
        none = SX.zeros(3)
        if joint.type is JointType.PRISMATIC:
            yield vertcat(placed.rotation.apply(joint.axis), none)
        elif joint.type is JointType.REVOLUTE:
            axis = placed.rotation.apply(joint.axis)
            yield vertcat(cross(axis, arm), axis)
        else:
            if joint.type is JointType.FREE:
                fixed = self._place(joint.parent).rotation.then_constant(joint.origin[:3, :3]).matrix()
                yield from (vertcat(fixed[:, k], none) for k in range(3))
            axes = self.rotation(joint.child)
            yield from (vertcat(cross(axes[:, k], arm), axes[:, k]) for k in range(3))

    def _place(self, frame: str) -> _Placement:
        for joint in self._robot.path(frame):
            if joint.child not in self._placements:
                self._placements[joint.child] = self._moved(self._placements[joint.parent], joint)
        return self._placements[frame]

    def _moved(self, parent: _Placement, joint: Joint) -> _Placement:
        rotation = parent.rotation.then_constant(joint.origin[:3, :3])
        origin = parent.origin + parent.rotation.apply(joint.origin[:3, 3])
        if joint.type is JointType.FIXED:
            return _Placement(rotation, origin)
        q = self._q[self._robot.q_slice(joint.name)]
        if joint.mimic is not None:
            q = joint.mimic.multiplier * q + joint.mimic.offset
        if joint.type is JointType.REVOLUTE:
            return _Placement(rotation.then_turn(joint.axis, q), origin)
        if joint.type is JointType.PRISMATIC:
            return _Placement(rotation, origin + rotation.apply(joint.axis) * q)
        if joint.type is JointType.BALL:
            return _Placement(rotation.then_matrix(quaternion.rotation_matrix(q)), origin)
        shifted = origin + rotation.matrix() @ q[:3]
        return _Placement(rotation.then_matrix(quaternion.rotation_matrix(q[3:])), shifted)

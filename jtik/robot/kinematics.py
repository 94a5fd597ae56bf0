"""Poses, positions and Jacobians of any frame, as expressions of one q, each built once and shared."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

from jtik.errors import ArgumentError
from jtik.robot import quaternion
from jtik.robot.dynamics import Dynamics, standard_gravity
from jtik.robot.joint_type import JointType
from jtik.robot.rotation import Rotation
from jtik.robot.row_indexing import by_rows
from jtik.robot.tree import Joint
from jtik.symbolic import SX, Expression, cross, horzcat, vertcat
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.robot.model import Robot


JacobianRows: TypeAlias = Literal["linear", "angular"] | None
"""Rows of a geometric Jacobian: those of the linear velocity, those of the angular velocity, or None for all six."""


def jacobian_rows(rows: JacobianRows, dimension: int) -> slice | None:
    """The indices of ``rows`` in a geometric Jacobian (6, n); None for all. Raises ArgumentError for anything else."""
    if rows is None:
        return None
    if isinstance(rows, str) and rows == "linear":
        return slice(0, dimension)
    if isinstance(rows, str) and rows == "angular":
        return slice(3 if dimension == 3 else 5, 6)
    raise ArgumentError("rows", rows, "'linear', 'angular', or None for all six")


@dataclass(frozen=True)
class _FramePose:
    """Where a frame is, in the base frame.

    Attributes:
        rotation: its orientation.
        origin: its origin (3, 1) [m].
    """

    rotation: Rotation
    origin: Expression


class Kinematics:
    """The kinematics of a robot at one symbolic configuration, made by `Robot.at`.

    Each expression is built once, so all tasks and criteria share it. `pose`, `rotation` and `jacobian` return
    matrices that a single index reads by rows, as NumPy does: ``J[:3]`` has shape (3, n). Results of operations on
    them are plain CasADi matrices.

    Args:
        robot: the robot.
        q: its configuration as symbols or an expression (nq, 1).
    """

    def __init__(self, robot: Robot, q: Expression) -> None:
        self._robot = robot
        self._q = q
        self._poses = {robot.base: _FramePose(Rotation(), SX.zeros(3))}
        self._rotations: dict[str, Expression] = {}
        self._jacobians: dict[str, Expression] = {}
        self._dynamics: Dynamics | None = None

    @property
    def robot(self) -> Robot:
        """The robot."""
        return self._robot

    @property
    def q(self) -> Expression:
        """The configuration, shape (nq, 1)."""
        return self._q

    def pose(self, frame: str | None = None) -> Expression:
        """T_base_frame, shape (4, 4) [m].

        Args:
            frame: name of the frame; the tip when None.

        Raises:
            UnknownNameError: when there is no such frame.
        """
        upper = horzcat(self._rotation(frame), self._pose_of(self._robot.frame(frame)).origin)
        return by_rows(vertcat(upper, SX([[0, 0, 0, 1]])))

    def rotation(self, frame: str | None = None) -> Expression:
        """R_base_frame, shape (3, 3).

        Args:
            frame: name of the frame; the tip when None.

        Raises:
            UnknownNameError: when there is no such frame.
        """
        return by_rows(self._rotation(frame))

    def _rotation(self, frame: str | None) -> Expression:
        frame = self._robot.frame(frame)
        if frame not in self._rotations:
            self._rotations[frame] = self._pose_of(frame).rotation.matrix()
        return self._rotations[frame]

    def position(self, frame: str | None = None) -> Expression:
        """The frame's origin in the base frame [m], shape (3, 1), or (2, 1) of a planar robot.

        Args:
            frame: name of the frame; the tip when None.

        Raises:
            UnknownNameError: when there is no such frame.
        """
        origin = self._pose_of(self._robot.frame(frame)).origin
        return origin[:2] if self._robot.dimension == 2 else origin

    def point(self, frame: str, offset: Array) -> Expression:
        """A point of a frame, in the base frame [m], shape (3, 1), or (2, 1) of a planar robot.

        Args:
            frame: name of the frame.
            offset: the point in that frame (3,) [m].

        Raises:
            UnknownNameError: when there is no such frame.
        """
        point = self.space_point(frame, offset)
        return point[:2] if self._robot.dimension == 2 else point

    def space_point(self, frame: str, offset: Array | None = None) -> Expression:
        """A point of a frame, in the base frame, shape (3, 1) [m] also of a planar robot.

        Args:
            frame: name of the frame.
            offset: the point in that frame (3,) [m]; its origin when None.

        Raises:
            UnknownNameError: when there is no such frame.
        """
        pose = self._pose_of(self._robot.frame(frame))
        return pose.origin if offset is None else pose.origin + pose.rotation.apply(offset)

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

    def gravity_torque(self, gravity: Expression | None = None) -> Expression:
        """The torques and forces (n, 1) [N m] and [N] with which the joints hold the robot against gravity.

        Args:
            gravity: gravity in the base frame (3, 1) [m/s^2], or (2, 1) of a planar robot; 9.81 along -z, or along -y
                of a planar robot, when None.

        Raises:
            ArgumentError: when no joint moves a mass.
        """
        g = standard_gravity(self._robot.dimension) if gravity is None else gravity
        return -self.first_moment_jacobian().T[:, : self._robot.dimension] @ g

    def first_moment_jacobian(self, _: str | None = None) -> Expression:
        """The derivative (3, n) of the mass times the centre of mass [kg m/rad] or [kg], without masses at rest.

        Raises:
            ArgumentError: when no joint moves a mass.
        """
        return self._with_masses().first_moment_jacobian()

    def mass_matrix(self, _: str | None = None) -> Expression:
        """The mass matrix M (n, n): 1/2 v' M v is the kinetic energy [J] at the velocity v.

        Entries are in [kg m^2] of two rotations, [kg] of two translations, [kg m] of one of each.

        Raises:
            ArgumentError: when no joint moves a mass.
        """
        return self._with_masses().mass_matrix()

    def kinetic_energy(self, v: Expression) -> Expression:
        """1/2 v' M v [J] at the velocity v (n, 1); the same as by `mass_matrix`, in fewer operations.

        Args:
            v: the velocity (n, 1) [rad/s] or [m/s].

        Raises:
            ArgumentError: when no joint moves a mass.
        """
        return self._with_masses().kinetic_energy(v)

    def _with_masses(self) -> Dynamics:
        if self._dynamics is None:
            self._dynamics = Dynamics(self)
        return self._dynamics

    def relative(self, frame: str, reference: str) -> tuple[Expression, Expression]:
        """The pose of one frame in another: rotation (3, 3) and origin (3, 1) [m].

        They do not depend on joints that carry both frames.

        Args:
            frame: name of the frame.
            reference: name of the frame in whose axes the pose is.

        Raises:
            UnknownNameError: when there is no such frame.
        """
        shared = 0
        path, other = self._robot.path(frame), self._robot.path(reference)
        while shared < min(len(path), len(other)) and path[shared] is other[shared]:
            shared += 1
        root = path[shared - 1].child if shared else self._robot.base
        moved, base = self._pose_in(root, frame), self._pose_in(root, reference)
        inverse = base.rotation.matrix().T
        return inverse @ moved.rotation.matrix(), inverse @ (moved.origin - base.origin)

    def _pose_in(self, root: str, frame: str) -> _FramePose:
        """The frame in ``root``, a frame that carries it."""
        pose = _FramePose(Rotation(), SX.zeros(3))
        path = self._robot.path(frame)
        for joint in path[len(self._robot.path(root)) :]:
            pose = self._after(pose, joint)
        return pose

    def jacobian(self, frame: str | None = None, *, rows: JacobianRows = None) -> Expression:
        """The geometric Jacobian: velocity of the frame's origin, then angular velocity.

        Both are in base axes, for velocities v = dq/dt in the tangent space: [m/rad] or [m/m], then [rad/rad] or
        [rad/m]. The columns are the joints' axes and their moments, which equals (dx/dq) T(q).

        Args:
            frame: name of the frame; the tip when None.
            rows: "linear" for the derivative of `position`, shape (3, n), or (2, n) of a planar robot; "angular" for
                the angular velocity, shape (3, n), or (1, n), about z, of a planar robot; None for all six, (6, n).

        Raises:
            ArgumentError: when ``rows`` is something else.
            UnknownNameError: when there is no such frame.
        """
        selected = jacobian_rows(rows, self._robot.dimension)
        J = self.plain_jacobian(frame)
        return by_rows(J if selected is None else J[selected, :])

    def plain_jacobian(self, frame: str | None = None) -> Expression:
        """The geometric Jacobian (6, n) as a plain ``casadi.SX``, without a copy: for the engine.

        CasADi reads ``J[:3]`` of it as three numbers; write ``J[:3, :]``.

        Args:
            frame: name of the frame; the tip when None.

        Raises:
            UnknownNameError: when there is no such frame.
        """
        frame = self._robot.frame(frame)
        if frame not in self._jacobians:
            self._jacobians[frame] = self._build_jacobian(frame)
        return self._jacobians[frame]

    def _build_jacobian(self, frame: str) -> Expression:
        columns = [SX.zeros(6) for _ in range(self._robot.n)]
        end = self._pose_of(frame).origin
        for joint in self._robot.path(frame):
            if not joint.is_moving:
                continue
            gain = 1.0 if joint.mimic is None else joint.mimic.multiplier
            first = self._robot.v_slice(joint.name).start
            for offset, column in enumerate(self.joint_columns(joint, end)):
                columns[first + offset] += gain * column
        return horzcat(SX(6, 0), *columns)  # SX(6, 0) keeps six rows when no joint moves

    def joint_columns(self, joint: Joint, end: Expression) -> Iterator[Expression]:
        """The columns (6, 1) of the Jacobian for a moving joint: for the engine.

        Args:
            joint: the joint.
            end: a point of a body that it moves, in the base frame (3, 1) [m].
        """
        pose = self._pose_of(joint.child)
        arm = end - pose.origin
        none = SX.zeros(3)
        if joint.type is JointType.PRISMATIC:
            yield vertcat(pose.rotation.apply(joint.axis), none)
        elif joint.type is JointType.REVOLUTE:
            axis = pose.rotation.apply(joint.axis)
            yield vertcat(cross(axis, arm), axis)
        else:
            if joint.type is JointType.FREE:
                fixed = self._pose_of(joint.parent).rotation.then_constant(joint.origin[:3, :3]).matrix()
                yield from (vertcat(fixed[:, k], none) for k in range(3))
            axes = self._rotation(joint.child)
            yield from (vertcat(cross(axes[:, k], arm), axes[:, k]) for k in range(3))

    def _pose_of(self, frame: str) -> _FramePose:
        for joint in self._robot.path(frame):
            if joint.child not in self._poses:
                self._poses[joint.child] = self._after(self._poses[joint.parent], joint)
        return self._poses[frame]

    def _after(self, parent: _FramePose, joint: Joint) -> _FramePose:
        rotation = parent.rotation.then_constant(joint.origin[:3, :3])
        origin = parent.origin + parent.rotation.apply(joint.origin[:3, 3])
        if joint.type is JointType.FIXED:
            return _FramePose(rotation, origin)
        q = self._q[self._robot.q_slice(joint.name)]
        if joint.mimic is not None:
            q = joint.mimic.multiplier * q + joint.mimic.offset
        if joint.type is JointType.REVOLUTE:
            return _FramePose(rotation.then_rotation(joint.axis, q), origin)
        if joint.type is JointType.PRISMATIC:
            return _FramePose(rotation, origin + rotation.apply(joint.axis) * q)
        if joint.type is JointType.BALL:
            return _FramePose(rotation.then_matrix(quaternion.rotation_matrix(q)), origin)
        shifted = origin + rotation.matrix() @ q[:3]
        return _FramePose(rotation.then_matrix(quaternion.rotation_matrix(q[3:])), shifted)

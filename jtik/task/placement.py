"""Base of the tasks on the position, the orientation or the pose of a frame, in the base or in another frame."""

from __future__ import annotations

from abc import abstractmethod
from types import MappingProxyType
from typing import Any, Literal, get_args

from numpy.typing import ArrayLike

from jtik.arguments import choice
from jtik.arguments import name as read_name
from jtik.robot import Kinematics, Robot
from jtik.robot.pose_input import FORMS
from jtik.symbolic import Expression, Function, atan2, cos, reshape, rigid_motion, rotation, sin, vertcat
from jtik.task.base import TaskRows
from jtik.task.targets import Kind, matrix_reader, read_fast, read_matrices, read_placement, unused_part
from jtik.task.weighted import Axes, WeightedTask, kept, named
from jtik.types import Array

ErrorForm = Literal["separate", "logarithm"]
"""Position and orientation each for itself, or the logarithm of the motion from the target to the frame."""

_ROTATION = "a matrix (3, 3), a quaternion (w, x, y, z), or a rotation of one of these libraries"
_ACCEPTED = {
    "position": f"(x, y, z) [m], or a pose: {FORMS}; of a pose only the position is used",
    "orientation": f"a rotation: {_ROTATION}; or a pose: {FORMS}; of a pose only the orientation is used",
    "pose": f"a pose: {FORMS}, where the rotation is {_ROTATION}",
}
_ACCEPTED_IN_THE_PLANE = {
    "position": f"(x, y) [m], or a pose: {FORMS}; of a pose only the position is used",
    "orientation": f"an angle [rad], a rotation about z, or a pose: {FORMS}; of a pose only the orientation is used",
    "pose": f"(x, y, angle) [m, rad], or a pose: {FORMS}",
}


class PlacementTask(WeightedTask):
    """Base of tasks on the position p [m] and the rotation R of a frame, in the base or in another frame.

    Error "separate": ``p(q) - p_target`` [m] and the logarithm of ``R_target' R(q)`` [rad]. Error "logarithm": that of
    the motion from the target's pose to (R, p). On a planar robot a position is (x, y) and an orientation is one angle,
    with an error in (-pi, pi]. A subclass defines (R, p) by `placement`.

    Args:
        frame: name of the frame that the task places.
        kind: "position", "orientation" or "pose".
        axes: the rows that are kept, by the names of their axes; None for all of the kind.
        error: "separate" or "logarithm".
    """

    _renamed = MappingProxyType({"placed": "placement"})

    def __init__(
        self,
        frame: str,
        kind: Kind,
        *,
        axes: Axes,
        stiffness: ArrayLike,
        priority: int,
        name: str | None,
        error: ErrorForm = "separate",
    ) -> None:
        choice("kind", kind, get_args(Kind))
        choice("error", error, get_args(ErrorForm))
        self.frame = read_name("frame", frame)
        super().__init__(stiffness=stiffness, priority=priority, name=self.frame if name is None else name)
        self.kind: Kind = kind
        self.axes = named(axes)
        self.error: ErrorForm = error

    @property
    def target_kind(self) -> Kind:
        """The part of a pose that a target has: ``kind``, but a whole pose for the position part of a logarithm."""
        return "pose" if self.error == "logarithm" and self.kind == "position" else self.kind

    def geometric_jacobian(self, kinematics: Kinematics) -> Expression | None:
        """The geometric Jacobian (6, n) of (R, p), in the axes of the target, linear rows first; None if not known.

        Args:
            kinematics: the robot at a symbolic configuration.
        """
        return None

    @abstractmethod
    def placement(self, kinematics: Kinematics) -> tuple[Expression, Expression]:
        """The rotation R (3, 3) and the position p [m], (3, 1), or (2, 1) on a planar robot, that the target is for.

        Args:
            kinematics: the robot at a symbolic configuration.
        """

    def frames(self, robot: Robot) -> tuple[str, ...]:
        """The frame of the task."""
        return (self.frame,)

    def target_size(self, robot: Robot) -> int:
        """2 or 3 numbers of a position, 1 angle or 9 entries of R of an orientation, both of a pose."""
        position, orientation = (2, 1) if robot.dimension == 2 else (3, 9)
        return {"position": position, "orientation": orientation, "pose": position + orientation}[self.target_kind]

    def target_is_vector(self, robot: Robot) -> bool:
        """True for positions, and for every kind on a planar robot."""
        return self.target_kind == "position" or robot.dimension == 2

    def matrix_reader(self, robot: Robot) -> Function | None:
        """That of the kind, for a robot in space."""
        return matrix_reader(self.target_kind) if robot.dimension == 3 else None

    def read_matrices(self, robot: Robot, targets: Array) -> Array | None:
        """Those of the kind, for a robot in space."""
        return read_matrices(targets, self.target_kind) if robot.dimension == 3 else None

    def accepted(self, robot: Robot) -> str:
        """What a target may be, for error messages.

        Args:
            robot: the robot.
        """
        return (_ACCEPTED_IN_THE_PLANE if robot.dimension == 2 else _ACCEPTED)[self.target_kind]

    def read_target(self, robot: Robot, target: Any) -> Array:
        """The numbers of a target in any form that `jtik.task.targets` reads.

        Raises:
            ArgumentError: for anything else.
        """
        kind = self.target_kind
        numbers = read_fast(target, kind) if robot.dimension == 3 else None
        return read_placement(target, kind, robot.dimension, self.accepted(robot)) if numbers is None else numbers

    def unused(self, robot: Robot, target: Any) -> str | None:
        """The orientation of a pose given to a position task, the position of a pose given to an orientation task."""
        return unused_part(target, self.target_kind)

    def held_target(self, kinematics: Kinematics) -> Expression:
        """The placement itself, as the numbers of a target."""
        R, p = self.placement(kinematics)
        turn = atan2(R[1, 0], R[0, 0]) if kinematics.robot.dimension == 2 else reshape(R, 9, 1)
        return {"position": p, "orientation": turn, "pose": vertcat(p, turn)}[self.target_kind]

    def rows(self, kinematics: Kinematics, target: Expression) -> TaskRows:
        """Position rows in the axes of the target's frame of reference, orientation rows in the axes of the target.

        All rows of a logarithm are in the axes of the target.
        """
        robot = kinematics.robot
        rows = self._kept(robot)
        R, p = self.placement(kinematics)
        split = 0 if self.kind == "orientation" else robot.dimension
        near = None
        if self.error == "logarithm" and self.kind != "orientation":
            error, J = self._logarithm(kinematics, target, R, p)
        else:
            parts = []
            if self.kind != "orientation":
                parts.append(p - target[:split])
            if self.kind != "position":
                parts.append(_orientation_error(R, target[split:], robot.dimension))
            error = vertcat(*parts)
            J = self._jacobian(kinematics, target, error) if robot.dimension == 3 else None
            near = None if J is None else self._near_jacobian(kinematics, target)
        return TaskRows(
            error=vertcat(*[error[row] for row in rows]),
            linear=tuple(row < split for row in rows),
            jacobian=None if J is None else vertcat(*[J[row, :] for row in rows]),
            near_jacobian=None if near is None else vertcat(*[near[row, :] for row in rows]),
        )

    def _jacobian(self, kinematics: Kinematics, target: Expression, error: Expression) -> Expression | None:
        """The derivative of all rows in space, in closed form: a tenth of the operations of CasADi's derivative."""
        J = self.geometric_jacobian(kinematics)
        if J is None or self.kind == "position":
            return None if J is None else J[:3, :]
        R_target = reshape(target[-9:], 3, 3)
        angular = rotation.log_rate(error[-3:]) @ R_target.T @ J[3:, :]
        return angular if self.kind == "orientation" else vertcat(J[:3, :], angular)

    def _near_jacobian(self, kinematics: Kinematics, target: Expression) -> Expression | None:
        """The same without the derivative of the logarithm by the rotation, which leaves the logarithm as it is.

        So J'e is that of the Jacobian, where a task has all rows of the rotation.
        """
        J = self.geometric_jacobian(kinematics)
        if J is None or self.kind == "position":
            return None
        angular = reshape(target[-9:], 3, 3).T @ J[3:, :]
        return angular if self.kind == "orientation" else vertcat(J[:3, :], angular)

    def _logarithm(
        self, kinematics: Kinematics, target: Expression, R: Expression, p: Expression
    ) -> tuple[Expression, Expression | None]:
        """All rows of the logarithm of the motion from the target to (R, p), and in space their derivative."""
        dimension = kinematics.robot.dimension
        away, goal = p - target[:dimension], target[dimension:]
        turn = _orientation_error(R, goal, dimension)
        if dimension == 2:
            c, s = cos(goal[0]), sin(goal[0])
            away = vertcat(c * away[0] + s * away[1], c * away[1] - s * away[0])
            moved = rigid_motion.log_translation_in_the_plane(turn, away)
            return (moved if self.kind == "position" else vertcat(moved, turn)), None
        R_target = reshape(goal, 3, 3)
        away = R_target.T @ away
        moved = rigid_motion.log_translation(turn, away)
        J, linear, angular = self.geometric_jacobian(kinematics), None, None
        if J is not None:
            G = rotation.log_rate(turn)
            angular = G @ R_target.T @ J[3:, :]
            linear = G @ R_target.T @ J[:3, :] + rigid_motion.log_translation_rate(turn, away) @ angular
        if self.kind == "position":
            return moved, linear
        return vertcat(moved, turn), None if linear is None else vertcat(linear, angular)

    def row_count(self, robot: Robot) -> int:
        """One row for each of ``axes``; all rows of the kind without ``axes``."""
        return len(self._kept(robot))

    def _kept(self, robot: Robot) -> list[int]:
        """Indices of the rows to keep among all rows of the kind on this robot."""
        position = [*"xyz"[: robot.dimension]]
        orientation = ["rz"] if robot.dimension == 2 else ["rx", "ry", "rz"]
        names = {"position": position, "orientation": orientation, "pose": position + orientation}[self.kind]
        return kept(self.axes, names, f" for kind {self.kind!r}")


def _orientation_error(R: Expression, target: Expression, dimension: int) -> Expression:
    """Rotation from the target to ``R`` in the target's axes: one angle in the plane, a rotation vector in space."""
    if dimension == 2:
        c, s = cos(target[0]), sin(target[0])
        return atan2(R[1, 0] * c - R[0, 0] * s, R[0, 0] * c + R[1, 0] * s)
    return rotation.log(reshape(target, 3, 3).T @ R)

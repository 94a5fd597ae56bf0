"""Tasks on where a frame is: its position, its orientation, or both, seen from the base or from another frame."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

from numpy.typing import ArrayLike

from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, atan2, cos, reshape, rotation, sin, vertcat
from jtik.task.base import TaskRows
from jtik.task.targets import Kind, read_placement, usual
from jtik.task.weighted import Axes, WeightedTask, kept, named
from jtik.types import Array

_PLAIN = {
    "position": "(x, y, z) [m]",
    "orientation": "a rotation matrix (3, 3), a quaternion (w, x, y, z)",
    "pose": "a pair (position [m], quaternion (w, x, y, z))",
}
_PLAIN_IN_THE_PLANE = {
    "position": "(x, y) [m]",
    "orientation": "an angle [rad]",
    "pose": "(x, y, angle) [m, rad]",
}


class PlacementTask(WeightedTask):
    """Error ``p(q) - p_target`` [m] and the logarithm of ``R_target' R(q)`` [rad] of a frame placed in some other.

    A subclass says by `placed` which placement (R, p) is meant. On a planar robot a position is (x, y) and an
    orientation is one angle, with an error in (-pi, pi].
    """

    def __init__(
        self, frame: str, kind: Kind, *, axes: Axes, stiffness: ArrayLike, priority: int, name: str | None
    ) -> None:
        if kind not in ("position", "orientation", "pose"):
            raise ArgumentError("kind", kind, "'position', 'orientation' or 'pose'")
        super().__init__(stiffness=stiffness, priority=priority, name=name or frame)
        self.frame = frame
        self.kind: Kind = kind
        self.axes = named(axes)

    def geometric_jacobian(self, kinematics: Kinematics) -> Expression | None:
        """Of what `placed` gives, (6, n), in the axes the target is given in, linear rows first; if it is known."""
        return None

    @abstractmethod
    def placed(self, kinematics: Kinematics) -> tuple[Expression, Expression]:
        """Rotation (3, 3) and position (3, 1) or, on a planar robot, (2, 1) [m] that the target is for."""

    def frames(self, robot: Robot) -> tuple[str, ...]:
        """The one."""
        return (self.frame,)

    def target_size(self, robot: Robot) -> int:
        """Position: 2 or 3; orientation: 1 angle or 9 entries of R; pose: both."""
        position, orientation = (2, 1) if robot.dimension == 2 else (3, 9)
        return {"position": position, "orientation": orientation, "pose": position + orientation}[self.kind]

    def plain(self, robot: Robot) -> bool:
        """Positions are, and everything in the plane."""
        return self.kind == "position" or robot.dimension == 2

    def accepted(self, robot: Robot) -> str:
        """What a target may be, in words."""
        plain = (_PLAIN_IN_THE_PLANE if robot.dimension == 2 else _PLAIN)[self.kind]
        return f"{plain}, a pose (4, 4), or an object with as_matrix()"

    def read_target(self, robot: Robot, target: Any) -> Array:
        """A position, angle, rotation or pose in any form `jtik.task.targets` knows, as the task's numbers."""
        numbers = usual(target, self.kind) if robot.dimension == 3 else None
        return read_placement(target, self.kind, robot.dimension, self.accepted(robot)) if numbers is None else numbers

    def rows(self, kinematics: Kinematics, target: Expression) -> TaskRows:
        """Position rows in the axes of the target's frame of reference, orientation rows in the target's axes."""
        robot = kinematics.robot
        rows = self._kept(robot)
        R, p = self.placed(kinematics)
        split = 0 if self.kind == "orientation" else robot.dimension
        parts = []
        if self.kind != "orientation":
            parts.append(p - target[:split])
        if self.kind != "position":
            parts.append(_turn(R, target[split:], robot.dimension))
        error = vertcat(*parts)
        J = self._jacobian(kinematics, target, error) if robot.dimension == 3 else None
        return TaskRows(
            error=vertcat(*[error[row] for row in rows]),
            linear=tuple(row < split for row in rows),
            jacobian=None if J is None else vertcat(*[J[row, :] for row in rows]),
        )

    def _jacobian(self, kinematics: Kinematics, target: Expression, error: Expression) -> Expression | None:
        """The derivative of all rows in space, through that of the logarithm; a tenth of what CasADi would generate."""
        J = self.geometric_jacobian(kinematics)
        if J is None or self.kind == "position":
            return None if J is None else J[:3, :]
        R_target = reshape(target[-9:], 3, 3)
        turning = rotation.log_rate(error[-3:]) @ R_target.T @ J[3:, :]
        return turning if self.kind == "orientation" else vertcat(J[:3, :], turning)

    def row_count(self, robot: Robot) -> int:
        """One for each of ``axes``, or all that the kind has."""
        return len(self._kept(robot))

    def _kept(self, robot: Robot) -> list[int]:
        """Places of the rows to keep among all that the kind has on this robot."""
        position = [*"xyz"[: robot.dimension]]
        orientation = ["rz"] if robot.dimension == 2 else ["rx", "ry", "rz"]
        names = {"position": position, "orientation": orientation, "pose": position + orientation}[self.kind]
        return kept(self.axes, names, f" for kind {self.kind!r}")


def _turn(R: Expression, target: Expression, dimension: int) -> Expression:
    """Rotation from the target to ``R``, in the target's axes: one angle in the plane, a rotation vector in space."""
    if dimension == 2:
        c, s = cos(target[0]), sin(target[0])
        return atan2(R[1, 0] * c - R[0, 0] * s, R[0, 0] * c + R[1, 0] * s)
    return rotation.log(reshape(target, 3, 3).T @ R)

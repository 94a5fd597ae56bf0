"""An axis of a frame that points at a point: the optical axis of a camera, the beam of a lamp."""

from __future__ import annotations

from typing import Any

from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression
from jtik.task.pointing import PointingTask
from jtik.task.targets import read_fast, read_placement, unused_part
from jtik.types import Array


class LookAtTask(PointingTask):
    """Rotate and move a frame so that one of its axes points at a target.

    Prefer `AxisTask` for a given direction.

    Error: the shortest rotation from the line of sight to the axis [rad], in the axes of the frame; see `AxisTask`. The
    line of sight goes from the frame's origin to the target, so moving the origin changes the error, too. The error is
    zero for a target within 1e-9 m of the origin: every axis points at it.

    A target is a point (x, y, z) [m] in the base frame, or (x, y) on a planar robot. It may also be a pose in any form
    that `FrameTask` accepts; of a pose only the position is used.

    Args:
        frame: name of the frame.
        axis: the axis that points, in coordinates of the frame, (3,), or (x, y); it is normalised.
        stiffness: a positive scalar, one value for each row, or a symmetric positive definite matrix (2, 2).
        priority: level for strategies with levels of priority; 0 is the highest.
        name: name of the task in a dict of targets; the name of the frame by default.

    Raises:
        ArgumentError: when the axis is zero or not a direction, or the priority or the stiffness cannot be used.

    Example:
        >>> ik = jtik.InverseKinematics(jtik.Robot.builtin("panda"), jtik.LookAtTask("tip"))
        >>> ik.solve([0.6, 0.2, 0.0]).status.name  # the z axis of the tip points at it
        'CONVERGED'
    """

    def target_is_vector(self, robot: Robot) -> bool:
        """True: a point is read as it is."""
        return True

    def read_target(self, robot: Robot, target: Any) -> Array:
        """The point, or the position of a pose in any of its forms.

        Raises:
            ArgumentError: for anything else.
        """
        numbers = read_fast(target, "position") if robot.dimension == 3 else None
        if numbers is None:
            point = f"a point ({', '.join('xyz'[: robot.dimension])}) [m]"
            accepted = f"{point}, or a pose (4, 4), of which only the position is used"
            numbers = read_placement(target, "position", robot.dimension, accepted)
        return numbers

    def unused(self, robot: Robot, target: Any) -> str | None:
        """The orientation of a pose."""
        return unused_part(target, "position")

    def direction(self, kinematics: Kinematics, target: Expression) -> Expression:
        """The line of sight [m]."""
        return target - kinematics.position(self.frame)

    def direction_jacobian(self, kinematics: Kinematics) -> Expression:
        """The negative linear rows of the Jacobian of the frame's origin."""
        return -kinematics.plain_jacobian(self.frame)[:3, :]

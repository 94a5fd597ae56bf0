"""An axis of a frame brought to a direction in the base frame: an upright cup, a drill normal to a wall."""

from __future__ import annotations

import math
from typing import Any

from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.robot.pose_input import as_numbers
from jtik.symbolic import Expression
from jtik.task.pointing import SHORTEST, PointingTask
from jtik.types import Array


class AxisTask(PointingTask):
    """Rotate an axis of a frame to a direction in the base frame; the rotation about the axis stays free.

    Prefer `FrameTask` where the full orientation matters, and `LookAtTask` for a target point.

    Error: the shortest rotation from the target direction to the axis [rad], in the axes of the frame. Its length is
    the angle between the two, in [0, pi]. With ``axis`` z the rows are rotations about the frame's x and y axes. At pi
    every rotation is equally short, and the one about the first row's axis is taken. On a planar robot the axis is in
    the plane, and the error is one angle in (-pi, pi].

    A target is a direction (3,) in the base frame, or (x, y) on a planar robot, of any length but zero.

    Args:
        frame: name of the frame.
        axis: the axis in coordinates of the frame, (3,), or (x, y); it is normalised.
        stiffness: a positive scalar, one value for each row, or a symmetric positive definite matrix (2, 2).
        priority: level for strategies with levels of priority; 0 is the highest.
        name: name of the task in a dict of targets; the name of the frame by default.

    Raises:
        ArgumentError: when the axis is zero or not a direction, or the priority or the stiffness cannot be used.

    Example:
        >>> panda = jtik.Robot.builtin("panda")
        >>> tasks = [jtik.FrameTask("tip", kind="position", name="where"), jtik.AxisTask("tip", name="down")]
        >>> ik = jtik.InverseKinematics(panda, tasks)
        >>> solution = ik.solve({"where": [0.4, 0.1, 0.4], "down": [0.0, 0.0, -1.0]}, restarts=5)
    """

    def read_target(self, robot: Robot, target: Any) -> Array:
        """The direction, normalised.

        Raises:
            ArgumentError: for anything that is not a direction.
        """
        accepted = f"a direction ({', '.join('xyz'[: robot.dimension])}), not zero"
        direction = as_numbers(target, target, accepted)
        if direction.shape != (robot.dimension,):
            raise ArgumentError("target", target, accepted)
        length = math.hypot(*direction.tolist())
        if not SHORTEST <= length < math.inf:
            raise ArgumentError("target", target, accepted)
        return direction / length

    def held_target(self, kinematics: Kinematics) -> Expression:
        """The direction of the axis."""
        return (kinematics.rotation(self.frame) @ self.axis)[: kinematics.robot.dimension]

    def direction(self, kinematics: Kinematics, target: Expression) -> Expression:
        """The target direction."""
        return target

"""An axis of a frame that points at a point of the world: a camera's gaze, a lamp's beam."""

from __future__ import annotations

from typing import Any

from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression
from jtik.task.pointing import PointingTask
from jtik.task.targets import read_placement, usual
from jtik.types import Array


class LookAtTask(PointingTask):
    """Turn and move a frame so that one of its axes points at a target.

    Error: the shortest rotation from the line of sight to the axis [rad], in the frame's axes; see `AxisTask`. The
    line of sight goes from the frame's origin to the target, so that moving the origin counts, too. A target on top
    of the origin (within a nanometre) is looked at by every axis: the error is zero.

    A target is a point (3,) in the world [m], or (x, y) on a planar robot; a pose counts as its position.

    Args:
        frame: name of the frame.
        axis: the axis that looks, in coordinates of the frame, (3,), or (x, y); normalised.
        stiffness: a positive scalar, one value a row, or an SPD matrix (2, 2).
        priority: level for the strategies that know levels; 0 is the highest.
        name: how a dict of targets refers to the task; the frame's name by default.

    Raises:
        ArgumentError: for an axis that is zero or no direction, and a priority or stiffness that cannot be used.
    """

    def plain(self, robot: Robot) -> bool:
        """A point is."""
        return True

    def read_target(self, robot: Robot, target: Any) -> Array:
        """The point, or the position of a pose in any of its forms."""
        numbers = usual(target, "position") if robot.dimension == 3 else None
        if numbers is None:
            accepted = f"a point ({', '.join('xyz'[: robot.dimension])}) [m], or a pose (4, 4)"
            numbers = read_placement(target, "position", robot.dimension, accepted)
        return numbers

    def wanted(self, kinematics: Kinematics, target: Expression) -> Expression:
        """The line of sight [m]."""
        return target - kinematics.position(self.frame)

    def swing(self, kinematics: Kinematics) -> Expression:
        """Against the motion of the frame's origin."""
        return -kinematics.plain_jacobian(self.frame)[:3, :]

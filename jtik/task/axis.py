"""An axis of a frame turned into a direction of the world: an upright cup, a drill normal to a wall."""

from __future__ import annotations

import math
from typing import Any

from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression
from jtik.task.pointing import SHORTEST, PointingTask
from jtik.task.targets import as_numbers
from jtik.types import Array


class AxisTask(PointingTask):
    """Turn an axis of a frame into a direction of the world, whatever the spin about it: 2 degrees of freedom.

    Error: the shortest rotation from the target direction to the axis [rad], in the frame's axes. Its length is the
    angle between the two, from 0 to pi. With ``axis`` z the rows are turns about the frame's x and y. At pi, where
    every way round is as short, the way about the first row's axis is taken. On a planar robot the axis is in the
    plane, and the error is one angle in (-pi, pi].

    A target is a direction (3,) in the world, or (x, y) on a planar robot, of any length but zero.

    Args:
        frame: name of the frame.
        axis: the axis in coordinates of the frame, (3,), or (x, y); normalised.
        stiffness: a positive scalar, one value a row, or an SPD matrix (2, 2).
        priority: level for the strategies that know levels; 0 is the highest.
        name: how a dict of targets refers to the task; the frame's name by default.

    Raises:
        ArgumentError: for an axis that is zero or no direction, and a priority or stiffness that cannot be used.
    """

    def read_target(self, robot: Robot, target: Any) -> Array:
        """The direction, normalised."""
        accepted = f"a direction ({', '.join('xyz'[: robot.dimension])}), not zero"
        direction = as_numbers(target, target, accepted)
        if direction.shape != (robot.dimension,):
            raise ArgumentError("target", target, accepted)
        length = math.hypot(*direction.tolist())
        if not SHORTEST <= length < math.inf:
            raise ArgumentError("target", target, accepted)
        return direction / length

    def wanted(self, kinematics: Kinematics, target: Expression) -> Expression:
        """The target."""
        return target

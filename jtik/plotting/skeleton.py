"""Positions of the ends of all links of a robot, from one compiled function."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError
from jtik.robot import Robot
from jtik.symbolic import function, symbol, vertcat
from jtik.types import Array


class Skeleton:
    """Positions of the ends of a robot's links, by one compiled function.

    Args:
        robot: the robot; its ``segments`` are the links.

    Attributes:
        robot: the robot.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        q = symbol("q", robot.nq)
        kinematics = robot.at(q)
        ends = [kinematics.position(frame) for pair in robot.segments for frame in pair]
        self._function = function("skeleton", [q], [vertcat(*ends)])

    def links(self, q: ArrayLike) -> Array:
        """Both ends of every link.

        Args:
            q: one configuration (nq,) or several (k, nq).

        Returns:
            Positions [m]: (links, 2, dimension) for one configuration, (k, links, 2, dimension) for several.

        Raises:
            ArgumentError: when q has another shape.
        """
        array = np.asarray(q, dtype=float)
        robot = self.robot
        if array.ndim not in (1, 2) or array.shape[-1] != robot.nq:
            raise ArgumentError("q", f"shape {array.shape}", f"shape ({robot.nq},) or (any, {robot.nq})")
        ends = self._function(array.reshape(-1, robot.nq).T).full().T
        return np.array(ends).reshape(*array.shape[:-1], len(robot.segments), 2, robot.dimension)

"""Positions of the ends of all links of a robot, from one compiled function."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import array_of, instance
from jtik.constructors import Constructed
from jtik.robot import Robot
from jtik.symbolic import function, symbol, vertcat
from jtik.types import Array


class Skeleton(metaclass=Constructed):
    """Positions of the ends of a robot's links, by one compiled function.

    Args:
        robot: the robot; its ``segments`` are the links.

    Attributes:
        robot: the robot.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = instance("robot", robot, Robot, "a jtik.Robot")
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
        robot = self.robot
        array = array_of("q", q, [(robot.nq,), (None, robot.nq)], f"shape ({robot.nq},) or (any, {robot.nq})")
        ends = self._function(array.reshape(-1, robot.nq).T).full().T
        return np.array(ends).reshape(*array.shape[:-1], len(robot.segments), 2, robot.dimension)

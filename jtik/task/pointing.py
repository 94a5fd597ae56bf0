"""Base of the tasks on the direction of an axis of a frame.

The error is the shortest rotation from the desired direction to the axis, in coordinates of the frame. It is orthogonal
to the axis, so it has two rows. Derivation: formulations/tasks.md, (T5) to (T9).
"""

from __future__ import annotations

import math
from abc import abstractmethod
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import array_of
from jtik.arguments import name as read_name
from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import (
    Expression,
    atan2,
    dot,
    if_else,
    jacobian,
    logic_and,
    skew,
    sqrt,
    substitute,
    sumsqr,
    symbol,
    vertcat,
    zeros,
)
from jtik.task.base import TaskRows
from jtik.task.weighted import WeightedTask
from jtik.types import Array

SHORTEST = 1e-12
"""A given direction shorter than this counts as zero and is refused."""

MET = 1e-9
"""A desired direction shorter than this [m] counts as none: the error is zero for every axis."""

NARROW = 1e-6
"""Sine of the angle to the axis below which a polynomial replaces the error, at both 0 and pi."""


class PointingTask(WeightedTask):
    """Base of tasks that rotate an axis of a frame to a direction: 2 rows [rad] in space, 1 in the plane.

    A subclass defines the direction by `direction`.

    Args:
        frame: name of the frame.
        axis: the axis in coordinates of the frame, (3,), or (x, y); it is normalised.
        stiffness: a positive scalar, one value for each row, or a symmetric positive definite matrix (2, 2).
        priority: level for strategies with levels of priority; 0 is the highest.
        name: name of the task in a dict of targets; the name of the frame by default.

    Raises:
        ArgumentError: when the axis is zero or not a direction, or the priority or the stiffness cannot be used.
    """

    _renamed = MappingProxyType({"wanted": "direction", "swing": "direction_jacobian"})

    def __init__(
        self,
        frame: str = "tip",
        axis: ArrayLike = (0.0, 0.0, 1.0),
        *,
        stiffness: ArrayLike = 1.0,
        priority: int = 0,
        name: str | None = None,
    ) -> None:
        self.frame = read_name("frame", frame)
        super().__init__(stiffness=stiffness, priority=priority, name=self.frame if name is None else name)
        accepted = "a direction (x, y, z) in the frame, or (x, y), not zero"
        given = array_of("axis", axis, [(2,), (3,)], accepted)
        length = math.hypot(*given.tolist())
        if not SHORTEST <= length < math.inf:
            raise ArgumentError("axis", axis, accepted)
        self.axis = np.zeros(3)
        self.axis[: len(given)] = given / length

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.frame!r}, axis={self.axis.tolist()})"

    @abstractmethod
    def direction(self, kinematics: Kinematics, target: Expression) -> Expression:
        """The desired direction in base axes, of any length, (3, 1), or (2, 1) on a planar robot.

        Args:
            kinematics: the robot at a symbolic configuration.
            target: the numbers of a target as symbols (target_size, 1).
        """

    def direction_jacobian(self, kinematics: Kinematics) -> Expression:
        """Derivative of `direction` with respect to the velocity, (3, n), on a robot in space; zero by default.

        Args:
            kinematics: the robot at a symbolic configuration.
        """
        return zeros(3, kinematics.robot.n)

    def frames(self, robot: Robot) -> tuple[str, ...]:
        """The frame of the axis."""
        return (self.frame,)

    def target_size(self, robot: Robot) -> int:
        """2 on a planar robot, else 3."""
        return robot.dimension

    def rows(self, kinematics: Kinematics, target: Expression) -> TaskRows:
        """The rotation from the desired direction to the axis, zero where there is no direction; (T5) to (T9).

        Raises:
            ArgumentError: for an axis out of the plane of a planar robot.
        """
        size = kinematics.robot.dimension
        if size == 2 and self.axis[2] != 0:
            raise ArgumentError("axis", self.axis.tolist(), "an axis in the plane of this planar robot, such as (1, 0)")
        direction = self.direction(kinematics, target)
        squared = sumsqr(direction)
        none = squared < MET**2
        length = sqrt(if_else(none, 1, squared))
        R = kinematics.rotation(self.frame)[:size, :size]
        in_frame = if_else(none, vertcat(*self.axis[:size]), R.T @ direction / length)
        if size == 2:
            x, y = self.axis[:2]
            return TaskRows(atan2(in_frame[0] * y - in_frame[1] * x, in_frame[0] * x + in_frame[1] * y), (False,))
        u = symbol("u", 3)
        error = rotation_onto(self.axis, u)
        rate = substitute(jacobian(error, u), u, in_frame)
        angular = R.T @ kinematics.plain_jacobian(self.frame)[3:, :]
        moving = R.T @ self.direction_jacobian(kinematics) / length
        J = rate @ (skew(in_frame) @ angular + moving - in_frame @ (in_frame.T @ moving))
        return TaskRows(substitute(error, u, in_frame), (False, False), if_else(none, 0, J))

    def row_count(self, robot: Robot) -> int:
        """1 on a planar robot, else 2."""
        return robot.dimension - 1


def rotation_onto(axis: Array, direction: Expression) -> Expression:
    """The shortest rotation vector from the unit vector ``direction`` (3, 1) to the numeric unit vector ``axis``.

    Coordinates (2, 1) [rad] in the basis `across` of the plane orthogonal to the axis. For opposite directions every
    rotation is equally short, and the one about the first basis vector is taken.
    """
    first, second = across(axis)
    s1, s2, c = dot(direction, first), dot(direction, second), dot(direction, axis)
    squared = s1**2 + s2**2
    narrow = squared < NARROW**2
    sine = sqrt(if_else(narrow, 1, squared))
    factor = if_else(narrow, 1 + squared / 6, atan2(sine, c) / sine)
    opposite = logic_and(narrow, c < 0)
    at_pi = vertcat(math.pi - s2 - s1**2, -s1)  # decreases to first order along s2, to second order along s1
    return if_else(opposite, at_pi, factor * vertcat(s2, -s1))


def across(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors that form a right-handed basis with the unit vector ``axis``: x and y for z, cyclically."""
    along = int(np.argmax(np.abs(axis)))
    start = np.eye(3)[(along + 1) % 3]
    first = start - axis * axis[(along + 1) % 3]
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)

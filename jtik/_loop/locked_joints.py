"""Configurations of a solver's robot, and of the full robot, most of whose joints may be locked."""

from __future__ import annotations

import warnings
from collections.abc import Iterable

from numpy.typing import ArrayLike

from jtik.errors import ArgumentError
from jtik.robot import Robot
from jtik.task import Task, TaskStack
from jtik.task.reduction import reduced
from jtik.types import Array


class LockedJoints:
    """Base of a solver that moves some joints of a robot and locks the others.

    Attributes:
        robot: the robot with only the joints that move.
        tasks: the tasks.
    """

    robot: Robot
    tasks: TaskStack
    _full: Robot
    _locked: Array

    def _lock(
        self, robot: object, task: Task | Iterable[Task], joints: str | Iterable[str] | None, at: ArrayLike | None
    ) -> None:
        """Lock all joints that do not move; arguments as of `InverseKinematics`."""
        if not isinstance(robot, Robot):
            raise ArgumentError("robot", robot, "a jtik.Robot")
        self._full = robot
        self._locked = robot.neutral if at is None else robot.configuration(at, argument="at")
        self.robot, self.tasks = reduced(robot, task, joints, self._locked)

    def full_configuration(self, q: ArrayLike) -> Array:
        """The configuration of the full robot, with its locked joints, for a ``q`` of `robot`.

        Args:
            q: configuration of `robot`, (nq,).

        Raises:
            ArgumentError: for a wrong shape, NaN or infinity.
        """
        return self.robot.configuration(q) if self.robot is self._full else self.robot.full_configuration(q)

    def reduced(self, q: ArrayLike) -> Array:
        """The configuration of `robot` within a ``q`` of the full robot; the locked joints are left out.

        Args:
            q: configuration of the robot that this solver was given.

        Raises:
            ArgumentError: for a wrong shape, NaN or infinity.
        """
        return self.robot.configuration(q) if self.robot is self._full else self.robot.reduced(q)

    def whole(self, q: ArrayLike) -> Array:
        """Deprecated: use `full_configuration`.

        Args:
            q: configuration of the reduced robot (nq,).
        """
        message = "InverseKinematics.whole is deprecated: use full_configuration"
        warnings.warn(message, DeprecationWarning, stacklevel=2)
        return self.full_configuration(q)

"""The centre of mass brought to a point, or above one: balance."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.robot.pose_input import as_numbers
from jtik.symbolic import Expression, vertcat
from jtik.task.base import TaskRows
from jtik.task.weighted import Axes, WeightedTask, kept, named
from jtik.types import Array


class CenterOfMassTask(WeightedTask):
    """Bring the centre of mass of the full robot to a target point.

    With ``axes="xy"`` the centre of mass is kept above a point of the floor and its height stays free: balance.

    Error: ``c(q) - c_target`` [m] in base axes, of a robot with masses.

    A target is a point (x, y, z) [m], of which only the chosen axes are used; or the coordinates of the chosen axes
    alone, in the order of ``axes``. On a planar robot a point is (x, y).

    Args:
        axes: which of "x", "y", "z" to keep; None keeps all.
        stiffness: a positive scalar, one value for each row, or a symmetric positive definite matrix (m, m).
        priority: level for strategies with levels of priority; 0 is the highest.
        name: name of the task in a dict of targets.

    Raises:
        ArgumentError: when the priority or the stiffness cannot be used; later, for a robot without masses.

    Example:
        >>> arm = jtik.Robot.planar(3).with_masses({"link2": 1.0, "tip": 0.5})  # [kg]
        >>> ik = jtik.InverseKinematics(arm, jtik.CenterOfMassTask())
        >>> solution = ik.solve([1.0, 0.8])
    """

    def __init__(
        self,
        *,
        axes: Axes = None,
        stiffness: ArrayLike = 1.0,
        priority: int = 0,
        name: str = "center_of_mass",
    ) -> None:
        super().__init__(stiffness=stiffness, priority=priority, name=name)
        self.axes = named(axes)

    def __repr__(self) -> str:
        return f"CenterOfMassTask(axes={self.axes!r})"

    def target_size(self, robot: Robot) -> int:
        """2 on a planar robot, else 3; coordinates of axes that are not kept are not used."""
        return robot.dimension

    def target_is_vector(self, robot: Robot) -> bool:
        """True: a point is read as it is."""
        return True

    def read_target(self, robot: Robot, target: Any) -> Array:
        """A point, or the coordinates of the axes that are kept.

        Raises:
            ArgumentError: for anything else.
        """
        rows = self._kept(robot)
        names = "xyz"[: robot.dimension]
        accepted = f"({', '.join(names)}) [m]"
        if len(rows) < len(names):
            accepted += f", or ({', '.join(names[row] for row in rows)}) [m]"
        numbers = as_numbers(target, target, accepted)
        if numbers.shape == (robot.dimension,):
            return numbers
        if numbers.shape != (len(rows),):
            raise ArgumentError("target", target, accepted)
        point = np.zeros(robot.dimension)
        point[rows] = numbers
        return point

    def held_target(self, kinematics: Kinematics) -> Expression:
        """The centre of mass."""
        return kinematics.center_of_mass()

    def rows(self, kinematics: Kinematics, target: Expression) -> TaskRows:
        """One row for each axis that is kept."""
        rows = self._kept(kinematics.robot)
        error = kinematics.center_of_mass() - target
        return TaskRows(vertcat(*[error[row] for row in rows]), (True,) * len(rows))

    def row_count(self, robot: Robot) -> int:
        """One row for each axis that is kept."""
        return len(self._kept(robot))

    def _kept(self, robot: Robot) -> list[int]:
        return kept(self.axes, "xyz"[: robot.dimension])

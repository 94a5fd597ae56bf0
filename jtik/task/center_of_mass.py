"""The centre of mass brought to a point, or over one: balance."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, vertcat
from jtik.task.base import TaskRows
from jtik.task.targets import as_numbers
from jtik.task.weighted import Axes, WeightedTask, kept, named
from jtik.types import Array


class CenterOfMassTask(WeightedTask):
    """Bring the centre of mass of the whole robot to a target point.

    Error: ``c(q) - c_target`` [m] in world axes, of a robot with masses. ``axes="xy"`` keeps it above a point of the
    floor and leaves its height alone.

    A target is a point (3,) [m], of which only the chosen axes count, or, with fewer axes than a point has, their
    coordinates alone, in the order of ``axes``. Planar: (x, y).

    Args:
        axes: which of "x", "y", "z" to keep; None keeps all.
        stiffness: a positive scalar, one value a row, or an SPD matrix (m, m).
        priority: level for the strategies that know levels; 0 is the highest.
        name: how a dict of targets refers to the task.

    Raises:
        ArgumentError: for a priority or stiffness that cannot be used; later, for a robot without masses.
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
        """2 in the plane, else 3: those of axes not kept are not read."""
        return robot.dimension

    def plain(self, robot: Robot) -> bool:
        """A point is."""
        return True

    def read_target(self, robot: Robot, target: Any) -> Array:
        """A point, or the coordinates of the axes kept."""
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

    def rows(self, kinematics: Kinematics, target: Expression) -> TaskRows:
        """One row an axis kept."""
        rows = self._kept(kinematics.robot)
        error = kinematics.center_of_mass() - target
        return TaskRows(vertcat(*[error[row] for row in rows]), (True,) * len(rows))

    def row_count(self, robot: Robot) -> int:
        """One for each axis kept."""
        return len(self._kept(robot))

    def _kept(self, robot: Robot) -> list[int]:
        return kept(self.axes, "xyz"[: robot.dimension])

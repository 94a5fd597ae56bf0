"""How fast, or how strong, a robot is in one direction (formulations/directional_manipulability.md)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from jtik import FrameTask, register_criterion
from jtik.arguments import choice
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, fmax, log, sqrt, sumsqr
from jtik.task.targets import Kind
from jtik.task.weighted import Axes
from jtik_formulations.bibliography import CHIU_1988
from jtik_formulations.criteria._parts.scalars import direction as unit_direction
from jtik_formulations.criteria._parts.scalars import nonzero
from jtik_formulations.criteria._parts.task_jacobian import DAMPING, SMALLEST_DAMPING, TaskJacobianCriterion

SHORTEST_DIRECTION = 1e-9
"""Length of a direction below which it counts as shorter than 1."""


@register_criterion("directional_manipulability")
class DirectionalManipulability(TaskJacobianCriterion):
    """H = -ln of the radius of the velocity ellipsoid, or of the force ellipsoid, in one direction u of task space.

    "velocity": radius (u' A^-1 u)^(-1/2), the speed along u, and along u alone, of joint velocities of norm 1.
    "force": radius (u' A u)^(-1/2), the force along u that joint torques of norm 1 balance. A = J J' + damping^2 I.
    J are the rows of a frame: lengths in base axes, divided by ``length``, and angles in the frame's own axes, as the
    rows of a `jtik.FrameTask` on its target. H has no unit; the unit of J only adds a constant. Prefer "velocity"
    before a fast motion along u, and "force" where the robot pushes or carries along u; they contradict each other.

    Live parameters: ``directional_manipulability.direction`` (m,), ``.damping`` and, with linear rows, ``.length`` [m].

    Args:
        direction: u, (m,), one number for each row, of any length but zero; the first row by default.
        frame: name of the frame, or a `jtik.FrameTask`, whose frame, kind and axes are taken; the tip when None.
        kind: "position", "orientation" or "pose".
        axes: names of the rows to keep, as those of a `jtik.FrameTask`; None keeps all.
        measure: "velocity" or "force".
        length: characteristic length [m]. By default 1 m where all rows are of one unit; else the length at which
            linear and angular rows have the same mean square in the robot's home configuration.
        damping: positive, in the unit of J.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when an argument is out of range, a row is unknown, or the direction does not fit the rows.
        UnknownNameError: when the robot has no such frame.

    Source: Chiu (1988), the transmission ratios.
    """

    name = "directional_manipulability"
    summary = "makes a robot fast, or strong, in one direction"
    source = "Chiu 1988"
    bibtex = CHIU_1988
    axes_matter = True

    def __init__(
        self,
        direction: ArrayLike | None = None,
        *,
        frame: str | FrameTask | None = None,
        kind: Kind = "position",
        axes: Axes = None,
        measure: Literal["velocity", "force"] = "velocity",
        length: float | None = None,
        damping: float = DAMPING,
        name: str = "directional_manipulability",
    ) -> None:
        super().__init__(frame, kind, axes, length, damping, name)
        self._direction = None if direction is None else nonzero("direction", direction, rows=True)
        self._measure = choice("measure", measure, ("velocity", "force"))

    def options(self) -> Mapping[str, object]:
        """The direction and the measure."""
        return {"direction": self._direction, "measure": self._measure}

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """The direction, the damping and the length."""
        m = self.row_count(robot)
        given = np.eye(m)[0] if self._direction is None else self._direction
        return {"direction": unit_direction("direction", given, m), **super().parameters(robot)}

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """-ln of the radius in the direction."""
        u = parameters["direction"]
        u = u / fmax(sqrt(sumsqr(u)), SHORTEST_DIRECTION)
        if self._measure == "velocity":
            return log(fmax(self.factors(kinematics, parameters).inverse_form(u), SMALLEST_DAMPING**2)) / 2
        epsilon = fmax(parameters["damping"], SMALLEST_DAMPING)
        J = self.jacobian(kinematics, parameters)
        return log(sumsqr(J.T @ u) + epsilon**2) / 2

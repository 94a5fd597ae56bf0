"""Manipulability: the volume of the velocity ellipsoid of task rows (formulations/manipulability.md)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from jtik import FrameTask, register_criterion
from jtik.arguments import choice
from jtik.robot import Kinematics
from jtik.symbolic import Expression, log, sqrt
from jtik.task.targets import Kind
from jtik.task.weighted import Axes
from jtik_formulations.bibliography import YOSHIKAWA_1985
from jtik_formulations.criteria._parts.task_jacobian import DAMPING, TaskJacobianCriterion


@register_criterion("manipulability")
class Manipulability(TaskJacobianCriterion):
    """H = -ln w, or H = -w, with w = sqrt(det(J J' + damping^2 I)), Yoshikawa's measure of manipulability.

    J are the rows of a frame: lengths in base axes, divided by ``length``, and angles in the frame's own axes, as the
    rows of a `jtik.FrameTask` on its target. The unit of w is that of J to the power m; -ln w changes by a constant
    with the unit. H, gradient and Hessian are finite and continuous at singular poses. Prefer "logarithm", whose
    gradient is large where w is small; prefer "volume" to compare w with other programs; prefer
    `SmallestSingularValue` where the weakest direction matters rather than the product of all.

    Live parameters: ``manipulability.damping`` and, with linear rows, ``manipulability.length`` [m].

    Args:
        frame: name of the frame, or a `jtik.FrameTask`, whose frame, kind and axes are taken; the tip when None.
        kind: "position", "orientation" or "pose".
        axes: names of the rows to keep, as those of a `jtik.FrameTask`; None keeps all.
        measure: "logarithm" or "volume".
        length: characteristic length [m]. By default 1 m where all rows are of one unit; else the length at which
            linear and angular rows have the same mean square in the robot's home configuration.
        damping: positive, in the unit of J.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when an argument is out of range or a row is unknown.
        UnknownNameError: when the robot has no such frame.

    Source: Yoshikawa (1985).
    """

    name = "manipulability"
    summary = "increases the volume of the velocity ellipsoid"
    source = "Yoshikawa 1985"
    bibtex = YOSHIKAWA_1985

    def __init__(
        self,
        frame: str | FrameTask | None = None,
        kind: Kind = "position",
        *,
        axes: Axes = None,
        measure: Literal["logarithm", "volume"] = "logarithm",
        length: float | None = None,
        damping: float = DAMPING,
        name: str = "manipulability",
    ) -> None:
        super().__init__(frame, kind, axes, length, damping, name)
        self._measure = choice("measure", measure, ("logarithm", "volume"))

    def options(self) -> Mapping[str, object]:
        """The measure."""
        return {"measure": self._measure}

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """-ln w or -w."""
        determinant = self.factors(kinematics, parameters).determinant
        return -log(determinant) / 2 if self._measure == "logarithm" else -sqrt(determinant)

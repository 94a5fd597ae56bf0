"""The smallest singular value of task rows, smoothed (formulations/smallest_singular_value.md)."""

from __future__ import annotations

from collections.abc import Mapping

from jtik import FrameTask, register_criterion
from jtik.robot import Kinematics
from jtik.symbolic import Expression, gram, horzcat, sqrt, sumsqr, vec
from jtik.task.targets import Kind
from jtik.task.weighted import Axes
from jtik_formulations.bibliography import KLEIN_BLAHO_1987
from jtik_formulations.criteria._parts.task_jacobian import DAMPING, TaskJacobianCriterion

_SQUARINGS = 2
"""How often A^-1 is squared before its Frobenius norm is taken: the sum of sigma_i^-16."""


@register_criterion("smallest_singular_value")
class SmallestSingularValue(TaskJacobianCriterion):
    """H = -(sum of (sigma_i^2 + damping^2)^-8)^(-1/16), minus a smooth lower bound of the smallest singular value of J.

    J are the rows of a frame: lengths in base axes, divided by ``length``, and angles in the frame's own axes, as the
    rows of a `jtik.FrameTask` on its target. H has the unit of J. Without damping the bound is at most sigma_m, and at
    least sigma_m m^(-1/16): 0.89 of it with six rows. It is smooth where singular values cross, and finite at singular
    poses. Prefer it to improve the weakest direction; prefer `Manipulability` where all of them count.

    Live parameters: ``smallest_singular_value.damping`` and, with linear rows, ``smallest_singular_value.length`` [m].

    Args:
        frame: name of the frame, or a `jtik.FrameTask`, whose frame, kind and axes are taken; the tip when None.
        kind: "position", "orientation" or "pose".
        axes: names of the rows to keep, as those of a `jtik.FrameTask`; None keeps all.
        length: characteristic length [m]. By default 1 m where all rows are of one unit; else the length at which
            linear and angular rows have the same mean square in the robot's home configuration.
        damping: positive, in the unit of J.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when an argument is out of range or a row is unknown.
        UnknownNameError: when the robot has no such frame.

    Source: Klein and Blaho (1987), the measure.
    """

    name = "smallest_singular_value"
    summary = "improves the weakest direction"
    source = "Klein and Blaho 1987"
    bibtex = KLEIN_BLAHO_1987

    def __init__(
        self,
        frame: str | FrameTask | None = None,
        kind: Kind = "position",
        *,
        axes: Axes = None,
        length: float | None = None,
        damping: float = DAMPING,
        name: str = "smallest_singular_value",
    ) -> None:
        super().__init__(frame, kind, axes, length, damping, name)

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """-(tr A^-8)^(-1/16)."""
        factors = self.factors(kinematics, parameters)
        scaled = [row / sqrt(pivot) for row, pivot in zip(factors.inverse_rows, factors.pivots, strict=True)]
        power = gram(horzcat(*scaled))  # M M' for A^-1 = M' M: the same eigenvalues
        for _ in range(_SQUARINGS):
            power = gram(power)
        return -(sumsqr(vec(power)) ** (-1 / 2 ** (_SQUARINGS + 2)))

"""Isotropy: the condition number of task rows in the Frobenius norm (formulations/isotropy.md)."""

from __future__ import annotations

from collections.abc import Mapping

from jtik import FrameTask, register_criterion
from jtik.robot import Kinematics
from jtik.symbolic import Expression, log
from jtik.task.targets import Kind
from jtik.task.weighted import Axes
from jtik_formulations.bibliography import ANGELES_LOPEZ_CAJUN_1992, SALISBURY_CRAIG_1982
from jtik_formulations.criteria._parts.task_jacobian import DAMPING, TaskJacobianCriterion


@register_criterion("isotropy")
class Isotropy(TaskJacobianCriterion):
    """H = ln kappa, kappa = sqrt(tr A tr A^-1) / m the condition number in the Frobenius norm, A = J J' + damping^2 I.

    J are the rows of a frame: lengths in base axes, divided by ``length``, and angles in the frame's own axes, as the
    rows of a `jtik.FrameTask` on its target. H has no unit: 0 where all singular values are equal, else positive, with
    (sigma_1 / sigma_m) / m <= kappa <= sigma_1 / sigma_m. Unlike the ratio of singular values it has no kinks. H,
    gradient and Hessian are finite and continuous at singular poses. Prefer it where all directions shall be alike;
    prefer `Manipulability` where they shall all be large.

    Live parameters: ``isotropy.damping`` and, with linear rows, ``isotropy.length`` [m].

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

    Source: Salisbury and Craig (1982), the condition number; Angeles and Lopez-Cajun (1992), the norm and the length.
    """

    name = "isotropy"
    summary = "makes all directions alike: reduces the condition number"
    source = "Salisbury and Craig 1982; Angeles and Lopez-Cajun 1992"
    bibtex = "\n".join((SALISBURY_CRAIG_1982, ANGELES_LOPEZ_CAJUN_1992))

    def __init__(
        self,
        frame: str | FrameTask | None = None,
        kind: Kind = "position",
        *,
        axes: Axes = None,
        length: float | None = None,
        damping: float = DAMPING,
        name: str = "isotropy",
    ) -> None:
        super().__init__(frame, kind, axes, length, damping, name)

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """ln of the condition number."""
        factors = self.factors(kinematics, parameters)
        m = self.row_count(kinematics.robot)
        return log(factors.trace * factors.inverse_trace / m**2) / 2

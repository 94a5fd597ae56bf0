"""Visibility: a point within the field of view of a frame (formulations/visibility.md)."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from jtik import register_criterion
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, cos, fmax
from jtik_formulations.bibliography import MARCHAND_HAGER_1998
from jtik_formulations.criteria._parts.line_of_sight import FLOOR, SightCriterion
from jtik_formulations.criteria._parts.scalars import number_between

SMALLEST_REST = 1e-6
"""Smallest 1 + cos(half_angle) that is divided by: a field of view of almost all directions."""


@register_criterion("visibility")
class Visibility(SightCriterion):
    """H = max(0, (cos half_angle - cos theta) / (1 + cos half_angle))^3, theta the angle of a target off the axis.

    H has no unit: 0 while the target is within the cone of that half angle about the axis, 1 where it is behind the
    frame. Gradient and Hessian are continuous. Prefer it to keep a point in view; prefer `LookAt` where it shall be in
    the middle of the picture. It does not know what hides the target.

    Live parameters: ``visibility.target`` [m], ``.axis``, ``.half_angle`` [rad] and ``.floor`` [m].

    Args:
        target: the point in the base frame (3,), or (2,) on a planar robot [m].
        frame: name of the frame; the tip when None.
        axis: the axis in coordinates of the frame, (3,), or (2,) on a planar robot, of any length but zero; by default
            z, or x on a planar robot.
        half_angle: half the opening angle of the field of view [rad], between 0 and pi.
        floor: distance [m] of the target below which the cosine of theta fades to 0.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when a size does not fit the robot, the axis is zero, or an argument is out of range.
        UnknownNameError: when the robot has no such frame.

    Source: Marchand and Hager (1998), a field of view as a secondary criterion; the cube is ours.
    """

    name = "visibility"
    summary = "keeps a point within the field of view of a frame"
    source = "after Marchand and Hager 1998"
    bibtex = MARCHAND_HAGER_1998
    non_negative_parameters = ("half_angle", "floor")

    def __init__(
        self,
        target: ArrayLike,
        frame: str | None = None,
        *,
        axis: ArrayLike | None = None,
        half_angle: float = math.radians(30),
        floor: float = FLOOR,
        name: str = "visibility",
    ) -> None:
        super().__init__(target, frame, axis, floor, name)
        self._half_angle = number_between("half_angle", half_angle, 0, math.pi)

    @classmethod
    def example(cls, robot: Robot) -> Visibility:
        """A target beside the base."""
        return cls(np.array([2.0, 1.5, 0.5])[: robot.dimension])

    def options(self) -> Mapping[str, float]:
        """Half the opening angle."""
        return {"half_angle": self._half_angle}

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """The cube of what the cosine lacks, as a fraction of the most that it can lack."""
        edge = cos(parameters["half_angle"])
        lacking = fmax(0, edge - self.cosine(kinematics, parameters))
        return (lacking / fmax(1 + edge, SMALLEST_REST)) ** 3

"""Look at a point: the angle between an axis of a frame and the line of sight (formulations/look_at.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from jtik import register_criterion
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression
from jtik_formulations.bibliography import MARCHAND_HAGER_1998
from jtik_formulations.criteria._parts.line_of_sight import FLOOR, SightCriterion


@register_criterion("look_at")
class LookAt(SightCriterion):
    """H = 1 - cos theta, theta the angle between an axis of a frame and the line from its origin to a target.

    H has no unit: 0 where the axis points at the target, 2 where it points away. It is smooth everywhere; within
    ``floor`` of the target, where there is no line of sight, it fades to 1. Prefer it for a camera that shall look at a
    point as well as the task permits; prefer `Visibility` where it is enough that the point is in view, and
    `jtik.LookAtTask` where the axis must point at it.

    Live parameters: ``look_at.target`` [m], ``.axis`` and ``.floor`` [m].

    Args:
        target: the point in the base frame (3,), or (2,) on a planar robot [m].
        frame: name of the frame; the tip when None.
        axis: the axis in coordinates of the frame, (3,), or (2,) on a planar robot, of any length but zero; by default
            z, or x on a planar robot.
        floor: distance [m] of the target below which H fades.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when a size does not fit the robot, the axis is zero or the floor is not positive.
        UnknownNameError: when the robot has no such frame.

    Source: Marchand and Hager (1998), visibility as a secondary criterion.
    """

    name = "look_at"
    summary = "turns an axis of a frame towards a point"
    source = "after Marchand and Hager 1998"
    bibtex = MARCHAND_HAGER_1998
    non_negative_parameters = ("floor",)

    def __init__(
        self,
        target: ArrayLike,
        frame: str | None = None,
        *,
        axis: ArrayLike | None = None,
        floor: float = FLOOR,
        name: str = "look_at",
    ) -> None:
        super().__init__(target, frame, axis, floor, name)

    @classmethod
    def example(cls, robot: Robot) -> LookAt:
        """A target beside the base."""
        return cls(np.array([2.0, 1.5, 0.5])[: robot.dimension])

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """1 - cos of the angle."""
        return 1 - self.cosine(kinematics, parameters)

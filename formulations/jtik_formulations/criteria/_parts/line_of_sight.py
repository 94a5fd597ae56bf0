"""Base of the criteria on the angle between an axis of a frame and the line of sight to a point."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from jtik import Criterion
from jtik.arguments import name as read_name
from jtik.arguments import positive_number
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, dot, fmax, sqrt, sumsqr, vertcat
from jtik_formulations.criteria._parts.scalars import direction, frame_or_tip, nonzero, point, vector
from jtik_formulations.criteria._parts.shown import shown

FLOOR = 1e-3
"""Default distance [m] of the target from the frame below which the angle fades."""

SMALLEST = 1e-9
"""Smallest floor [m], and shortest axis, that is divided by."""


class SightCriterion(Criterion):
    """Base: H is a function of the cosine of the angle between an axis of a frame and the line of sight."""

    def __init__(self, target: ArrayLike, frame: str | None, axis: ArrayLike | None, floor: float, name: str) -> None:
        self._target, self._frame = point("target", target), frame_or_tip(frame)
        self._axis = None if axis is None else nonzero("axis", axis)
        self._floor = positive_number("floor", floor)
        self.name = read_name("name", name)

    def __repr__(self) -> str:
        given = {"target": self._target, "frame": self._frame, "axis": self._axis, "floor": self._floor}
        return shown(self, {**given, **self.options()}, {"floor": FLOOR})

    def options(self) -> Mapping[str, float]:
        """Names and first values of the live parameters besides target, axis and floor."""
        return {}

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """The target, the axis, the floor, and the criterion's own parameters."""
        robot.frame(self._frame)
        axis = np.eye(robot.dimension)[0 if robot.dimension == 2 else 2] if self._axis is None else self._axis
        return {
            "target": vector("target", self._target, robot.dimension),
            "axis": direction("axis", axis, robot.dimension),
            "floor": self._floor,
            **self.options(),
        }

    def cosine(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """The cosine of the angle; it fades to 0 where the target is within ``floor`` of the frame's origin."""
        axis, sight = parameters["axis"], parameters["target"] - kinematics.position(self._frame)
        if kinematics.robot.dimension == 2:
            axis, sight = vertcat(axis, 0), vertcat(sight, 0)
        axis = axis / fmax(sqrt(sumsqr(axis)), SMALLEST)
        floor = fmax(parameters["floor"], SMALLEST)
        return dot(kinematics.rotation(self._frame) @ axis, sight) / sqrt(sumsqr(sight) + floor**2)

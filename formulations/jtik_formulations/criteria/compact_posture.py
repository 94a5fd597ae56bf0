"""Compactness: the joints near a point (formulations/compact_posture.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from jtik import Criterion, register_criterion
from jtik.arguments import name as read_name
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, sumsqr
from jtik_formulations.bibliography import JTIK_2026
from jtik_formulations.criteria._parts.scalars import point, vector
from jtik_formulations.criteria._parts.shown import shown


@register_criterion("compact_posture")
class CompactPosture(Criterion):
    """H = 1/2 of the mean squared distance [m^2] of the joints and the tip from a point, the base by default.

    Prefer it to fold an arm for a narrow space or a low moment of inertia. It knows no obstacles, and not the arm
    itself, into which it may fold; joint limits are what stops it.

    Live parameter: ``compact_posture.center`` (3,), or (2,) on a planar robot [m].

    Args:
        center: the point in the base frame [m]; by default the origin of the base.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when the point does not have the robot's dimension.

    Source: the radius of gyration of mechanics about a point, with one unit of mass at each joint.
    """

    name = "compact_posture"
    summary = "folds the arm: draws all joints to a point, the base by default"
    source = "The jtik developers 2026: the radius of gyration"
    bibtex = JTIK_2026

    def __init__(self, center: ArrayLike | None = None, *, name: str = "compact_posture") -> None:
        self._center = None if center is None else point("center", center)
        self.name = read_name("name", name)

    def __repr__(self) -> str:
        return shown(self, {"center": self._center}, {})

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """The centre."""
        given = np.zeros(robot.dimension) if self._center is None else self._center
        return {"center": vector("center", given, robot.dimension)}

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """Half the mean squared distance."""
        frames = kinematics.robot.moving_frames
        total = sum(sumsqr(kinematics.position(frame) - parameters["center"]) for frame in frames)
        return total / (2 * max(len(frames), 1))

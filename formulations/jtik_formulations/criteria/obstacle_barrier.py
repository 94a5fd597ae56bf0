"""A barrier of finite range before obstacles, twice differentiable (formulations/obstacle_barrier.md)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import ClassVar

from numpy.typing import ArrayLike

from jtik import register_criterion
from jtik.arguments import non_negative_number, positive_number
from jtik.geometry import Obstacle
from jtik.symbolic import Expression, fmax, fmin, log
from jtik_formulations.bibliography import LI_2020
from jtik_formulations.criteria._parts.bodies import BodyChoice
from jtik_formulations.criteria._parts.obstacle_criterion import ObstacleCriterion, total
from jtik_formulations.criteria._parts.scalars import number_between

SMALLEST_RANGE = 1e-6
"""Smallest influence [m] that is divided by."""


@register_criterion("obstacle_barrier")
class ObstacleBarrier(ObstacleCriterion):
    """H = -gain * sum of (1 - x)^2 ln x over the distances d below ``influence``, with x = d / influence.

    Each term, its gradient and its curvature are zero at ``influence`` and beyond: bodies that are far away cost
    nothing and feel nothing, and a Newton-like step meets no jump there. Towards an obstacle H rises without bound;
    below the share ``floor`` of the influence, and inside, it is continued by its second-order expansion. Prefer it
    where obstacles shall matter only when they are near, and with strategies that use second derivatives. To guarantee
    a distance use `jtik.Clearance`.

    Live parameters: ``obstacle_barrier.gain``, ``.influence``, and those of the obstacles, as of `ObstacleAvoidance`.

    Args:
        obstacles: points, circles, spheres, capsules, boxes, cylinders, half-spaces or convex polygons, perhaps none;
            or a `jtik.Scene`.
        gain: non-negative weight of the sum; the unit of H.
        influence: positive distance [m] from which on an obstacle has no effect.
        bodies: "joints", the frames' origins; "links", the closest point of each link; "both"; or, for a robot
            that was built with solids, these: "shapes", each as a capsule, or "spheres", boxes as balls where these
            add less (`jtik.geometry.enclosing_segment`, `enclosing_balls`).
        floor: share of the influence below which H is continued, between 0 and 1.
        capacity: number of slots for obstacles, or the number for each kind, as of `ObstacleAvoidance`.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when an argument is out of range, there are more obstacles than slots, the obstacles do not have
            the robot's dimension, or the robot has no solids that move.
        UnknownNameError: when ``capacity`` names a kind of obstacle that does not exist.

    Source: Li et al. (2020), (6).
    """

    summary = "barrier before obstacles within a distance, twice differentiable"
    source = "Li et al. 2020, eq. 6"
    bibtex = LI_2020
    non_negative_parameters = ("gain", "influence", *ObstacleCriterion.non_negative_parameters)
    defaults: ClassVar[Mapping[str, object]] = {"gain": 1.0, "influence": 0.3, "floor": 0.05}

    def __init__(
        self,
        obstacles: Iterable[Obstacle] | Obstacle,
        *,
        gain: float = 1.0,
        influence: float = 0.3,
        bodies: BodyChoice = "joints",
        floor: float = 0.05,
        capacity: int | Mapping[str, int] | None = None,
        name: str = "obstacle_barrier",
    ) -> None:
        super().__init__(obstacles, bodies, capacity, name)
        self._gain = non_negative_number("gain", gain)
        self._influence = positive_number("influence", influence, "a positive length [m]")
        self._floor = number_between("floor", floor, 0, 1)

    def options(self) -> Mapping[str, object]:
        """Gain, influence and floor."""
        return {"gain": self._gain, "influence": self._influence, "floor": self._floor}

    def own_parameters(self) -> Mapping[str, ArrayLike]:
        """Gain and influence."""
        return {"gain": self._gain, "influence": self._influence}

    def potential(
        self, distances: Expression, gains: Expression | None, parameters: Mapping[str, Expression]
    ) -> Expression:
        """-gain * sum of (1 - x)^2 ln x, continued below the floor by its second-order expansion."""
        per_length, x0 = 1 / fmax(parameters["influence"], SMALLEST_RANGE), self._floor
        # minus the first derivative, and half of the second one, at the floor (B2)
        slope = -2 * (1 - x0) * math.log(x0) + (1 - x0) ** 2 / x0
        half_curvature = (-2 * math.log(x0) + 4 * (1 - x0) / x0 + ((1 - x0) / x0) ** 2) / 2

        def one(distance: Expression) -> Expression:
            x = distance * per_length
            inner = fmin(fmax(x, x0), 1)
            below = fmax(x0 - x, 0)
            return below * (slope + half_curvature * below) - (1 - inner) ** 2 * log(inner)

        return total(one(distances), gains)

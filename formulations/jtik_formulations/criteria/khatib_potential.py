"""Khatib's artificial potential field of finite range (formulations/khatib_potential.md)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import ClassVar

from numpy.typing import ArrayLike

from jtik import register_criterion
from jtik.arguments import non_negative_number, positive_number
from jtik.errors import ArgumentError
from jtik.geometry import Obstacle
from jtik.symbolic import Expression, fmax
from jtik_formulations.bibliography import KHATIB_1986
from jtik_formulations.criteria._parts.bodies import BodyChoice
from jtik_formulations.criteria._parts.obstacle_criterion import ObstacleCriterion, total


@register_criterion("khatib_potential")
class KhatibPotential(ObstacleCriterion):
    """H = gain / 2 * sum of (1/d - 1/influence)^2 over the distances d [m] below ``influence``.

    The force of an obstacle on a body is gain (1/d - 1/influence) / d^2, away from the obstacle, and none beyond
    ``influence``. Below ``floor``, and inside an obstacle, H is continued by its second-order expansion. Prefer it to
    `ObstacleAvoidance` where obstacles that are far away shall not matter; prefer `ObstacleBarrier` where second
    derivatives are used: those of this one jump at ``influence``. To guarantee a distance use `jtik.Clearance`.

    Live parameters: ``khatib_potential.gain``, ``.influence``, and those of the obstacles, as of `ObstacleAvoidance`.

    Args:
        obstacles: points, circles, spheres, capsules, boxes, cylinders, half-spaces or convex polygons, perhaps none;
            or a `jtik.Scene`.
        gain: Khatib's eta, non-negative [unit of H * m^2].
        influence: Khatib's rho_0, the distance [m] from which on an obstacle has no effect.
        bodies: "joints", the frames' origins; "links", the closest point of each link; "both"; or, for a robot
            that was built with solids, these: "shapes", each as a capsule, or "spheres", boxes as balls where these
            add less (`jtik.geometry.enclosing_segment`, `enclosing_balls`).
        floor: positive distance [m] below which H is continued.
        capacity: number of slots for obstacles, or the number for each kind, as of `ObstacleAvoidance`.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when an argument is out of range, there are more obstacles than slots, the obstacles do not have
            the robot's dimension, or the robot has no solids that move.
        UnknownNameError: when ``capacity`` names a kind of obstacle that does not exist.

    Source: Khatib (1986), (17) and (18).
    """

    summary = "repels joints, links or solids from obstacles within a distance, by Khatib's potential"
    source = "Khatib 1986, eq. 17"
    bibtex = KHATIB_1986
    non_negative_parameters = ("gain", "influence", *ObstacleCriterion.non_negative_parameters)
    defaults: ClassVar[Mapping[str, object]] = {"gain": 1.0, "influence": 0.3, "floor": 0.02}

    def __init__(
        self,
        obstacles: Iterable[Obstacle] | Obstacle,
        *,
        gain: float = 1.0,
        influence: float = 0.3,
        bodies: BodyChoice = "joints",
        floor: float = 0.02,
        capacity: int | Mapping[str, int] | None = None,
        name: str = "khatib_potential",
    ) -> None:
        super().__init__(obstacles, bodies, capacity, name)
        self._gain = non_negative_number("gain", gain)
        self._floor = positive_number("floor", floor, "a positive length [m]")
        accepted = f"a length above the floor, {self._floor:g} m"
        self._influence = positive_number("influence", influence, accepted)
        if not self._influence > self._floor:
            raise ArgumentError("influence", influence, accepted)

    def options(self) -> Mapping[str, object]:
        """Gain, influence and floor."""
        return {"gain": self._gain, "influence": self._influence, "floor": self._floor}

    def own_parameters(self) -> Mapping[str, ArrayLike]:
        """Gain and influence."""
        return {"gain": self._gain, "influence": self._influence}

    def potential(
        self, distances: Expression, gains: Expression | None, parameters: Mapping[str, Expression]
    ) -> Expression:
        """gain / 2 * sum of (1/d - 1/influence)^2, continued below the floor by its second-order expansion."""
        floor = self._floor
        away = 1 / fmax(parameters["influence"], floor)
        # derivatives at the floor, K4
        slope, curvature = (1 / floor - away) / floor**2, (3 / floor - 2 * away) / floor**3

        def one(distance: Expression) -> Expression:
            safe = fmax(distance, floor)
            below = safe - distance
            return fmax(1 / safe - away, 0) ** 2 / 2 + below * (slope + curvature / 2 * below)

        return total(one(distances), gains)

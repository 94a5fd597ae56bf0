"""Obstacle avoidance: the paper's log potential, with the sign that repels (formulations/obstacle_avoidance.md)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import ClassVar

from numpy.typing import ArrayLike

from jtik import register_criterion
from jtik.arguments import non_negative_number, positive_number
from jtik.geometry import Obstacle
from jtik.symbolic import Expression, diag, fmax, log, sum1, vec
from jtik_formulations.bibliography import DAS_1988
from jtik_formulations.criteria._parts.bodies import BodyChoice
from jtik_formulations.criteria._parts.obstacle_criterion import ObstacleCriterion

_FACTORS = 8
"""Distances multiplied before one logarithm is taken: logarithms are slow, and a product of eight cannot overflow."""


@register_criterion("obstacle_avoidance")
class ObstacleAvoidance(ObstacleCriterion):
    """H = -gain * sum of ln d over all bodies and all obstacles, d the distance [m] to the obstacle's surface.

    The force of each obstacle on each body is gain / d, away from that obstacle. Below ``floor``, and inside an
    obstacle, the logarithm is continued by its second-order expansion: value and force stay finite, and the force still
    points outwards. With ``bodies="joints"`` a link can pass through an obstacle that is smaller than the link; prefer
    ``"links"`` or ``"both"`` there. With these, and with ``"shapes"``, the Hessian jumps where the closest point leaves
    the end of a link. To guarantee a distance use `jtik.Clearance`.

    Live parameters: ``obstacle_avoidance.gain`` and those of the obstacles, such as ``.centers`` (k, 2 or 3) [m] and
    ``.radii`` (k,) [m] of balls; `jtik.geometry.Slots` lists them. With ``capacity``, of a `jtik.Scene` and of an empty
    list there is also a gain for each slot, ``.gains`` (k,): the terms of an obstacle in H are multiplied by it, and
    with 0 the slot is empty.

    Args:
        obstacles: points, circles, spheres, capsules, boxes, cylinders, half-spaces or convex polygons, perhaps none;
            or a `jtik.Scene`.
        gain: the paper's K_obs, non-negative; the unit of H.
        bodies: "joints", the frames' origins; "links", the closest point of each link; "both"; or, for a robot
            that was built with solids, these: "shapes", each as a capsule, or "spheres", boxes as balls where these
            add less (`jtik.geometry.enclosing_segment`, `enclosing_balls`).
        floor: positive distance [m] below which the logarithm is continued.
        capacity: number of slots; those that the obstacles leave are divided evenly among the kinds that occur. Or the
            number for each kind: ``{"ball": 8, "box": 4}``. By default 16 slots for a scene or an empty list, and of a
            list of obstacles as many as these, without gains.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when an argument is out of range, there are more obstacles than slots, the obstacles do not have
            the robot's dimension, or the robot has no solids that move.
        UnknownNameError: when ``capacity`` names a kind of obstacle that does not exist.

    Source: Das, Slotine and Sheridan (1988), (2.2), the term K_obs, whose printed sign attracts.
    """

    summary = "log potential that repels joints, links or solids from obstacles"
    source = "Das, Slotine and Sheridan 1988, eq. 2.2"
    non_negative_parameters = ("gain", *ObstacleCriterion.non_negative_parameters)
    bibtex = DAS_1988
    defaults: ClassVar[Mapping[str, object]] = {"gain": 1.0, "floor": 0.01}

    def __init__(
        self,
        obstacles: Iterable[Obstacle] | Obstacle,
        *,
        gain: float = 1.0,
        bodies: BodyChoice = "joints",
        floor: float = 0.01,
        capacity: int | Mapping[str, int] | None = None,
        name: str = "obstacle_avoidance",
    ) -> None:
        super().__init__(obstacles, bodies, capacity, name)
        self._gain = non_negative_number("gain", gain)
        self._floor = positive_number("floor", floor, "a positive length [m]")

    def options(self) -> Mapping[str, object]:
        """The gain and the floor."""
        return {"gain": self._gain, "floor": self._floor}

    def own_parameters(self) -> Mapping[str, ArrayLike]:
        """The gain."""
        return {"gain": self._gain}

    def potential(
        self, distances: Expression, gains: Expression | None, parameters: Mapping[str, Expression]
    ) -> Expression:
        """The sum of -ln d, continued below the floor by its second-order expansion."""
        safe = fmax(distances, self._floor)
        below = safe - distances
        if gains is None:
            safe, below = vec(safe.T), vec(below.T)
        # the terms of one obstacle together: one multiplication by its gain
        continued = sum1(below) * (1 / self._floor) + sum1(below**2) * (0.5 / self._floor**2)
        terms = continued - _sum_of_logarithms(safe)
        return terms if gains is None else terms @ gains

    def potential_gradient(
        self, distances: Expression, gains: Expression | None, parameters: Mapping[str, Expression]
    ) -> Expression:
        """-1 / d, continued linearly below the floor."""
        safe = fmax(distances, self._floor)
        derivatives = (safe - distances) * (-1 / self._floor**2) - 1 / safe
        return derivatives if gains is None else derivatives @ diag(gains)


def _sum_of_logarithms(positive: Expression) -> Expression:
    """The sum of the logarithms of each column, a row."""
    total: Expression = 0
    for start in range(0, positive.shape[0], _FACTORS):
        product = positive[start, :]
        for row in range(start + 1, min(start + _FACTORS, positive.shape[0])):
            product = product * positive[row, :]
        total = total + log(product)
    return total

"""The smallest distance to an obstacle, smoothed (formulations/soft_clearance.md)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import ClassVar

from numpy.typing import ArrayLike

from jtik import register_criterion
from jtik.arguments import non_negative_number, positive_number
from jtik.geometry import ABSENT, Obstacle
from jtik.symbolic import TINY, Expression, exp, fmax, horzcat, if_else, log, mmin, sum1, vec
from jtik_formulations.bibliography import KREISSELMEIER_1979
from jtik_formulations.criteria._parts.bodies import BodyChoice
from jtik_formulations.criteria._parts.obstacle_criterion import ObstacleCriterion

SMALLEST_SMOOTHING = 1e-6
"""Smallest smoothing [m] that is divided by."""


@register_criterion("soft_clearance")
class SoftClearance(ObstacleCriterion):
    """H = gain * smoothing * ln sum of exp(-d / smoothing): minus the smallest distance d [m], smoothed.

    The smoothed distance is at most the smallest one, and less than it by at most smoothing * ln N, N the number of
    pairs of a body and an obstacle. Its gradient is the mean of the gradients of all distances, weighted by
    exp(-d / smoothing): the body that is closest moves away, and those that are farther by a few times the smoothing do
    not matter. Prefer it where the smallest distance shall be as large as possible; prefer `ObstacleBarrier` where all
    that is needed is to stay off. To guarantee a distance use `jtik.Clearance`.

    Live parameters: ``soft_clearance.gain``, ``.smoothing`` [m], and those of the obstacles, as of
    `ObstacleAvoidance`; the gain of an obstacle multiplies its exponentials, as if it were there so many times.

    Args:
        obstacles: points, circles, spheres, capsules, boxes, cylinders, half-spaces or convex polygons, perhaps none;
            or a `jtik.Scene`.
        gain: non-negative weight [unit of H / m].
        smoothing: positive length [m]; at least 1e-6 m is used.
        bodies: "joints", the frames' origins; "links", the closest point of each link; "both"; or, for a robot
            that was built with solids, these: "shapes", each as a capsule, or "spheres", boxes as balls where these
            add less (`jtik.geometry.enclosing_segment`, `enclosing_balls`).
        capacity: number of slots for obstacles, or the number for each kind, as of `ObstacleAvoidance`.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when an argument is out of range, there are more obstacles than slots, the obstacles do not have
            the robot's dimension, or the robot has no solids that move.
        UnknownNameError: when ``capacity`` names a kind of obstacle that does not exist.

    Source: Kreisselmeier and Steinhauser (1979).
    """

    summary = "maximises the smallest distance of joints, links or solids to obstacles, smoothed"
    source = "Kreisselmeier and Steinhauser 1979"
    bibtex = KREISSELMEIER_1979
    non_negative_parameters = ("gain", "smoothing", *ObstacleCriterion.non_negative_parameters)
    defaults: ClassVar[Mapping[str, object]] = {"gain": 1.0, "smoothing": 0.05}

    def __init__(
        self,
        obstacles: Iterable[Obstacle] | Obstacle,
        *,
        gain: float = 1.0,
        smoothing: float = 0.05,
        bodies: BodyChoice = "joints",
        capacity: int | Mapping[str, int] | None = None,
        name: str = "soft_clearance",
    ) -> None:
        super().__init__(obstacles, bodies, capacity, name)
        self._gain = non_negative_number("gain", gain)
        self._smoothing = positive_number("smoothing", smoothing, "a positive length [m]")

    def options(self) -> Mapping[str, object]:
        """Gain and smoothing."""
        return {"gain": self._gain, "smoothing": self._smoothing}

    def own_parameters(self) -> Mapping[str, ArrayLike]:
        """Gain and smoothing."""
        return {"gain": self._gain, "smoothing": self._smoothing}

    def potential(
        self, distances: Expression, gains: Expression | None, parameters: Mapping[str, Expression]
    ) -> Expression:
        """gain * smoothing * ln sum of exp(-d / smoothing); 0 where every obstacle is absent."""
        smoothing = fmax(parameters["smoothing"], SMALLEST_SMOOTHING)
        weights: Expression = 1
        if gains is not None:
            weights = horzcat(*[gains] * distances.shape[0]).T
            distances = if_else(weights > 0, distances, ABSENT)
        smallest = mmin(distances)
        # relative to the smallest one, so that no exponential overflows; its derivative cancels
        total = sum1(vec(weights * exp((smallest - distances) / smoothing)))
        H = smoothing * log(total + TINY) - smallest
        return H if gains is None else if_else(smallest < ABSENT, H, 0)

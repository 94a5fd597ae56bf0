"""Obstacle avoidance: the paper's log potential, with the sign that repels (formulations/obstacle_avoidance.md)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Literal

from numpy.typing import ArrayLike

from jtik import Criterion, register_criterion
from jtik.arguments import choice, instances, non_negative_number, positive_number
from jtik.arguments import name as read_name
from jtik.criterion.short_repr import call_text
from jtik.errors import ArgumentError
from jtik.geometry import (
    Obstacle,
    Solid,
    centers_and_radii,
    enclosing_segment,
    point_to_ball,
    segment_to_ball,
)
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, fmax, log
from jtik_formulations.bibliography import DAS_1988

_FACTORS = 8
"""Distances multiplied before one logarithm is taken: logarithms are slow, and a product of eight cannot overflow."""


_DEFAULTS = {"gain": 1.0, "bodies": "joints", "floor": 0.01, "name": "obstacle_avoidance"}
"""What the repr does not show."""


@register_criterion("obstacle_avoidance")
class ObstacleAvoidance(Criterion):
    """H = -gain * sum of ln d over all bodies and all obstacles, d the distance [m] to the obstacle's surface.

    The force of each obstacle on each body is gain / d, away from that obstacle. Below ``floor``, and inside an
    obstacle, the logarithm is continued by its second-order expansion: value and force stay finite, and the force still
    points outwards. With ``bodies="joints"`` a link can pass through an obstacle that is smaller than the link; prefer
    ``"links"`` or ``"both"`` there. With these, and with ``"shapes"``, the Hessian jumps where the closest point leaves
    the end of a link. To guarantee a distance use `jtik.Clearance`.

    Live parameters: ``obstacle_avoidance.gain``, ``.centers`` (k, 2 or 3) [m] and ``.radii`` (k,) [m].

    Args:
        obstacles: points, circles (planar robots) or spheres.
        gain: the paper's K_obs, non-negative; the unit of H.
        bodies: "joints", the frames' origins; "links", the closest point of each link; "both"; or "shapes", the
            robot's own solids as capsules, for a robot that was built with solids.
        floor: positive distance [m] below which the logarithm is continued.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when there is no obstacle, an argument is out of range, the obstacles do not have the robot's
            dimension, or the robot has no solids that move.

    Source: Das, Slotine and Sheridan (1988), (2.2), the term K_obs, whose printed sign attracts.
    """

    summary = "log potential that repels joints, or links, from points, circles and spheres"
    source = "Das, Slotine and Sheridan 1988, eq. 2.2"
    non_negative_parameters = ("gain", "radii")
    bibtex = DAS_1988

    def __init__(
        self,
        obstacles: Iterable[Obstacle] | Obstacle,
        *,
        gain: float = 1.0,
        bodies: Literal["joints", "links", "both", "shapes"] = "joints",
        floor: float = 0.01,
        name: str = "obstacle_avoidance",
    ) -> None:
        accepted = "at least one jtik.Point, jtik.Circle or jtik.Sphere"
        self._obstacles = instances("obstacles", obstacles, Obstacle, accepted)
        if not self._obstacles:
            raise ArgumentError("obstacles", "none", accepted)
        self._gain = non_negative_number("gain", gain)
        self._bodies = choice("bodies", bodies, ("joints", "links", "both", "shapes"))
        self._floor = positive_number("floor", floor, "a positive length [m]")
        self.name = read_name("name", name)

    def __repr__(self) -> str:
        count = len(self._obstacles)
        values = {"gain": self._gain, "bodies": self._bodies, "floor": self._floor, "name": self.name}
        changed = {name: value for name, value in values.items() if value != _DEFAULTS[name]}
        return call_text(type(self).__name__, f"{count} obstacle{'s' * (count != 1)}", **changed)

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Gain, centres and radii of the obstacles."""
        centers, radii = centers_and_radii(self._obstacles, robot.dimension)
        return {"gain": self._gain, "centers": centers, "radii": radii}

    def distances(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> list[list[Expression]]:
        """Signed distance [m] of each body (outer list) to each obstacle (inner list)."""
        robot = kinematics.robot
        centers = [parameters["centers"][i, :].T for i in range(len(self._obstacles))]
        radii = [parameters["radii"][i] for i in range(len(self._obstacles))]
        balls = list(zip(centers, radii, strict=True))
        bodies = []
        if self._bodies in ("joints", "both"):
            for frame in robot.moving_frames:
                bodies.append([point_to_ball(kinematics.position(frame), *ball) for ball in balls])
        if self._bodies in ("links", "both"):
            for start, end in robot.segments:
                ends = kinematics.position(start), kinematics.position(end)
                bodies.append([segment_to_ball(*ends, *ball) for ball in balls])
        if self._bodies == "shapes":
            for frame, solid in _moving_solids(robot):
                first, last, radius = enclosing_segment(solid)
                ends = kinematics.point(frame, first), kinematics.point(frame, last)
                bodies.append([segment_to_ball(*ends, *ball) - radius for ball in balls])
        return bodies

    def body_names(self, robot: Robot) -> list[str]:
        """Names of the bodies of `distances`, in their order, made of the names of their frames."""
        names = []
        if self._bodies in ("joints", "both"):
            names += list(robot.moving_frames)
        if self._bodies in ("links", "both"):
            names += [f"{start}-{end}" for start, end in robot.segments]
        if self._bodies == "shapes":
            names += [frame for frame, _ in _moving_solids(robot)]
        return names

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """-gain * sum of ln d, continued below the floor by its second-order expansion."""
        logarithms: Expression = 0
        first: Expression = 0
        second: Expression = 0
        for distances in self.distances(kinematics, parameters):
            for start in range(0, len(distances), _FACTORS):
                product: Expression = 1
                for distance in distances[start : start + _FACTORS]:
                    safe = fmax(distance, self._floor)
                    below = safe - distance
                    product, first, second = product * safe, first + below, second + below**2
                logarithms = logarithms + log(product)
        continued = first * (1 / self._floor) + second * (0.5 / self._floor**2)
        return parameters["gain"] * (continued - logarithms)


def _moving_solids(robot: Robot) -> list[tuple[str, Solid]]:
    """The solids that a joint moves, with their frames. Raises ArgumentError where there is none."""
    found = []
    for frame, solids in robot.shapes.items():
        if any(joint.is_moving for joint in robot.path(frame)):
            found += [(frame, solid) for solid in solids]
    if not found:
        given = f"'shapes' on {robot!r}, which has no solids that move"
        raise ArgumentError("bodies", given, "'joints', 'links' or 'both'")
    return found

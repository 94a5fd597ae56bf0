"""Base of the criteria on distances between bodies of a robot and obstacles."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import ClassVar

from numpy.typing import ArrayLike

from jtik import Criterion
from jtik.arguments import choice, instances, integer
from jtik.arguments import name as read_name
from jtik.criterion.short_repr import call_text
from jtik.errors import ArgumentError
from jtik.geometry import ABSENT, Obstacle, Scene, Slots
from jtik.geometry.slots import read_counts
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, if_else
from jtik.types import Array
from jtik_formulations.criteria._parts.bodies import (
    CHOICES,
    BodyChoice,
    bodies_of,
    names_of_bodies,
    radii_of_bodies,
)

ACCEPTED = "jtik.Point, Circle, Sphere, Capsule, Box, Cylinder, HalfSpace or Polygon"


class ObstacleCriterion(Criterion):
    """Base: H is a function of the distances of bodies to obstacles, which a `jtik.Clearance` can also measure.

    Of a list there are as many obstacles as given, and each counts fully. With ``capacity``, of a `jtik.Scene` and of
    an empty list there are slots, each with a live gain: the terms of an obstacle in H are multiplied by it, and with
    gain 0 it is absent from H and from a `jtik.Clearance`, whose distances do not depend on it otherwise.

    Args:
        obstacles: obstacles or a `jtik.Scene`, perhaps empty.
        bodies: "joints", the frames' origins; "links", their centre lines; "both"; or the robot's own solids, "shapes"
            as capsules, or "spheres" with boxes as balls where these add less.
        capacity: number of slots, or the number for each kind of obstacle, see `jtik.geometry.Slots.of`.
        name: the first part of the names of its parameters.
    """

    defaults: ClassVar[Mapping[str, object]] = {}
    """Values of the options that the repr does not show."""

    non_negative_parameters: ClassVar[tuple[str, ...]] = (
        "radii",
        "capsule_radii",
        "box_halves",
        "cylinder_radii",
        "gains",
    )

    def __init__(
        self,
        obstacles: Iterable[Obstacle] | Obstacle,
        bodies: BodyChoice,
        capacity: int | Mapping[str, int] | None,
        name: str,
    ) -> None:
        self._obstacles = instances("obstacles", obstacles, Obstacle, ACCEPTED)
        self._gains = list(obstacles.gains.values()) if isinstance(obstacles, Scene) else None
        self._bodies = choice("bodies", bodies, CHOICES)
        self._capacity: int | dict[str, int] | None = None
        if isinstance(capacity, Mapping):
            self._capacity = read_counts("capacity", capacity)
            if not any(self._capacity.values()):
                raise ArgumentError("capacity", dict(capacity), "at least one slot")
        elif capacity is not None:
            self._capacity = integer("capacity", capacity, minimum=1)
            if len(self._obstacles) > self._capacity:
                raise ArgumentError("obstacles", f"{len(self._obstacles)}", f"at most {capacity}, the capacity")
        self.name = read_name("name", name)

    def options(self) -> Mapping[str, object]:
        """The options besides obstacles, bodies and name, for the repr."""
        return {}

    def accepted_instead(self, parameter: str, value: Array) -> str | None:
        """Corners are those of a convex polygon; normals and quaternions are not zero."""
        return Slots.accepted_instead(parameter, value)

    def own_parameters(self) -> Mapping[str, ArrayLike]:
        """Names and first values of the live parameters besides those of the obstacles."""
        return {}

    def __repr__(self) -> str:
        count = len(self._obstacles)
        values = {**self.options(), "bodies": self._bodies, "capacity": self._capacity, "name": self.name}
        defaults = {"bodies": "joints", "capacity": None, "name": type(self).name, **self.defaults}
        changed = {name: value for name, value in values.items() if value != defaults.get(name)}
        return call_text(type(self).__name__, f"{count} obstacle{'s' * (count != 1)}", **changed)

    def slots(self, robot: Robot) -> Slots:
        """The slots on this robot; `jtik.geometry.Slots.parameters` makes the values of the live parameters.

        Raises:
            ArgumentError: when the obstacles do not have the robot's dimension, or are more than the slots.
        """
        if self._capacity is None and self._obstacles and self._gains is None:
            return Slots.exactly(self._obstacles, robot.dimension)
        return Slots.of(self._obstacles, self._capacity, robot.dimension)

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Its own, and those of the obstacles."""
        return {**self.own_parameters(), **self.slots(robot).parameters(self._obstacles, self._gains)}

    def distances(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> list[list[Expression]]:
        """Signed distance [m] of each body (outer list) to each obstacle (inner list); 1e9 of one that is absent."""
        measured, gains = self.measured(kinematics, parameters)
        if gains is None:
            return measured
        return [[if_else(g > 0, d, ABSENT) for d, g in zip(body, gains, strict=True)] for body in measured]

    def measured(
        self, kinematics: Kinematics, parameters: Mapping[str, Expression]
    ) -> tuple[list[list[Expression]], list[Expression] | None]:
        """The distances, also to absent obstacles, and the gain of each obstacle, or None where there are none."""
        slots = self.slots(kinematics.robot)
        field = slots.at(parameters)
        found = []
        for body in bodies_of(kinematics, self._bodies):
            distances = [slot.distances.of(*body.points) for slot in field]
            found.append([d - body.radius for d in distances] if body.radius else distances)
        return found, [slot.gain for slot in field] if slots.gains else None

    def total(
        self,
        kinematics: Kinematics,
        parameters: Mapping[str, Expression],
        potential: Callable[[Expression], Expression],
    ) -> Expression:
        """The sum of a potential of the distance over all pairs, the terms of each obstacle multiplied by its gain."""
        bodies, gains = self.measured(kinematics, parameters)
        if gains is None:
            return sum((potential(d) for body in bodies for d in body), 0)
        columns = zip(gains, zip(*bodies, strict=True), strict=True)
        return sum((gain * sum((potential(d) for d in column), 0) for gain, column in columns), 0)

    def rounding(self, robot: Robot, parameters: Mapping[str, Expression]) -> list[list[Expression]]:
        """For each distance the radius [m] that a `jtik.Clearance` needs: of the obstacle and of the body together.

        A distance is that to a fixed convex set, less this radius; infinity where the set is a half-space, and for an
        obstacle that is absent.
        """
        rounded = [
            slot.distances.rounding if slot.gain is None else if_else(slot.gain > 0, slot.distances.rounding, math.inf)
            for slot in self.slots(robot).at(parameters)
        ]
        return [[each + radius for each in rounded] for radius in radii_of_bodies(robot, self._bodies)]

    def body_names(self, robot: Robot) -> list[str]:
        """Names of the bodies of `distances`, in their order, made of the names of their frames."""
        return names_of_bodies(robot, self._bodies)

    def obstacle_names(self, robot: Robot) -> list[str]:
        """Names of the obstacles of `distances`, in their order."""
        return list(self.slots(robot).names)

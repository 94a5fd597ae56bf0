"""Base of the criteria on distances between bodies of a robot and obstacles."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from typing import ClassVar

from numpy.typing import ArrayLike

from jtik import Criterion
from jtik.arguments import choice, instances, integer
from jtik.arguments import name as read_name
from jtik.constraints.many_distances import ManyDistances
from jtik.criterion.overriding import belongs_to
from jtik.criterion.short_repr import call_text
from jtik.errors import ArgumentError
from jtik.geometry import ABSENT, Obstacle, Scene, Slot, Slots
from jtik.geometry.pair_functions import distances_of, distances_with_gradients
from jtik.geometry.slots import read_counts
from jtik.robot import Kinematics, Robot
from jtik.symbolic import (
    Expression,
    diag,
    gradient,
    if_else,
    jacobian,
    reshape,
    substitute,
    sum1,
    symbol,
    vec,
    vertcat,
)
from jtik.types import Array
from jtik_formulations.criteria._parts.bodies import (
    CHOICES,
    BodyChoice,
    bodies_of,
    names_of_bodies,
    radii_of_bodies,
)
from jtik_formulations.criteria._parts.forces import Forces

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
        field = self.slots(kinematics.robot).at(parameters)
        found = []
        for body in bodies_of(kinematics, self._bodies):
            row = body.thinner(distances_of(body.points, [slot.distances for slot in field]))
            found.append([_present(row[j], slot.gain) for j, slot in enumerate(field)])
        return found

    def linearized(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> tuple[Expression, Expression]:
        """All `distances`, body by body (k, 1), and their Jacobian by q (k, nq)."""
        field, distances, rows = self.slots(kinematics.robot).at(parameters), [], []
        present = None if (gains := _gains(field)) is None else diag(gains > 0)
        for body in bodies_of(kinematics, self._bodies):
            row, gradients = distances_with_gradients(body.points, [slot.distances for slot in field])
            row = body.thinner(row)
            distances += [_present(row[j], slot.gain) for j, slot in enumerate(field)]
            rates = 0
            for point, each in zip(body.points, gradients, strict=True):
                rates += each.T @ jacobian(point, kinematics.q)
            rows.append(rates if present is None else present @ rates)
        return vertcat(*distances), vertcat(*rows)

    def many(self, kinematics: Kinematics, parameters: Mapping[str, Expression], column: Expression) -> ManyDistances:
        """All `distances`, for functions with loops over the pairs.

        Args:
            kinematics: the robot at a symbolic configuration.
            parameters: expressions of the live parameters by name.
            column: all live parameters of the problem, symbols.
        """
        field = self.slots(kinematics.robot).at(parameters)
        bodies = bodies_of(kinematics, self._bodies)
        points, radii = [body.points for body in bodies], [body.radius for body in bodies]
        obstacles = [slot.distances for slot in field]
        return ManyDistances.to_obstacles(kinematics.q, column, points, radii, obstacles, _gains(field))

    @abstractmethod
    def potential(
        self, distances: Expression, gains: Expression | None, parameters: Mapping[str, Expression]
    ) -> Expression:
        """H without its gain as a function of the distances.

        Args:
            distances: distance [m] of each body to each obstacle, also to absent ones (bodies, obstacles).
            gains: the gain of each obstacle (obstacles, 1), None where there are none.
            parameters: expressions of the live parameters by name.
        """

    def potential_gradient(
        self, distances: Expression, gains: Expression | None, parameters: Mapping[str, Expression]
    ) -> Expression:
        """The derivatives of `potential` with respect to the distances, derived by CasADi; arguments are the same."""
        symbols = symbol("distances", *distances.shape)
        derivatives = gradient(self.potential(symbols, gains, parameters), vec(symbols))
        return substitute(reshape(derivatives, *distances.shape), symbols, distances)

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """The gain times the potential of the distances."""
        field = self.slots(kinematics.robot).at(parameters)
        rows = []
        for body in bodies_of(kinematics, self._bodies):
            rows.append(body.thinner(distances_of(body.points, [slot.distances for slot in field])))
        return parameters["gain"] * self.potential(vertcat(*rows), _gains(field), parameters)

    def value_and_gradient(
        self, kinematics: Kinematics, parameters: Mapping[str, Expression]
    ) -> tuple[Expression, Expression]:
        """The forces of all obstacles on each body, and one sweep along the robot that adds them up."""
        field, bodies = self.slots(kinematics.robot).at(parameters), bodies_of(kinematics, self._bodies)
        obstacles = [slot.distances for slot in field]
        found = [distances_with_gradients(body.points, obstacles) for body in bodies]
        distances = vertcat(*(body.thinner(row) for body, (row, _) in zip(bodies, found, strict=True)))
        # those of a subclass that replaces the potential are derived from it
        own = type(self) if belongs_to(self, "potential_gradient", "potential") else ObstacleCriterion
        derivatives = own.potential_gradient(self, distances, _gains(field), parameters)
        forces, gain = Forces(), parameters["gain"]
        for k, (body, (_, gradients)) in enumerate(zip(bodies, found, strict=True)):
            for point, each in zip(body.points, gradients, strict=True):
                forces.add(point, each @ derivatives[k, :].T)
        return gain * self.potential(distances, _gains(field), parameters), gain * forces.gradient(kinematics.q)

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


def _gains(field: Sequence[Slot]) -> Expression | None:
    """The gain of each obstacle (obstacles, 1); None where obstacles have none."""
    return None if any(slot.gain is None for slot in field) else vertcat(*(slot.gain for slot in field))


def _present(distance: Expression, gain: Expression | None) -> Expression:
    """The distance to an obstacle, 1e9 of one with the gain 0."""
    return distance if gain is None else if_else(gain > 0, distance, ABSENT)


def total(pairs: Expression, gains: Expression | None) -> Expression:
    """The sum of an expression for each pair (bodies, obstacles), those of each obstacle multiplied by its gain."""
    return sum1(vec(pairs)) if gains is None else sum1(pairs) @ gains

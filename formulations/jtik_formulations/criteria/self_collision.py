"""Self-collision: a cubic barrier of finite range for pairs of the robot's own bodies (self_collision.md)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cache
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from jtik import Criterion, register_criterion
from jtik.arguments import choice, non_negative_number, positive_number
from jtik.arguments import name as read_name
from jtik.constraints.many_distances import ManyDistances, Pair
from jtik.criterion.short_repr import call_text
from jtik.errors import ArgumentError
from jtik.geometry import segment_to_capsule, segment_to_segment
from jtik.robot import CollisionBody, CollisionPairs, Kinematics, Robot
from jtik.robot.collisions import BodyKind, PairNames, pair_names
from jtik.symbolic import Expression, Function, fmax, function, if_else, jacobian, symbol, vertcat, zeros
from jtik.symbolic.held import Hold, not_held, value_and_gradients
from jtik_formulations.bibliography import DIETRICH_2012
from jtik_formulations.criteria._parts.forces import Forces

NamedPoints: TypeAlias = tuple[tuple[str, Expression], ...]
"""Points (d, 1) [m] of a robot with a name for each."""

ABSENT = 1e9
"""Distance [m] of a pair with gain 0: farther than any influence reaches, and a finite number."""

SHORTEST_RANGE = 1e-4
"""Shortest ``influence`` [m] that is divided by."""


@register_criterion("self_collision")
class SelfCollision(Criterion):
    """H = gain * sum of gains_i * max(0, 1 - d_i / influence)^3, d_i the distance [m] of a pair of the robot's bodies.

    The pairs are those of `Robot.collision_pairs`, whose table shows them and the pairs that are left out. Each body is
    a capsule around a solid of the robot or, where it has none, around a link. H is zero where all pairs are farther
    apart than ``influence``, so it disturbs no other criterion there, and ``gain`` for each pair that touches. Value,
    gradient and Hessian are continuous in d, and H goes on to rise where bodies overlap, until their axes cross.

    It guarantees no distance. For that use the same object as the measure of a `jtik.Clearance`, with or without it
    among the criteria; a pair with gain 0 is then absent, too.

    Live parameters: ``self_collision.gain``, ``.influence`` [m] and ``.gains`` (k,), one for each pair in the order of
    ``robot.collision_pairs(...)``.

    Args:
        exclude: pairs that are left out, by the names of their frames or bodies: ``[("hand", "link5")]``, or
            ``["link0"]`` for all pairs with one.
        include: pairs that are kept, whatever the rule says.
        gain: non-negative; the unit of H.
        influence: positive distance [m] from which on a pair adds nothing.
        bodies: "shapes" or "links"; None for the solids of a robot that has any, else the links.
        radius: radius of the links [m].
        within: distance [m] below which a pair counts as one that can touch; at least ``safe`` and ``margin`` together
            of a `jtik.Clearance` that measures the pairs.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when an argument is out of range, or no two bodies of the robot can touch.
        UnknownNameError: when the robot has no body of a name.

    Source: Dietrich, Wimböck, Albu-Schäffer and Hirzinger (2012), the cubic repulsive potential.
    """

    summary = "pushes the robot's own bodies apart, zero until they are near each other"
    source = "Dietrich et al. 2012, the repulsive potential"
    non_negative_parameters = ("gain", "gains", "influence")
    bibtex = DIETRICH_2012

    def __init__(
        self,
        *,
        exclude: PairNames = (),
        include: PairNames = (),
        gain: float = 1.0,
        influence: float = 0.05,
        bodies: BodyKind | None = None,
        radius: float = 0.05,
        within: float = 0.02,
        name: str = "self_collision",
    ) -> None:
        self._exclude, self._include = pair_names("exclude", exclude), pair_names("include", include)
        self._gain = non_negative_number("gain", gain)
        self._influence = positive_number("influence", influence, "a positive distance [m]")
        if bodies is not None:
            choice("bodies", bodies, ("shapes", "links"))
        self._bodies = bodies
        self._radius = non_negative_number("radius", radius, "a non-negative length [m]")
        self._within = non_negative_number("within", within, "a non-negative distance [m]")
        self.name = read_name("name", name)

    @classmethod
    def example(cls, robot: Robot) -> SelfCollision:
        """One that measures a pair on any robot with two bodies, for tests."""
        pairs = robot.collision_pairs()
        if len(pairs) or not pairs.left_out:
            return cls()
        return cls(include=[(pairs.left_out[-1].first, pairs.left_out[-1].second)])

    def __repr__(self) -> str:
        given = (("exclude", self._exclude), ("include", self._include))
        named = ((key, [each if len(each) > 1 else each[0] for each in names]) for key, names in given if names)
        texts = [f"{key}={names}" for key, names in named]
        values = {
            "gain": self._gain,
            "influence": self._influence,
            "bodies": self._bodies,
            "radius": self._radius,
            "within": self._within,
            "name": self.name,
        }
        changed = {key: each for key, each in values.items() if each != _DEFAULTS[key]}
        return call_text(type(self).__name__, *texts, **changed)

    def pairs(self, robot: Robot) -> CollisionPairs:
        """The pairs on a robot, see `Robot.collision_pairs`.

        Raises:
            ArgumentError: when no two bodies can touch.
            UnknownNameError: when there is no body of a name.
        """
        pairs = robot.collision_pairs(
            exclude=self._exclude,
            include=self._include,
            bodies=self._bodies,
            radius=self._radius,
            within=self._within,
        )
        if not len(pairs):
            given = f"{robot!r}, of whose {len(pairs.bodies)} bodies no two can touch"
            raise ArgumentError("robot", given, "a robot with collision_pairs(), or include= for SelfCollision")
        return pairs

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Gain, influence and the gain of each pair."""
        return {"gain": self._gain, "influence": self._influence, "gains": np.ones(len(self.pairs(robot)))}

    def distances(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> list[list[Expression]]:
        """Signed distance [m] of each pair: one list for each, with one entry; 1e9 of one whose gain is 0."""
        measured = self._measured(kinematics, first_order=True)
        gains = parameters["gains"]
        return [[if_else(gains[i] > 0, distance, ABSENT)] for i, distance in enumerate(measured)]

    def rounding(self, robot: Robot, parameters: Mapping[str, Expression]) -> list[list[Expression]]:
        """For each distance the sum of both radii [m], which a `jtik.Clearance` needs; infinity where the gain is 0."""
        gains = parameters["gains"]
        radii = [first.radius + second.radius for first, second in self._bodies_of(robot)]
        return [[if_else(gains[i] > 0, radius, math.inf)] for i, radius in enumerate(radii)]

    def pair_names(self, robot: Robot) -> list[str]:
        """Names of the distances, in their order: "panda_link1[0] to panda_hand[0]"."""
        return [f"{pair.first} to {pair.second}" for pair in self.pairs(robot)]

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """gain * sum of gains_i * max(0, 1 - d_i / influence)^3."""
        inverse = 1 / fmax(parameters["influence"], SHORTEST_RANGE)
        total: Expression = 0
        for i, distance in enumerate(self._measured(kinematics)):
            near = fmax(1 - distance * inverse, 0)
            total = total + parameters["gains"][i] * near**2 * near
        return parameters["gain"] * total

    def value_and_gradient(
        self, kinematics: Kinematics, parameters: Mapping[str, Expression]
    ) -> tuple[Expression, Expression]:
        """The forces of each pair on the ends of its bodies, and one sweep along the robot that adds them up."""
        inverse = 1 / fmax(parameters["influence"], SHORTEST_RANGE)
        total, forces = 0, Forces()
        for i, (points, (distance, *gradients)) in enumerate(self._with_gradients(kinematics)):
            near, gain = fmax(1 - distance * inverse, 0), parameters["gains"][i]
            total = total + gain * near**2 * near
            slope = gain * near**2 * (-3 * inverse)
            for (_, point), each in zip(points, gradients, strict=True):
                forces.add(point, slope * each)
        return parameters["gain"] * total, parameters["gain"] * forces.gradient(kinematics.q)

    def linearized(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> tuple[Expression, Expression]:
        """All `distances` (k, 1), and their Jacobian by q (k, nq)."""
        gains, rates = parameters["gains"], dict[str, Expression]()
        distances, rows = [], []
        for i, (points, (distance, *gradients)) in enumerate(self._with_gradients(kinematics)):
            row = 0
            for (name, point), each in zip(points, gradients, strict=True):
                if name not in rates:
                    rates[name] = jacobian(point, kinematics.q)
                row += each.T @ rates[name]
            distances.append(if_else(gains[i] > 0, distance, ABSENT))
            rows.append((gains[i] > 0) * row)
        return vertcat(*distances), vertcat(*rows)

    def many(self, kinematics: Kinematics, parameters: Mapping[str, Expression], column: Expression) -> ManyDistances:
        """All `distances`, for functions with loops over the pairs.

        Args:
            kinematics: the robot at a symbolic configuration.
            parameters: expressions of the live parameters by name.
            column: all live parameters of the problem, symbols.
        """
        dimension, points, pairs = kinematics.robot.dimension, dict[str, Expression](), []
        measure = tuple(_pair_function(dimension, form, inline=True) for form in ("first_order", "gradients"))
        for ends, radius in self._ends(kinematics):
            points.update(ends)
            names = list(points)
            pairs.append(Pair(measure, tuple(names.index(name) for name, _ in ends), 0, radius))
        given = (kinematics.q, column, list(points.values()), pairs, [1] * len(pairs), zeros(0))
        return ManyDistances(*given, gains=parameters["gains"])

    def _measured(self, kinematics: Kinematics, *, first_order: bool = False) -> list[Expression]:
        """The distance of each pair."""
        measure = _pair_function(kinematics.robot.dimension, "first_order" if first_order else "value")
        return [measure(*(point for _, point in points)) - radius for points, radius in self._ends(kinematics)]

    def _with_gradients(self, kinematics: Kinematics) -> Iterator[tuple[NamedPoints, list[Expression]]]:
        """For each pair the ends of both bodies, its distance, and the gradient of the distance by each end."""
        measure = _pair_function(kinematics.robot.dimension, "gradients")
        for points, radius in self._ends(kinematics):
            distance, *gradients = measure(*(point for _, point in points))
            yield points, [distance - radius, *gradients]

    def _ends(self, kinematics: Kinematics) -> Iterator[tuple[NamedPoints, float]]:
        """For each pair the ends of both bodies with a name, each built once, and the sum of the radii [m]."""
        ends: dict[str, NamedPoints] = {}
        for pair in self._bodies_of(kinematics.robot):
            for body in pair:
                if body.name not in ends:
                    names = (f"{body.name} start", f"{body.name} end")
                    ends[body.name] = tuple(zip(names, body.ends(kinematics), strict=True))
            yield (*ends[pair[0].name], *ends[pair[1].name]), pair[0].radius + pair[1].radius

    def _bodies_of(self, robot: Robot) -> list[tuple[CollisionBody, CollisionBody]]:
        pairs = self.pairs(robot)
        return [(pairs.bodies[pair.first], pairs.bodies[pair.second]) for pair in pairs]


@cache
def _pair_function(dimension: int, form: str, *, inline: bool = False) -> Function:
    """(start, end, other start, other end) -> distance of two segments, with its gradients in the form "gradients".

    In the form "first_order" only its first derivatives are right. Unless it is to be written out, it is called.
    """
    points = [symbol(f"point{i}", dimension) for i in range(4)]

    def distance(hold: Hold) -> Expression:
        if dimension == 2:
            start, end, other_start, other_end = points
            return segment_to_capsule(start, end, other_start, other_end, 0.0, hold)
        return segment_to_segment(*points, first_order=form != "value")

    if form == "gradients":
        value, gradients = value_and_gradients(distance, points)
        return function("pair_gradients", points, [value, *gradients], inline=inline)
    return function(f"pair_{form}", points, [distance(not_held)], inline=inline)


_DEFAULTS = {
    "gain": 1.0,
    "influence": 0.05,
    "bodies": None,
    "radius": 0.05,
    "within": 0.02,
    "name": "self_collision",
}
"""What the repr does not show."""

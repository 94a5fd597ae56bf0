"""Slots for obstacles: a fixed number of each kind, whose numbers are live parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import array_of, flag, instances, integer, mapping
from jtik.errors import ArgumentError, UnknownNameError
from jtik.geometry.flat import Polygon
from jtik.geometry.kinds import KINDS, Kind
from jtik.geometry.pair_functions import Distances
from jtik.geometry.solids import Solid
from jtik.symbolic import Expression
from jtik.types import Array

CAPACITY = 16
"""Number of slots where none is given."""

CORNERS = 8
"""Number of corners that a polygon may have in a slot where no polygon has more."""

ABSENT = 1e9
"""Distance [m] of an obstacle with gain 0: farther than any influence reaches, and a finite number."""

ACCEPTED = {
    2: "jtik.Point or jtik.Circle with center (2,), Capsule, Box, HalfSpace or Polygon",
    3: "jtik.Point or jtik.Sphere with center (3,), Capsule, Box, Cylinder or HalfSpace",
}
"""Obstacles by dimension, for errors."""


@dataclass(frozen=True)
class Slot:
    """One obstacle as expressions.

    Attributes:
        distances: the distances to it.
        gain: its gain; None where obstacles have none. An obstacle with gain 0 is absent.
    """

    distances: Distances
    gain: Expression | None


@dataclass(frozen=True)
class Slots:
    """Places for a fixed number of obstacles of each kind. Filling, changing and emptying them compiles nothing.

    The slots are in the order ball, capsule, box, half_space, polygon, cylinder. Their values are, for each kind that
    occurs: ``centers`` and ``radii`` of balls; ``capsule_starts``, ``capsule_ends``, ``capsule_radii``;
    ``box_centers``, ``box_halves``, and ``box_rotations``, quaternions (w, x, y, z) or angles in the plane;
    ``half_space_points`` and ``half_space_normals``; ``polygon_vertices``, the coordinates of the corners in a row,
    convex and counterclockwise; ``cylinder_starts``, ``cylinder_ends``, ``cylinder_radii``; and ``gains``, one for each
    slot.

    Attributes:
        counts: number of slots of each kind: "ball" (points, circles and spheres), "capsule", "box", "half_space",
            "polygon" (in the plane) and "cylinder" (in space).
        dimension: 2 for the plane, 3 for space.
        corners: largest number of corners of a polygon.
        gains: whether each slot has a gain.

    Raises:
        ArgumentError: when a count is no integer from 0, or the kind is not one of that dimension.
        UnknownNameError: when there is no such kind.
    """

    counts: Mapping[str, int]
    dimension: int
    corners: int = CORNERS
    gains: bool = True

    def __post_init__(self) -> None:
        if self.dimension not in (2, 3) or isinstance(self.dimension, bool):
            raise ArgumentError("dimension", self.dimension, "2 for the plane, 3 for space")
        counts = read_counts("counts", self.counts)
        for kind in KINDS:
            if counts.get(kind.name) and self.dimension not in kind.dimensions:
                where = "the plane" if self.dimension == 2 else "space"
                raise ArgumentError("counts", f"{counts[kind.name]} {kind.name} slots", f"none of this kind in {where}")
        integer("corners", self.corners, minimum=1)
        flag("gains", self.gains, "whether each slot has a gain")
        object.__setattr__(self, "counts", MappingProxyType({kind.name: counts.get(kind.name, 0) for kind in KINDS}))

    @classmethod
    def of(
        cls,
        obstacles: Iterable[Solid] | Solid,
        capacity: int | Mapping[str, int] | None,
        dimension: int,
        *,
        gains: bool = True,
    ) -> Slots:
        """Slots for these obstacles, and for more.

        Args:
            obstacles: points, circles, spheres, capsules, boxes, half-spaces, polygons or cylinders.
            capacity: total number of slots; those that the obstacles leave are divided evenly among the kinds that
                occur, the first kinds having one more, and are balls where there is no obstacle. Or the number of each
                kind, such as ``{"ball": 8, "box": 4}``. 16, or as many as there are obstacles, by default.
            dimension: 2 for the plane, 3 for space.
            gains: whether each slot has a gain.

        Raises:
            ArgumentError: when there are more obstacles than slots, or one is not of that dimension.
            UnknownNameError: when a kind does not exist.
        """
        found = read_obstacles(obstacles, dimension)
        counts = {kind.name: sum(isinstance(each, kind.solid) for each in found) for kind in KINDS}
        most = max([CORNERS, *(len(each.vertices) for each in found if isinstance(each, Polygon))])
        if isinstance(capacity, Mapping):
            slots = cls(capacity, dimension, most, gains)
            slots.check_room(counts)
            return slots
        total = max(CAPACITY, len(found)) if capacity is None else integer("capacity", capacity, minimum=1)
        if len(found) > total:
            raise ArgumentError("obstacles", f"{len(found)} obstacles", f"at most {total}, the capacity")
        used = [name for name, count in counts.items() if count] or ["ball"]
        for i in range(total - len(found)):
            counts[used[i % len(used)]] += 1
        return cls(counts, dimension, most, gains)

    @classmethod
    def exactly(cls, obstacles: Iterable[Solid] | Solid, dimension: int, *, gains: bool = False) -> Slots:
        """As many slots as obstacles, by default without gains.

        Args:
            obstacles: as in `of`.
            dimension: 2 for the plane, 3 for space.
            gains: whether each slot has a gain.

        Raises:
            ArgumentError: when an obstacle is not of that dimension.
        """
        found = read_obstacles(obstacles, dimension)
        counts = {kind.name: sum(isinstance(each, kind.solid) for each in found) for kind in KINDS}
        most = max([3, *(len(each.vertices) for each in found if isinstance(each, Polygon))])
        return cls(counts, dimension, most, gains)

    def __len__(self) -> int:
        return sum(self.counts.values())

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """The kinds that have slots."""
        return tuple(kind for kind in KINDS if self.counts[kind.name])

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each slot, such as "box 0"; numbers where all are balls."""
        if self.counts["ball"] == len(self):
            return tuple(f"obstacle {i}" for i in range(len(self)))
        return tuple(f"{kind.name} {i}" for kind in self.kinds for i in range(self.counts[kind.name]))

    def place(self, obstacles: Iterable[Solid] | Solid) -> tuple[int, ...]:
        """The slot of each obstacle: those of one kind in their order.

        Args:
            obstacles: as many as fit.

        Raises:
            ArgumentError: when they do not fit.
        """
        found = read_obstacles(obstacles, self.dimension)
        self.check_room({kind.name: sum(isinstance(each, kind.solid) for each in found) for kind in KINDS})
        free, start = {}, 0
        for kind in KINDS:
            free[kind.name] = iter(range(start, start + self.counts[kind.name]))
            start += self.counts[kind.name]
        return tuple(next(free[kind.name]) for each in found for kind in KINDS if isinstance(each, kind.solid))

    def parameters(self, obstacles: Iterable[Solid] | Solid, gains: ArrayLike | None = None) -> dict[str, Array]:
        """Values of the live parameters for these obstacles; slots that are not used have the gain 0.

        Args:
            obstacles: as many as fit.
            gains: the gain of each obstacle, non-negative; 1 by default.

        Raises:
            ArgumentError: when the obstacles do not fit, or the gains are not one for each of them.
        """
        found = read_obstacles(obstacles, self.dimension)
        places = self.place(found)
        values: dict[str, Array] = {}
        for kind in self.kinds:
            own: list[Solid] = [each for each in found if isinstance(each, kind.solid)]
            own += [kind.absent(self.dimension)] * (self.counts[kind.name] - len(own))
            if kind.name == "polygon":
                self._check_corners(own)
            values.update(kind.values(own, self.dimension, self.corners))
        if self.gains:
            values["gains"] = np.zeros(len(self))
            values["gains"][list(places)] = np.ones(len(found)) if gains is None else read_gains(gains, len(found))
        return values

    @property
    def non_negative(self) -> tuple[str, ...]:
        """Names of the parameters that no negative number can be assigned to."""
        return (*(name for kind in self.kinds for name in kind.sizes), *(["gains"] if self.gains else []))

    @staticmethod
    def accepted_instead(parameter: str, value: Array) -> str | None:
        """What would be accepted instead of a value of a parameter; None where the value is accepted.

        Corners are those of a convex polygon, counterclockwise; normals and quaternions are not zero.

        Args:
            parameter: name of the parameter.
            value: the value assigned to it.
        """
        for kind in KINDS:
            if parameter in kind.judged:
                return next(filter(None, map(kind.accepted_instead, np.asarray(value))), None)
        return None

    def at(self, parameters: Mapping[str, Expression]) -> list[Slot]:
        """Every slot as expressions of the parameters, which have the shapes of `parameters`.

        Args:
            parameters: expressions of the live parameters by name.
        """
        distances = [kind.at(parameters, i) for kind in self.kinds for i in range(self.counts[kind.name])]
        return [Slot(each, parameters["gains"][i] if self.gains else None) for i, each in enumerate(distances)]

    def check_room(self, counts: Mapping[str, int]) -> None:
        """Raise ArgumentError where there are more obstacles of a kind than slots for it.

        Args:
            counts: number of obstacles of each kind.
        """
        for name, count in counts.items():
            if count > self.counts[name]:
                given = f"{count} obstacle{'s' * (count != 1)} of the kind {name!r}"
                raise ArgumentError("obstacles", given, f"at most {self.counts[name]}, the capacity for this kind")

    def _check_corners(self, polygons: Sequence[Solid]) -> None:
        for each in polygons:
            if isinstance(each, Polygon) and len(each.vertices) > self.corners:
                accepted = f"at most {self.corners} corners in these slots"
                raise ArgumentError("obstacles", f"a polygon with {len(each.vertices)} corners", accepted)


def read_obstacles(obstacles: Iterable[Solid] | Solid, dimension: int) -> tuple[Solid, ...]:
    """The obstacles. Raises ArgumentError for what is none, or is not of that dimension."""
    found = instances("obstacles", obstacles, Solid, ACCEPTED[dimension])
    for each in found:
        if not any(isinstance(each, kind.solid) for kind in KINDS) or each.dimension != dimension:
            raise ArgumentError("obstacles", each, f"{ACCEPTED[dimension]} on this {dimension}-dimensional robot")
    return found


def read_gains(gains: ArrayLike, count: int) -> Array:
    """The gains (count,). Raises ArgumentError unless they are as many non-negative numbers."""
    accepted = f"{count} non-negative numbers, one for each obstacle"
    if not count and np.size(gains) == 0:
        return np.zeros(0)
    return array_of("gains", gains, [(count,)], accepted, lambda values: np.isfinite(values) & (values >= 0))


def read_counts(argument: str, counts: object) -> dict[str, int]:
    """Counts by kind. Raises ArgumentError for anything else, UnknownNameError for an unknown kind."""
    given = mapping(argument, counts, 'a dict from a kind to a count, such as {"ball": 8, "box": 4}')
    for name, count in given.items():
        if name not in {kind.name for kind in KINDS}:
            raise UnknownNameError("kind of obstacle", name, [kind.name for kind in KINDS])
        integer(f"{argument}[{name!r}]", count)
    return {str(name): int(count) for name, count in given.items()}

"""Measures of distances between bodies and obstacles: what a `Clearance` keeps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, runtime_checkable

from numpy.typing import ArrayLike

from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression


@runtime_checkable
class Measure(Protocol):
    """A measure of distances [m]: a criterion with parameters and signed distances of each body to each obstacle.

    Each distance is that of a body, which the robot moves, to a fixed set or to another body of the robot, less a
    radius that is not negative: the bound between the samples of a step (formulations/clearance.md, (C6)) holds for
    these. A method ``rounding(robot,
    parameters)`` may return that radius [m] for each distance, in the same lists: the larger it is, the longer are the
    steps near an obstacle. It returns infinity where the set is a half-space, and None for a distance of another kind,
    which a `Clearance` refuses. Without the method the radius is 0.

    A method ``linearized(kinematics, parameters)`` may return all distances as one column (k, 1), body by body, with
    their Jacobian by q (k, nq), where these take fewer operations than what CasADi derives.

    A method ``many(kinematics, parameters, column)`` may return a `ManyDistances` of the same distances in the same
    order, ``column`` being the symbols of all live parameters: where they are many, there are loops over them.

    Methods ``body_names(robot)`` and ``obstacle_names(robot)`` may return names for reports, or ``pair_names(robot)``
    one for each distance.

    Attributes:
        name: name of the criterion.
    """

    name: str

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Names and first values of its live parameters.

        Args:
            robot: the robot.
        """

    def distances(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> list[list[Expression]]:
        """Distances [m]: one list for each body, with one entry for each obstacle.

        Args:
            kinematics: the robot at a symbolic configuration.
            parameters: expressions of the live parameters by name.
        """


def rounding_of(
    measure: Measure, robot: Robot, parameters: Mapping[str, Expression], bodies: Sequence[Sequence[Expression]]
) -> list[list[Expression]]:
    """For each distance the radius of the set that it is measured to [m].

    Raises:
        ArgumentError: where the measure has no bound for a distance.
    """
    rounding = getattr(measure, "rounding", None)
    if not callable(rounding):
        return [[0.0] * len(body) for body in bodies]
    found = [list(body) for body in rounding(robot, parameters)]
    names = names_of(measure, "body_names", robot, len(bodies), "body")
    for name, body, distances in zip(names, found, bodies, strict=True):
        for i, (radius, _) in enumerate(zip(body, distances, strict=True)):
            if radius is None:
                accepted = "distances whose change between two samples is bounded: Measure.rounding is no radius here"
                raise ArgumentError("measure", f"{measure!r} with the distance {i} of {name}", accepted)
    return found


def pair_names(clearance: Any, robot: Robot, bodies: Sequence[Sequence[Expression]]) -> list[str]:
    """The name of each distance of a clearance: ``clearance: link1-link2 to obstacle 0``."""
    named = getattr(clearance.measure, "pair_names", None)
    if callable(named):
        return [f"{clearance.name}: {pair}" for pair in named(robot)]
    names = names_of(clearance.measure, "body_names", robot, len(bodies), "body")
    found = []
    for name, distances in zip(names, bodies, strict=True):
        others = names_of(clearance.measure, "obstacle_names", robot, len(distances), "obstacle")
        found += [f"{clearance.name}: {name} to {other}" for other in others]
    return found


def names_of(measure: Measure, method: str, robot: Robot, count: int, otherwise: str) -> list[str]:
    """The names that a method of a measure returns, where it has it and they are so many, else numbers."""
    named = getattr(measure, method, None)
    names = list(named(robot)) if callable(named) else []
    return names if len(names) == count else [f"{otherwise} {i}" for i in range(count)]

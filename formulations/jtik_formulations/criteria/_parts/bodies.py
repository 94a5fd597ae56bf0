"""The bodies of a robot that distances are measured of: points, links and its own solids."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from jtik.errors import ArgumentError
from jtik.geometry import Ball, Solid, enclosing_balls, enclosing_segment
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression
from jtik.types import Array

BodyChoice: TypeAlias = Literal["joints", "links", "both", "shapes", "spheres"]

CHOICES = ("joints", "links", "both", "shapes", "spheres")


@dataclass(frozen=True)
class Body:
    """A body of a robot at one configuration.

    Attributes:
        name: made of the names of its frames.
        points: one point, or both ends of a segment, (d, 1) [m] each.
        radius: radius [m] around them.
    """

    name: str
    points: tuple[Expression, ...]
    radius: float = 0.0

    def thinner(self, distances: Expression) -> Expression:
        """Distances [m] of its surface, from those of its points."""
        return distances - self.radius if self.radius else distances


def bodies_of(kinematics: Kinematics, choice: str) -> list[Body]:
    """The bodies that ``bodies=`` names.

    Raises:
        ArgumentError: for "shapes" or "spheres" of a robot without solids that move.
    """
    robot, found = kinematics.robot, list[Body]()
    if choice in ("joints", "both"):
        found += [Body(frame, (kinematics.position(frame),)) for frame in robot.moving_frames]
    if choice in ("links", "both"):
        for start, end in robot.segments:
            found.append(Body(f"{start}-{end}", (kinematics.position(start), kinematics.position(end))))
    for frame, points, radius in _solids(robot, choice):
        found.append(Body(frame, tuple(kinematics.point(frame, each) for each in points), radius))
    return found


def names_of_bodies(robot: Robot, choice: str) -> list[str]:
    """The names of `bodies_of`, in their order."""
    joints = list(robot.moving_frames) if choice in ("joints", "both") else []
    links = [f"{start}-{end}" for start, end in robot.segments] if choice in ("links", "both") else []
    return joints + links + [frame for frame, _, _ in _solids(robot, choice)]


def radii_of_bodies(robot: Robot, choice: str) -> list[float]:
    """The radii of `bodies_of`, in their order [m]."""
    return [radius for _, _, radius in _solids(robot, choice)] or [0.0] * len(names_of_bodies(robot, choice))


def _solids(robot: Robot, choice: str) -> list[tuple[str, tuple[Array, ...], float]]:
    """Frame, points in it and radius of each body around a solid; none unless solids are chosen."""
    found: list[tuple[str, tuple[Array, ...], float]] = []
    for frame, solid in moving_solids(robot) if choice in ("shapes", "spheres") else ():
        balls = enclosing_balls(solid) if choice == "spheres" else []
        found += [(frame, (center,), radius) for center, radius in balls]
        if not balls:
            first, last, radius = enclosing_segment(solid)
            found.append((frame, (first,) if isinstance(solid, Ball) else (first, last), radius))
    return found


def moving_solids(robot: Robot) -> list[tuple[str, Solid]]:
    """The solids that a joint moves, with their frames. Raises ArgumentError where there is none."""
    found = []
    for frame, solids in robot.shapes.items():
        if any(joint.is_moving for joint in robot.path(frame)):
            found += [(frame, solid) for solid in solids]
    if not found:
        given = f"the solids of {robot!r}, which has none that moves"
        raise ArgumentError("bodies", given, "'joints', 'links' or 'both'")
    return found

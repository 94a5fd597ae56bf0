"""The bodies of a robot that distances are measured of: points, links and its own solids."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from jtik.errors import ArgumentError
from jtik.geometry import Ball, Solid, enclosing_segment
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression

BodyChoice: TypeAlias = Literal["joints", "links", "both", "shapes"]

CHOICES = ("joints", "links", "both", "shapes")


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


def bodies_of(kinematics: Kinematics, choice: str) -> list[Body]:
    """The bodies that ``bodies=`` names.

    Raises:
        ArgumentError: for "shapes" of a robot without solids that move.
    """
    robot, found = kinematics.robot, list[Body]()
    if choice in ("joints", "both"):
        found += [Body(frame, (kinematics.position(frame),)) for frame in robot.moving_frames]
    if choice in ("links", "both"):
        for start, end in robot.segments:
            found.append(Body(f"{start}-{end}", (kinematics.position(start), kinematics.position(end))))
    if choice == "shapes":
        for frame, solid in moving_solids(robot):
            first, last, radius = enclosing_segment(solid)
            ends = (first,) if isinstance(solid, Ball) else (first, last)
            found.append(Body(frame, tuple(kinematics.point(frame, each) for each in ends), radius))
    return found


def names_of_bodies(robot: Robot, choice: str) -> list[str]:
    """The names of `bodies_of`, in their order."""
    joints = list(robot.moving_frames) if choice in ("joints", "both") else []
    links = [f"{start}-{end}" for start, end in robot.segments] if choice in ("links", "both") else []
    return joints + links + ([frame for frame, _ in moving_solids(robot)] if choice == "shapes" else [])


def radii_of_bodies(robot: Robot, choice: str) -> list[float]:
    """The radii of `bodies_of`, in their order [m]."""
    if choice == "shapes":
        return [enclosing_segment(solid)[2] for _, solid in moving_solids(robot)]
    return [0.0] * len(names_of_bodies(robot, choice))


def moving_solids(robot: Robot) -> list[tuple[str, Solid]]:
    """The solids that a joint moves, with their frames. Raises ArgumentError where there is none."""
    found = []
    for frame, solids in robot.shapes.items():
        if any(joint.is_moving for joint in robot.path(frame)):
            found += [(frame, solid) for solid in solids]
    if not found:
        given = f"'shapes' on {robot!r}, which has no solids that move"
        raise ArgumentError("bodies", given, "'joints', 'links' or 'both'")
    return found

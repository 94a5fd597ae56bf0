"""The bodies of a robot that may touch each other: capsules around its solids, or its links."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from jtik.geometry import enclosing_segment
from jtik.robot.skeleton import shared_origins
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.robot.kinematics import Kinematics
    from jtik.robot.model import Robot
    from jtik.symbolic import Expression

BodyKind: TypeAlias = Literal["shapes", "links"]
"""Solids of the robot, or the links of its skeleton."""


@dataclass(frozen=True, eq=False)
class CollisionBody:
    """A capsule on a robot.

    Attributes:
        name: its name: that of its frame, with a number in brackets where the frame has several solids; or
            "INNER-OUTER", the frames at the ends of a link.
        frames: the frames that carry the start and the end of its axis.
        offsets: the start and the end in these frames, (3,) [m] each.
        radius: its radius [m].
        carrier: the frame that moves it: the child of the last joint that does, or the base.
    """

    name: str
    frames: tuple[str, str]
    offsets: tuple[Array, Array]
    radius: float
    carrier: str

    @property
    def names(self) -> tuple[str, ...]:
        """The names that mean it: its own, and that of the frame that it is on."""
        return (self.name, self.frames[0])

    def ends(self, kinematics: Kinematics) -> tuple[Expression, Expression]:
        """Start and end of its axis in the base frame, (3, 1) each [m], or (2, 1) of a planar robot.

        Args:
            kinematics: the robot at a symbolic configuration.
        """
        start, end = (kinematics.point(frame, offset) for frame, offset in zip(self.frames, self.offsets, strict=True))
        return start, end


def collision_bodies(robot: Robot, kind: BodyKind, radius: float) -> tuple[CollisionBody, ...]:
    """The bodies of a robot.

    Args:
        robot: the robot.
        kind: "shapes", the capsules around its solids; or "links", the links of its skeleton.
        radius: radius of the links [m].
    """
    if kind == "links":
        origins, zero = shared_origins(robot), np.zeros(3)
        carriers = {joint.child: joint.parent for joint in robot.joints}
        return tuple(
            CollisionBody(
                f"{inner}-{outer}", (inner, outer), (zero, zero), radius, carrier_of(robot, carriers[origins[outer]])
            )
            for inner, outer in robot.segments
        )
    bodies = []
    for frame, solids in robot.shapes.items():
        for i, (start, end, around) in enumerate(map(enclosing_segment, solids)):
            name = frame if len(solids) == 1 else f"{frame}[{i}]"
            bodies.append(CollisionBody(name, (frame, frame), (start, end), around, carrier_of(robot, frame)))
    return tuple(bodies)


def carrier_of(robot: Robot, frame: str) -> str:
    """The child of the last joint that moves a frame; the base where none does."""
    moving = [joint.child for joint in robot.path(frame) if joint.is_moving]
    return moving[-1] if moving else robot.base

"""The body of a spatial robot as surfaces on its frames, and as rounded links between them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jtik.arguments import choice, instance
from jtik.plotting.surfaces import Surface, capsule, surface
from jtik.robot import Robot
from jtik.symbolic import function, horzcat, symbol
from jtik.types import Array

THICKNESS = 0.018
"""Radius of a link without a solid, as a share of the robot's longest reach."""


class Part(NamedTuple):
    """A surface on a frame.

    Attributes:
        frame: name of the frame.
        surface: the surface, in the frame's coordinates.
    """

    frame: str
    surface: Surface


class Poses:
    """Poses of all frames of a robot, by one compiled function.

    Attributes:
        robot: the robot.
        frames: names of its frames.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot, self.frames = robot, robot.frame_names
        q = symbol("q", robot.nq)
        kinematics = robot.at(q)
        self._function = function("poses", [q], [horzcat(*[kinematics.pose(frame)[:3, :] for frame in self.frames])])

    def __call__(self, q: Array) -> dict[str, Array]:
        """The pose (4, 4) [m] of each frame at a configuration (nq,)."""
        table = self._function(q).full().reshape(3, len(self.frames), 4).transpose(1, 0, 2)
        poses = np.tile(np.eye(4), (len(self.frames), 1, 1))
        poses[:, :3] = table
        return dict(zip(self.frames, poses, strict=True))


class Body:
    """What is drawn of a spatial robot.

    Args:
        robot: the robot.
        show: "shapes" for its solids, "links" for rounded links between its joints; a robot without solids has links.

    Attributes:
        robot: the robot.
        parts: the surfaces on its frames.
        links: the pairs of frames between which there is a link.
        radius: radius of these links [m].
    """

    def __init__(self, robot: Robot, show: str = "shapes") -> None:
        self.robot = instance("robot", robot, Robot, "a jtik.Robot")
        choice("show", show, ("shapes", "links"))
        solid = show == "shapes" and any(robot.shapes.values())
        self.parts = [Part(frame, surface(each)) for frame, own in robot.shapes.items() for each in own if solid]
        self.links = () if solid else robot.segments
        self.radius = THICKNESS * reach(robot)
        self._poses = Poses(robot)

    def surfaces(self, q: ArrayLike) -> list[Surface]:
        """Its surfaces at a configuration (nq,), in the base frame."""
        poses = self._poses(self.robot.configuration(q))
        links = [capsule(poses[inner][:3, 3], poses[outer][:3, 3], self.radius) for inner, outer in self.links]
        return [part.surface.at(poses[part.frame]) for part in self.parts] + links


def reach(robot: Robot) -> float:
    """Length of the robot's longest chain of links, at its neutral configuration [m]; 1 without links."""
    poses = Poses(robot)(robot.neutral)
    steps = {
        joint.name: float(np.linalg.norm(poses[joint.child][:3, 3] - poses[joint.parent][:3, 3]))
        for joint in robot.joints
    }
    return max(sum(steps[joint.name] for joint in robot.path(frame)) for frame in robot.frame_names) or 1.0


def triangles(surfaces: list[Surface]) -> tuple[Array, NDArray[np.int64]]:
    """The triangles of several surfaces, (m, 3, 3) [m], and the number of the surface of each, (m,)."""
    if not surfaces:
        return np.zeros((0, 3, 3)), np.zeros(0, dtype=np.int64)
    corners = [each.vertices[each.faces] for each in surfaces]
    owners = [np.full(len(each), k) for k, each in enumerate(corners)]
    return np.concatenate(corners), np.concatenate(owners)

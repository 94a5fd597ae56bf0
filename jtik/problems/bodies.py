"""A robot's links as segments with a radius: their positions and their distance to a point."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from jtik.errors import ArgumentError
from jtik.geometry import enclosing_segment
from jtik.robot import Robot
from jtik.symbolic import function, horzcat, symbol
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array


@dataclass(frozen=True)
class Links:
    """The links at one configuration.

    Attributes:
        start: first ends of the segments, (k, dimension) [m].
        end: second ends of the segments, (k, dimension) [m].
        radius: radii, (k,) [m].
    """

    start: Array
    end: Array
    radius: Array

    def distance(self, point: Array) -> float:
        """Distance from a point to the closest link surface [m]."""
        along = self.end - self.start
        squared = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
        share = np.clip(((point - self.start) * along).sum(axis=1) / squared, 0, 1)
        closest = self.start + share[:, None] * along
        return float((np.linalg.norm(point - closest, axis=1) - self.radius).min())

    def point(self, generator: np.random.Generator) -> Array:
        """A random point on the axis of a link: both the link and the position along it are uniform."""
        i, share = int(generator.integers(len(self.start))), generator.random()
        point: Array = self.start[i] + share * (self.end[i] - self.start[i])
        return point


class Bodies:
    """The links of a robot: the segments of its skeleton, or its moving solids enclosed in capsules.

    Args:
        robot: the robot.
        shapes: whether to use the solids instead of the skeleton.

    Raises:
        ArgumentError: if ``shapes`` is True and no solid moves, or if the skeleton has no segment.
    """

    def __init__(self, robot: Robot, *, shapes: bool) -> None:
        self._robot = robot
        if shapes:
            moving = [frame for frame in robot.shapes if any(joint.is_moving for joint in robot.path(frame))]
            solids = [(frame, enclosing_segment(solid)) for frame in moving for solid in robot.shapes[frame]]
            self._ends = [(frame, frame, first, last) for frame, (first, last, _) in solids]
            self._radius = np.array([radius for _, (_, _, radius) in solids])
        else:
            origin = np.zeros(3)
            self._ends = [(inner, outer, origin, origin) for inner, outer in robot.segments]
            self._radius = np.zeros(len(self._ends))
        if not self._ends:
            accepted = "False: the robot has no solids that move" if shapes else "a robot with links"
            raise ArgumentError("shapes" if shapes else "robot", shapes if shapes else robot, accepted)

    def at(self, q: Array) -> Links:
        """The links at q (nq,)."""
        start, end = self._measured(q)
        return Links(start.T, end.T, self._radius)

    @cached_property
    def _measured(self) -> CompiledFunction:
        """q -> first and second ends (dimension, k) [m]."""
        robot, q = self._robot, symbol("q", self._robot.nq)
        kinematics = robot.at(q)
        start = [kinematics.point(inner, first)[: robot.dimension] for inner, _, first, _ in self._ends]
        end = [kinematics.point(outer, last)[: robot.dimension] for _, outer, _, last in self._ends]
        return CompiledFunction(function("links", [q], [horzcat(*start), horzcat(*end)]))

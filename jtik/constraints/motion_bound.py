"""Upper bounds of the motion of a robot's points along a step (formulations/clearance.md, (C6))."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from jtik.geometry import enclosing_segment
from jtik.robot import Joint, JointType, Robot
from jtik.robot.stroke import stroke
from jtik.symbolic import Expression, fabs, fmax, if_else, sqrt
from jtik.types import Array


@dataclass(frozen=True)
class MotionBound:
    """Bounds of the motion of the robot's frames, links and solids along a straight path from one configuration.

    They depend on the configuration and on the path, not on limits: how far a prismatic joint or a free base is out is
    known from both ends of the path, also without limits and for a mimic joint. For a robot of revolute and ball
    joints they are constants.

    Attributes:
        robot: the robot.
        q: configuration at the start of the path (nq, 1).
    """

    robot: Robot
    q: Expression

    def lever_arms(self, dq: Expression | None = None) -> list[Expression]:
        """Largest motion of any point per unit of each velocity entry on the path, (n,) [m/rad] or [m/m].

        Args:
            dq: displacement of the path (n, 1); none for the rates at q alone.
        """
        robot = self.robot
        end = self.q if dq is None or not self.translates else robot.integrate(self.q, dq)
        strokes = {joint.name: stroke(robot, joint, self.q, end) for joint in robot.joints}
        beyond: dict[str, Expression] = {frame: _largest_extent(robot, frame) for frame in robot.frame_names}
        for joint in reversed(_outward(robot)):
            length = float(np.linalg.norm(joint.origin[:3, 3])) + strokes[joint.name]
            beyond[joint.parent] = _larger(beyond[joint.parent], length + beyond[joint.child])
        arms: list[Expression] = [0.0] * robot.n
        for joint in filter(_moves, robot.joints):
            for j, turns in enumerate(joint.type.rotational, start=robot.v_slice(joint.name).start):
                arms[j] = arms[j] + _gain(joint) * (beyond[joint.child] if turns else 1.0)
        return arms

    @cached_property
    def rotations(self) -> Array:
        """Largest rotation of any link per unit of each velocity entry, (n,) [rad/rad] or [rad/m]."""
        turned = np.zeros(self.robot.n)
        for joint in filter(_moves, self.robot.joints):
            turned[self.robot.v_slice(joint.name)] += _gain(joint) * np.array(joint.type.rotational)
        return turned

    @cached_property
    def translates(self) -> bool:
        """Whether any joint has a translation."""
        return any(joint.type in (JointType.PRISMATIC, JointType.FREE) for joint in self.robot.joints)

    def lengths(self, dq: Expression) -> tuple[Expression, Expression]:
        """Bounds of the length of any point's path [m], L, and of its second derivative over L, S [rad].

        A rotation moves the axis of a prismatic joint behind it: each such pair of entries counts twice in S.
        """
        size = [fabs(dq[j]) for j in range(self.robot.n)]
        travelled = sum(arm * each for arm, each in zip(self.lever_arms(dq), size, strict=True))
        turned = sum(rate * each for rate, each in zip(self.rotations.tolist(), size, strict=True) if rate)
        return travelled, (2 if self.translates else 1) * turned

    @cached_property
    def row_norm_bound(self) -> Expression:
        """Upper bound of the norm of a row of the Jacobian of distances at q [m]."""
        total = sum((arm**2 for arm in self.lever_arms()), 0.0)
        return sqrt(if_else(total > 0, total, 1.0))


def _moves(joint: Joint) -> bool:
    """Whether it is no fixed joint."""
    return joint.is_moving


def _gain(joint: Joint) -> float:
    """Ratio of a joint's rate to the velocity entry that moves it."""
    return 1.0 if joint.mimic is None else abs(joint.mimic.multiplier)


def _larger(a: Expression, b: Expression) -> Expression:
    """The larger of two lengths, a number if both are."""
    return max(a, b) if isinstance(a, float) and isinstance(b, float) else fmax(a, b)


def _outward(robot: Robot) -> list[Joint]:
    """The joints, each after the one that carries it."""
    return sorted(robot.joints, key=lambda joint: len(robot.path(joint.child)))


def _largest_extent(robot: Robot, frame: str) -> float:
    """Distance of the farthest point of a frame's solids from its origin [m]."""
    farthest = 0.0
    for a, b, radius in (enclosing_segment(solid) for solid in robot.shapes.get(frame, ())):
        farthest = max(farthest, float(np.linalg.norm(a)) + radius, float(np.linalg.norm(b)) + radius)
    return farthest

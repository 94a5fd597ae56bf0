"""Robotics Toolbox for Python as a contender: Levenberg-Marquardt in C++ on elementary transforms."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from jtik.errors import ArgumentError
from jtik.robot import JointType
from jtik.study.contender import Answer, PreparedContender
from jtik.study.peers.base import Goal, Peer
from jtik.types import Array

Method = Literal["chan", "wampler", "sugihara"]


@dataclass(kw_only=True)
class ToolboxPeer(Peer):
    """``ETS.ik_LM``. It draws its own restarts, which differ from call to call.

    The defaults are the best of a search over seven arms: Chan with k from 1 to 0.01, Sugihara from 0.1 to 0.0001,
    Wampler from 0.01 to 0.0001, 12 to 30 iterations for an attempt, orientation weights 1 to 0.1. It wraps both
    revolute and prismatic joints to (-pi, pi) before it checks limits.

    Attributes:
        label: name of the library in a study.
        method: damping rule.
        k: gain of the damping.
        orientation_weight: weight of one squared radian relative to one squared metre.
        restarted: maximum iterations of an attempt if restarts are allowed.
    """

    label: str = "rtb"
    method: Method = "chan"
    k: float = 0.1
    orientation_weight: float = 1.0
    restarted: int = 30
    module: ClassVar[str] = "roboticstoolbox"
    package: ClassVar[str] = "roboticstoolbox-python"
    optimizes = False

    def check(self, goal: Goal) -> None:
        """Raise ArgumentError for a prismatic joint whose limits exceed (-pi, pi) m."""
        super().check(goal)
        for joint in goal.robot.path(goal.frame):
            if joint.type is JointType.PRISMATIC and max(abs(joint.lower), abs(joint.upper)) > math.pi:
                given = f"prismatic joint {joint.name!r}, from {joint.lower:g} to {joint.upper:g} m"
                raise ArgumentError(
                    "robot", given, f"for {self.label}: prismatic joints within pi m, because it wraps them like angles"
                )

    def build(self, library: Any, goal: Goal) -> PreparedContender:
        """Build it on the chain from the base to the frame."""
        return _PreparedToolbox(library, goal, self)


class _PreparedToolbox(PreparedContender):
    """The solver of the toolbox."""

    def __init__(self, library: Any, goal: Goal, options: ToolboxPeer) -> None:
        setting, weight = goal.setting, options.orientation_weight
        self._goal, self._ets = goal, _chain(library, goal)
        self._numbers = list(goal.chain_indices)
        position, orientation = ([1, 1, 0], [0, 0, weight]) if goal.planar else ([1, 1, 1], [weight] * 3)
        mask = [*(position if goal.has_position else [0, 0, 0]), *(orientation if goal.has_orientation else [0, 0, 0])]
        squares = [
            *([setting.position_tolerance**2] if goal.has_position else []),
            *([weight * setting.orientation_tolerance**2] if goal.has_orientation else []),
        ]
        max_iterations = setting.max_iterations
        self._options = {
            "ilimit": min(max_iterations, options.restarted) if setting.restarts else max_iterations,
            "slimit": setting.restarts + 1,
            "tol": 0.5 * min(squares),  # its error is half the weighted sum of squares of all rows
            "mask": np.array(mask, dtype=float),
            "k": options.k,
            "method": options.method,
        }

    def convert(self, target: Any) -> Any:
        """The pose (4, 4)."""
        return self._goal.pose(target)

    def solve(self, target: Any, q0: Array) -> Answer:
        """Solve with ``ik_LM``."""
        start = self._goal.clamped(q0)
        found = self._ets.ik_LM(target, q0=start[self._numbers], **self._options)
        q = start.copy()
        q[self._numbers] = found.q
        status = "REACHED" if found.success else "ITERATION_LIMIT"
        return Answer(q, status, bool(found.success), int(found.iterations))


def _chain(library: Any, goal: Goal) -> Any:
    """The ETS of the chain, with one constant transform between joints."""
    lower, upper = goal.bounds()
    parts, constant = [], np.eye(4)
    for joint in goal.robot.path(goal.frame):
        constant = constant @ joint.origin
        if not joint.is_moving:
            continue
        number = goal.robot.q_slice(joint.name).start
        to_axis = _axis_to_z(joint.axis)
        moving = library.ET.Rz if joint.type is JointType.REVOLUTE else library.ET.tz
        parts += [library.ET.SE3(constant @ to_axis), moving(qlim=[lower[number], upper[number]])]
        constant = to_axis.T
    return library.ETS([*parts, library.ET.SE3(constant)])


def _axis_to_z(axis: Array) -> Array:
    """A rotation (4, 4) whose third column is the axis."""
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(axis)))], axis)
    x /= np.linalg.norm(x)
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([x, np.cross(axis, x), axis])
    return pose

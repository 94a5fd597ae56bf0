"""The Robotics Toolbox for Python: Levenberg-Marquardt in C++ on a sequence of elementary transforms."""

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
    """``ETS.ik_LM``. Its restarts are drawn by itself, others at every call.

    Its defaults were found over seven arms: Chan with k from 1 to 0.01, Sugihara from 0.1 to 0.0001, Wampler from 0.01
    to 0.0001, 12 to 30 iterations an attempt, the rotation weighted 1 to 0.1. It turns hinges and slides alike into
    (-pi, pi) before it looks at limits.

    Attributes:
        method: how the damping follows the error.
        k: its gain.
        orientation_weight: weight of a squared radian where a squared metre has 1.
        restarted: iterations of an attempt where restarts are allowed.
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
        """No slide may be longer than what it would turn into (-pi, pi)."""
        super().check(goal)
        for joint in goal.robot.path(goal.frame):
            if joint.type is JointType.PRISMATIC and max(abs(joint.lower), abs(joint.upper)) > math.pi:
                given = f"slide {joint.name!r}, from {joint.lower:g} to {joint.upper:g} m"
                raise ArgumentError("robot", given, f"for {self.label}: slides within pi m, it wraps them as if angles")

    def build(self, library: Any, goal: Goal) -> PreparedContender:
        """On the chain from the base to the frame."""
        return _ToolboxReady(library, goal, self)


class _ToolboxReady(PreparedContender):
    """The toolbox at work."""

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
        most = setting.max_iterations
        self._options = {
            "ilimit": min(most, options.restarted) if setting.restarts else most,
            "slimit": setting.restarts + 1,
            "tol": 0.5 * min(squares),  # its error is half the weighted square of all rows together
            "mask": np.array(mask, dtype=float),
            "k": options.k,
            "method": options.method,
        }

    def convert(self, target: Any) -> Any:
        """A pose (4, 4)."""
        return self._goal.pose(target)

    def solve(self, target: Any, q0: Array) -> Answer:
        """By ``ik_LM``."""
        start = self._goal.clamped(q0)
        found = self._ets.ik_LM(target, q0=start[self._numbers], **self._options)
        q = start.copy()
        q[self._numbers] = found.q
        status = "REACHED" if found.success else "ITERATION_LIMIT"
        return Answer(q, status, bool(found.success), int(found.iterations))


def _chain(library: Any, goal: Goal) -> Any:
    """The ETS of the chain, with constants only between the joints."""
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

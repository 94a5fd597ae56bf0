"""Where each joint's numbers sit in q and in v, and the vectors of limits that follow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jtik.errors import ArgumentError
from jtik.robot.joints import JointType
from jtik.robot.tree import Joint, frozen
from jtik.types import Array


@dataclass(frozen=True, eq=False)
class Layout:
    """The index arithmetic of a robot, worked out once.

    Attributes:
        nq: length of q.
        nv: length of v.
        independent: the joints with a position of their own, in the order of q.
        q_slices: joint name to its place in q; a mimic joint has its leader's.
        v_slices: joint name to its place in v; a mimic joint has its leader's.
        lower: lower limits (nq,) [rad] or [m].
        upper: upper limits (nq,) [rad] or [m].
        velocity_limit: greatest speeds (nv,) [rad/s] or [m/s].
        neutral: zero led into the limits, identity quaternions, (nq,).
        rotational: which velocity entries are rotations, (nv,).
        scalar_q: places in q of the hinges and slides.
        scalar_v: their places in v, in the same order.
    """

    nq: int
    nv: int
    independent: tuple[Joint, ...]
    q_slices: dict[str, slice]
    v_slices: dict[str, slice]
    lower: Array
    upper: Array
    velocity_limit: Array
    neutral: Array
    rotational: NDArray[np.bool_]
    scalar_q: NDArray[np.intp]
    scalar_v: NDArray[np.intp]

    @classmethod
    def of(cls, joints: Sequence[Joint]) -> Layout:
        """The layout of ``joints``; q follows their order.

        Raises:
            ArgumentError: when a mimic joint's limits leave its leader no room.
        """
        independent = tuple(joint for joint in joints if joint.is_independent)
        q_slices, v_slices = {}, {}
        nq = nv = 0
        for joint in independent:
            q_slices[joint.name] = slice(nq, nq + joint.type.nq)
            v_slices[joint.name] = slice(nv, nv + joint.type.nv)
            nq, nv = nq + joint.type.nq, nv + joint.type.nv
        lower, upper, speed = np.full(nq, -math.inf), np.full(nq, math.inf), np.full(nv, math.inf)
        for joint in independent:
            if joint.type.is_scalar:
                lower[q_slices[joint.name]] = joint.lower
                upper[q_slices[joint.name]] = joint.upper
            speed[v_slices[joint.name]] = joint.velocity_limit
        for joint in joints:
            if joint.mimic is None:
                continue
            leader = joint.mimic.joint
            q_slices[joint.name], v_slices[joint.name] = q_slices[leader], v_slices[leader]
            _tighten(joint, q_slices[leader].start, v_slices[leader].start, lower, upper, speed)
        neutral = np.concatenate([np.zeros(0), *(joint.type.neutral for joint in independent)])
        scalar = [joint for joint in independent if joint.type.is_scalar]
        rotational = np.array([turns for joint in independent for turns in joint.type.rotational], dtype=bool)
        indices = [
            np.array([slices[joint.name].start for joint in scalar], dtype=np.intp) for slices in (q_slices, v_slices)
        ]
        for index in (rotational, *indices):
            index.flags.writeable = False
        return cls(
            nq,
            nv,
            independent,
            q_slices,
            v_slices,
            frozen(lower),
            frozen(upper),
            frozen(speed),
            frozen(np.clip(neutral, lower, upper)),
            rotational,
            *indices,
        )

    def random(self, generator: np.random.Generator) -> Array:
        """A configuration drawn uniformly, shape (nq,).

        Within the limits; without any, a hinge within a turn around zero and a length within 1 m of zero;
        with one, within a turn, or 2 m, of it. Quaternions are uniform on the sphere.
        """
        width = np.ones(self.nq)
        for joint in self.independent:
            if joint.type is JointType.REVOLUTE:
                width[self.q_slices[joint.name]] = math.pi
        low = np.where(np.isfinite(self.lower), self.lower, -width)
        high = np.where(np.isfinite(self.upper), self.upper, low + 2 * width)
        low = np.where(np.isfinite(self.lower) | np.isinf(self.upper), low, high - 2 * width)
        q = generator.uniform(low, high)
        for joint in self.independent:
            if joint.type.quaternion_start is not None:
                start = self.q_slices[joint.name].start + joint.type.quaternion_start
                direction = generator.standard_normal(4)
                q[start : start + 4] = direction / np.linalg.norm(direction)
        return q


def _tighten(joint: Joint, q: int, v: int, lower: Array, upper: Array, speed: Array) -> None:
    """Narrow the leader's limits so that its mimic ``joint`` keeps its own, too."""
    assert joint.mimic is not None
    ratio, offset = joint.mimic.multiplier, joint.mimic.offset
    ends = sorted(((joint.lower - offset) / ratio, (joint.upper - offset) / ratio))
    low, high = max(lower[q], ends[0]), min(upper[q], ends[1])
    if low > high:
        raise ArgumentError(
            f"joint {joint.name!r} limits",
            f"lower {joint.lower:g}, upper {joint.upper:g}, which {joint.mimic.joint!r} cannot meet",
            f"limits that overlap those of {joint.mimic.joint!r}, {lower[q]:g} to {upper[q]:g}",
        )
    lower[q], upper[q] = low, high
    speed[v] = min(speed[v], joint.velocity_limit / abs(ratio))

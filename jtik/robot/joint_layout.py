"""The indices of each joint in q and in v, and the vectors of limits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from jtik.errors import ArgumentError
from jtik.robot.joint_type import JointType
from jtik.robot.tree import Joint, frozen
from jtik.types import Array


@dataclass(frozen=True, eq=False)
class JointLayout:
    """The indices and limits of a robot's joints, computed once.

    Attributes:
        nq: length of q.
        nv: length of v.
        independent: the joints with a position of their own, in the order of q.
        q_slices: joint name to its indices in q; a mimic joint has those of its leader.
        v_slices: joint name to its indices in v; a mimic joint has those of its leader.
        lower: lower limits (nq,) [rad] or [m].
        upper: upper limits (nq,) [rad] or [m].
        velocity_limit: maximum speeds (nv,) [rad/s] or [m/s].
        effort_limit: maximum torques [N m] and forces [N] (nv,); of a leader its own, without those of its followers.
        neutral: zero clamped to the limits, and identity quaternions, or what `with_neutral` put in their place, (nq,).
        rotational: True for velocity entries that are rotations, (nv,).
        scalar_q: indices in q of the revolute and prismatic joints.
        scalar_v: their indices in v, in the same order.
        quaternions: name of each ball or free joint to the indices of its quaternion in q.
    """

    nq: int
    nv: int
    independent: tuple[Joint, ...]
    q_slices: dict[str, slice]
    v_slices: dict[str, slice]
    lower: Array
    upper: Array
    velocity_limit: Array
    effort_limit: Array
    neutral: Array
    rotational: NDArray[np.bool_]
    scalar_q: NDArray[np.intp]
    scalar_v: NDArray[np.intp]
    quaternions: dict[str, slice]

    @classmethod
    def of(cls, joints: Sequence[Joint]) -> JointLayout:
        """The layout of ``joints``; q follows their order.

        Raises:
            ArgumentError: when the limits of a mimic joint and of its leader exclude each other.
        """
        independent = tuple(joint for joint in joints if joint.is_independent)
        q_slices, v_slices = {}, {}
        nq = nv = 0
        for joint in independent:
            q_slices[joint.name] = slice(nq, nq + joint.type.nq)
            v_slices[joint.name] = slice(nv, nv + joint.type.nv)
            nq, nv = nq + joint.type.nq, nv + joint.type.nv
        lower, upper, speed = np.full(nq, -math.inf), np.full(nq, math.inf), np.full(nv, math.inf)
        effort = np.full(nv, math.inf)
        for joint in independent:
            if joint.type.is_scalar:
                lower[q_slices[joint.name]] = joint.lower
                upper[q_slices[joint.name]] = joint.upper
            speed[v_slices[joint.name]] = joint.velocity_limit
            effort[v_slices[joint.name]] = joint.effort_limit
        for joint in joints:
            if joint.mimic is None:
                continue
            leader = joint.mimic.joint
            q_slices[joint.name], v_slices[joint.name] = q_slices[leader], v_slices[leader]
            _tighten(joint, q_slices[leader].start, v_slices[leader].start, lower, upper, speed)
        neutral = np.concatenate([np.zeros(0), *(joint.type.neutral for joint in independent)])
        scalar = [joint for joint in independent if joint.type.is_scalar]
        rotational = np.array([entry for joint in independent for entry in joint.type.rotational], dtype=bool)
        quaternions = {
            joint.name: slice(q_slices[joint.name].start + start, q_slices[joint.name].stop)
            for joint in independent
            if (start := joint.type.quaternion_start) is not None
        }
        scalar_q, scalar_v = (
            np.array([slices[joint.name].start for joint in scalar], dtype=np.intp) for slices in (q_slices, v_slices)
        )
        for index in (rotational, scalar_q, scalar_v):
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
            frozen(effort),
            frozen(np.clip(neutral, lower, upper)),
            rotational,
            scalar_q,
            scalar_v,
            quaternions,
        )

    def with_neutral(self, q: Array) -> JointLayout:
        """The same layout with the neutral configuration ``q`` (nq,), clamped to the limits."""
        return replace(self, neutral=frozen(np.clip(q, self.lower, self.upper)))

    def random(self, generator: np.random.Generator) -> Array:
        """A configuration drawn uniformly within the limits, shape (nq,).

        A revolute joint without limits is drawn from (-pi, pi), a prismatic joint from (-1, 1) [m]. A joint with one
        limit is drawn from an interval of that length, 2 pi or 2 m, which starts at the limit. Quaternions are uniform
        on the sphere.
        """
        low, width = self._drawn_from
        q: Array = low + width * generator.random(self.nq)
        for indices in self.quaternions.values():
            direction = generator.standard_normal(4)
            q[indices] = direction / np.linalg.norm(direction)
        return q

    @cached_property
    def _drawn_from(self) -> tuple[Array, Array]:
        """The smallest entries of a random configuration and the widths of their intervals, (nq,) each."""
        width = np.ones(self.nq)
        for joint in self.independent:
            if joint.type is JointType.REVOLUTE:
                width[self.q_slices[joint.name]] = math.pi
        low = np.where(np.isfinite(self.lower), self.lower, -width)
        high = np.where(np.isfinite(self.upper), self.upper, low + 2 * width)
        low = np.where(np.isfinite(self.lower) | np.isinf(self.upper), low, high - 2 * width)
        return low, high - low


def _tighten(joint: Joint, q: int, v: int, lower: Array, upper: Array, speed: Array) -> None:
    """Reduce the limits of the leader to those that keep its mimic ``joint`` within its own limits, too."""
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

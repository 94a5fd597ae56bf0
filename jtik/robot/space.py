"""The configuration space of a robot: sizes, limits, and where each joint's numbers are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jtik.errors import UnknownNameError
from jtik.robot.layout import Layout
from jtik.robot.tree import Joint
from jtik.types import Array


class ConfigurationSpace:
    """What a robot says about its q (nq,) and v (n,), without its geometry. `Robot` is one."""

    _layout: Layout

    @property
    def n(self) -> int:
        """Length of a velocity, nv."""
        return self._layout.nv

    @property
    def nq(self) -> int:
        """Length of a configuration."""
        return self._layout.nq

    @property
    def independent_joints(self) -> tuple[Joint, ...]:
        """The joints with a position of their own, in the order of q."""
        return self._layout.independent

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints with a position of their own, in the order of q."""
        return tuple(joint.name for joint in self._layout.independent)

    @property
    def lower(self) -> Array:
        """Lower limits (nq,) [rad] or [m]; -inf where there is none and for quaternions. Read-only."""
        return self._layout.lower

    @property
    def upper(self) -> Array:
        """Upper limits (nq,) [rad] or [m]; inf where there is none and for quaternions. Read-only."""
        return self._layout.upper

    @property
    def velocity_limit(self) -> Array:
        """Greatest speeds (n,) [rad/s] or [m/s]; inf where there is none. Read-only."""
        return self._layout.velocity_limit

    @property
    def neutral(self) -> Array:
        """Zero, led into the limits, and identity quaternions, (nq,). Read-only."""
        return self._layout.neutral

    @property
    def rotational(self) -> NDArray[np.bool_]:
        """Which velocity entries are rotations [rad/s]; the others are lengths [m/s]; (n,). Read-only."""
        return self._layout.rotational

    @property
    def scalar_q(self) -> NDArray[np.intp]:
        """Places in q of the hinges and slides, which are the entries that can have limits. Read-only."""
        return self._layout.scalar_q

    @property
    def scalar_v(self) -> NDArray[np.intp]:
        """Places in v of the same joints, in the order of `scalar_q`. Read-only."""
        return self._layout.scalar_v

    def q_slice(self, joint: str) -> slice:
        """The place of a joint in q; of a mimic joint, its leader's.

        Raises:
            UnknownNameError: when no moving joint has that name.
        """
        return _found(joint, self._layout.q_slices)

    def v_slice(self, joint: str) -> slice:
        """The place of a joint in v; of a mimic joint, its leader's.

        Raises:
            UnknownNameError: when no moving joint has that name.
        """
        return _found(joint, self._layout.v_slices)

    def random_configuration(self, rng: np.random.Generator | int) -> Array:
        """A configuration drawn uniformly from the limits, shape (nq,).

        Without limits a hinge lies within (-pi, pi) and a length within (-1, 1); quaternions are uniform.
        """
        return self._layout.random(np.random.default_rng(rng))


def _found(joint: str, slices: dict[str, slice]) -> slice:
    if joint not in slices:
        raise UnknownNameError("moving joint", joint, slices)
    return slices[joint]

"""The configuration space of a robot: sizes, limits, the indices of each joint, and configurations as input."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jtik.arguments import random_generator, text
from jtik.errors import UnknownNameError
from jtik.robot.configuration_input import read_configuration, read_joint_values, read_velocity_values
from jtik.robot.joint_layout import JointLayout
from jtik.robot.subset import Reduction
from jtik.robot.tree import Joint
from jtik.types import Array


class ConfigurationSpace:
    """The configurations q (nq,) and velocities v (n,) of a robot, without its geometry; the base of `Robot`."""

    _layout: JointLayout
    _reduction: Reduction | None = None

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
        """Maximum speeds (n,) [rad/s] or [m/s]; inf where there is none. Read-only."""
        return self._layout.velocity_limit

    @property
    def effort_limit(self) -> Array:
        """Maximum torques [N m] and forces [N] of the joints (n,); inf where they are not known. Read-only."""
        return self._layout.effort_limit

    @property
    def neutral(self) -> Array:
        """Where joints are that nothing else is said of, such as locked ones, (nq,). Read-only.

        Zero and identity quaternions; of a MuJoCo model its ``qpos0``. It is clamped to the limits.
        """
        return self._layout.neutral

    @property
    def rotational(self) -> NDArray[np.bool_]:
        """True for velocity entries that are rotations [rad/s], False for translations [m/s], (n,). Read-only."""
        return self._layout.rotational

    @property
    def scalar_q(self) -> NDArray[np.intp]:
        """Indices in q of the revolute and prismatic joints: the entries that can have limits. Read-only."""
        return self._layout.scalar_q

    @property
    def scalar_v(self) -> NDArray[np.intp]:
        """Indices in v of the same joints, in the order of `scalar_q`. Read-only."""
        return self._layout.scalar_v

    @property
    def quaternions(self) -> Mapping[str, slice]:
        """The indices in q of each quaternion (w, x, y, z), by the name of its ball or free joint."""
        return MappingProxyType(self._layout.quaternions)

    def q_slice(self, joint: str) -> slice:
        """The indices of a joint in q; those of its leader for a mimic joint.

        Args:
            joint: name of the joint.

        Raises:
            UnknownNameError: when no moving joint has that name.
        """
        return _found(joint, self._layout.q_slices)

    def v_slice(self, joint: str) -> slice:
        """The indices of a joint in v; those of its leader for a mimic joint.

        Args:
            joint: name of the joint.

        Raises:
            UnknownNameError: when no moving joint has that name.
        """
        return _found(joint, self._layout.v_slices)

    def random_configuration(self, rng: np.random.Generator | int) -> Array:
        """A configuration drawn uniformly within the limits, shape (nq,).

        Without limits a revolute joint is drawn from (-pi, pi) [rad] and a prismatic one from (-1, 1) [m]. Quaternions
        are uniform over all rotations.

        Args:
            rng: a random generator, or a seed.

        Raises:
            ArgumentError: when ``rng`` is neither a generator nor a seed.
        """
        return self._layout.random(random_generator("rng", rng))

    def configuration(self, q: Any, *, argument: str = "q") -> Array:
        """A checked copy of a configuration, (nq,). Every method with a numeric argument q accepts the same forms.

        Args:
            q: one of three forms. Numbers (nq,). On a robot made by `Robot.subset` also numbers (full.nq,) of the robot
                it was made from; the values of the locked joints are ignored. A dict from joint name to position: a
                number for a revolute or prismatic joint, 4 numbers for a ball joint, 7 for a free joint; joints that
                are not named are at `neutral`, and locked joints of `full` are accepted and ignored. Quaternions of
                any norm but zero are normalised.
            argument: name of the argument in error messages.

        Raises:
            ArgumentError: when ``q`` has another shape, is not finite, or has a zero quaternion.
            UnknownNameError: when a dict names a joint that does not exist or has no position of its own.
        """
        return read_configuration(self, q, argument)

    def joint_values(self, values: Any, *, default: ArrayLike, argument: str = "values") -> Array:
        """One number for each entry of q, (nq,), such as stiffnesses or the limits of a criterion.

        Args:
            values: one of four forms. A number for all entries. Numbers (nq,). On a robot made by `Robot.subset` also
                numbers (full.nq,); those of the locked joints are ignored. A dict from joint name to a number, or to 4
                and 7 numbers for a ball and a free joint; locked joints of `full` are accepted and ignored.
            default: the values of the joints that a dict does not name: a number, or numbers (nq,).
            argument: name of the argument in error messages.

        Raises:
            ArgumentError: when ``values`` has another shape or is not finite.
            UnknownNameError: when a dict names a joint that does not exist or has no position of its own.
        """
        return read_joint_values(self, values, argument, default)

    def velocity_values(self, values: Any, *, default: ArrayLike, argument: str = "values") -> Array:
        """One number for each velocity entry, (n,), such as the weights of the joints.

        Args:
            values: one of three forms. Numbers (n,). On a robot made by `Robot.subset` also numbers (full.n,); those of
                the locked joints are ignored. A dict from joint name to a number, for all entries of the joint, or to 3
                and 6 numbers for a ball and a free joint; locked joints of `full` are accepted and ignored.
            default: the values of the joints that a dict does not name: a number, or numbers (n,).
            argument: name of the argument in error messages.

        Raises:
            ArgumentError: when ``values`` has another shape or is not finite.
            UnknownNameError: when a dict names a joint that does not exist or has no position of its own.
        """
        return read_velocity_values(self, values, argument, default)

    @property
    def kept_indices(self) -> NDArray[np.intp]:
        """The indices in q of `full` of the entries of this robot's q, (nq,)."""
        return np.arange(self.nq) if self._reduction is None else np.asarray(self._reduction.indices)

    @property
    def full(self) -> Self:
        """The robot from which `Robot.subset` made this one; the robot itself when it was not made so."""
        return self if self._reduction is None else self._reduction.full

    def full_configuration(self, q: Any) -> Array:
        """The configuration of `full`, (full.nq,): these positions, and the locked joints where they are locked.

        Args:
            q: a configuration, in any form that `configuration` accepts.

        Raises:
            ArgumentError: when ``q`` has another shape, is not finite, or has a zero quaternion.
            UnknownNameError: when a dict names a joint that does not exist.
        """
        own = self.configuration(q)
        return own if self._reduction is None else self._reduction.expanded(own)

    def reduced(self, q: Any) -> Array:
        """The part (nq,) of a configuration of `full`; the inverse of `full_configuration` for the joints kept.

        Args:
            q: a configuration of `full`, in any form that its `configuration` accepts.

        Raises:
            ArgumentError: when ``q`` has another shape than (full.nq,), is not finite, or has a zero quaternion.
            UnknownNameError: when a dict names a joint that does not exist.
        """
        given = self.full.configuration(q)
        return given if self._reduction is None else given[self._reduction.indices]


def _found(joint: str, slices: dict[str, slice]) -> slice:
    if text("joint", joint, "the name of a joint") not in slices:
        raise UnknownNameError("moving joint", joint, slices)
    return slices[joint]

"""Joint weights: the coordinates of a displacement in which all joints weigh the same (formulations/weights.md)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import mul
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError
from jtik.symbolic import Expression, diag, vertcat
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.robot.configuration_space import ConfigurationSpace

Weights: TypeAlias = Mapping[str, ArrayLike] | ArrayLike | None
"""A dict from joint name to weight, one weight for each velocity entry, or None for none."""

LARGEST_RATIO = 1e8
"""Largest ratio of two weights: its root, 1e4, stays well above the threshold of rank decisions, 1e-8."""

ACCEPTED = f"positive numbers, the largest at most {LARGEST_RATIO:g} times the smallest"


@dataclass(frozen=True, eq=False)
class WeightedCoordinates:
    """Coordinates z = W^(1/2) dq of a displacement, W diagonal: |z|^2 = dq' W dq.

    Attributes:
        scale: dq_i / z_i, (n,), numbers in (0, 1] or expressions; None without weights, where z = dq.
        bounds_steps: whether a trust radius bounds |z| rather than the rotational part of dq.
    """

    scale: Sequence[Expression] | Array | None = None
    bounds_steps: bool = False

    @classmethod
    def of(cls, weights: Array | None) -> WeightedCoordinates:
        """The coordinates for the weights (n,), relative to the smallest; those without weights where all are equal.

        Args:
            weights: a positive number for each velocity entry (n,); None for equal ones.
        """
        if weights is None or (weights == weights[0]).all():
            return cls()
        return cls(np.sqrt(weights.min() / weights))

    @property
    def weights(self) -> Array | None:
        """The diagonal of W, the smallest 1, (n,); None without weights."""
        return None if self.scale is None else 1 / np.asarray(self.scale) ** 2

    def to_joints(self, z: Expression) -> Expression:
        """The displacement dq [rad] or [m] with the coordinates z, (n, 1) each.

        Args:
            z: the coordinates.
        """
        return z if self.scale is None else self._column() * z

    def from_joints(self, dq: Expression) -> Expression:
        """The coordinates z of a displacement dq [rad] or [m], (n, 1) each.

        Args:
            dq: the displacement.
        """
        return dq if self.scale is None else dq / self._column()

    def jacobian(self, J: Expression) -> Expression:
        """The derivative by z of what has the derivative J by dq, (m, n) each.

        Args:
            J: the derivative by dq.
        """
        return J if self.scale is None else J @ diag(self._column())

    def jacobian_by_joints(self, J: Expression) -> Expression:
        """The derivative by dq of what has the derivative J by z, (m, n) each.

        Args:
            J: the derivative by z.
        """
        return J if self.scale is None else J @ diag(1 / self._column())

    def gradient(self, gradient: Expression) -> Expression:
        """The derivative by z (n, 1) of a scalar with this derivative by dq.

        Args:
            gradient: the derivative by dq (n, 1).
        """
        return self.to_joints(gradient)

    def gradient_by_joints(self, gradient: Expression) -> Expression:
        """The derivative by dq (n, 1) of a scalar with this derivative by z.

        Args:
            gradient: the derivative by z (n, 1).
        """
        return self.from_joints(gradient)

    def hessian(self, hessian: Expression) -> Expression:
        """The second derivative by z (n, n) of a scalar with this one by dq.

        Args:
            hessian: the second derivative by dq (n, n).
        """
        return hessian if self.scale is None else diag(self._column()) @ hessian @ diag(self._column())

    def entry(self, j: int, displacement: Expression) -> Expression:
        """The coordinate z_j of a displacement [rad] or [m] of velocity entry j.

        Args:
            j: index of the velocity entry.
            displacement: its displacement [rad] or [m].
        """
        return displacement if self.scale is None else displacement / self._entries[j]

    def scaled(self, scale: Sequence[Expression]) -> WeightedCoordinates:
        """Coordinates z' of z with z_i / z'_i = scale_i, (n,).

        Args:
            scale: z_i / z'_i of each coordinate.
        """
        if self.scale is None:
            return WeightedCoordinates(scale, bounds_steps=True)
        return WeightedCoordinates([*map(mul, self._entries, scale)])

    @property
    def _entries(self) -> list[Expression]:
        assert self.scale is not None
        return self.scale.tolist() if isinstance(self.scale, np.ndarray) else list(self.scale)

    def _column(self) -> Expression:
        return vertcat(*self._entries)


UNWEIGHTED = WeightedCoordinates()
"""The coordinates without weights."""


def read_weights(space: ConfigurationSpace, weights: Any) -> Array | None:
    """The weights of the velocity entries (n,), from the argument ``weights`` of a solver; None for none.

    Args:
        space: the robot with only the joints that move.
        weights: in a form that `Robot.velocity_values` accepts; joints that a dict does not name have the weight 1.

    Raises:
        ArgumentError: for another shape, weights that are not positive, or weights too far apart.
        UnknownNameError: when a dict names a joint that does not exist or has no position of its own.
    """
    if weights is None:
        return None
    found = space.velocity_values(weights, default=1.0, argument="weights")
    if not ((found > 0).all() and found.max() <= LARGEST_RATIO * found.min()):
        raise ArgumentError("weights", weights, f"{ACCEPTED}; joints= leaves out a joint that is not to move")
    return found

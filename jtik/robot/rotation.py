"""Rotations of a chain of joints as expressions with few operations.

Each revolute joint of a chain multiplies the rotation by one more. Products of full 3 x 3 matrices need 45 operations
per joint; this form avoids most of them. A rotation is kept as

    R = base . Rot(axis, angle) . constant

with ``axis`` and ``constant`` numeric. A further revolute joint whose axis is parallel to ``axis`` only adds its angle,
so a planar chain of n links needs n sines, n cosines and no product of rotations. Entries that are 0 or 1 by
construction are numbers, which CasADi drops.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from jtik.symbolic import SX, Expression, cos, horzcat, sin
from jtik.types import Array

ROUNDING = 4 * float(np.finfo(np.float64).eps)
"""Entries of unit vectors this close to -1, 0 or 1 count as these numbers with a rounding error."""

_IDENTITY = np.eye(3)


def snapped(unit: Array) -> Array:
    """``unit`` (a rotation or a unit vector) with entries that are 0 or +-1 up to rounding made exact."""
    nearest = np.round(unit)
    return np.where(np.abs(unit - nearest) <= ROUNDING, nearest, unit)


@dataclass(frozen=True)
class AxisRotation:
    """A rotation about a numeric axis.

    Attributes:
        axis: numeric unit vector (3,).
        angle: angle [rad].
        cosine: cosine of the angle.
        sine: sine of the angle.
    """

    axis: Array
    angle: Expression
    cosine: Expression
    sine: Expression

    @classmethod
    def about(cls, axis: Array, angle: Expression) -> AxisRotation:
        """The rotation by ``angle`` [rad] about ``axis`` (3,)."""
        return cls(axis, angle, cos(angle), sin(angle))

    def apply(self, vector: Array) -> Expression:
        """The numeric ``vector`` (3,), rotated (Rodrigues), shape (3, 1)."""
        scale = float(np.linalg.norm(vector))
        along = _clean(self.axis * float(self.axis @ vector), scale)
        across = _clean(vector - along, scale)
        normal = _clean(np.cross(self.axis, vector), scale)
        return SX(along) + self.cosine * SX(across) + self.sine * SX(normal)


def _clean(vector: Array, scale: float) -> Array:
    return np.where(np.abs(vector) <= ROUNDING * scale, 0.0, vector)


@dataclass(frozen=True)
class Rotation:
    """The rotation base . about . constant; None stands for the identity.

    Attributes:
        base: symbolic rotation (3, 3).
        about: rotation about a numeric axis.
        constant: numeric rotation (3, 3).
    """

    base: Expression | None = None
    about: AxisRotation | None = None
    constant: Array | None = None

    def then_constant(self, matrix: Array) -> Rotation:
        """This rotation followed by the numeric ``matrix`` (3, 3)."""
        total = snapped(matrix if self.constant is None else self.constant @ matrix)
        return replace(self, constant=None if np.array_equal(total, _IDENTITY) else total)

    def then_rotation(self, axis: Array, angle: Expression) -> Rotation:
        """This rotation followed by ``angle`` [rad] about the numeric unit vector ``axis`` (3,)."""
        own = snapped(axis if self.constant is None else self.constant @ axis)
        if self.about is not None:
            side = float(self.about.axis @ own)
            if float(np.linalg.norm(np.cross(self.about.axis, own))) <= ROUNDING:
                total = self.about.angle + angle if side > 0 else self.about.angle - angle
                return replace(self, about=AxisRotation.about(self.about.axis, total))
        if np.count_nonzero(own) == 1:
            ahead = replace(self, constant=None)
            return Rotation(ahead._matrix_or_none(), AxisRotation.about(own, angle), self.constant)
        return Rotation(self._matrix_or_none(), AxisRotation.about(snapped(axis), angle))

    def then_matrix(self, matrix: Expression) -> Rotation:
        """This rotation followed by the symbolic ``matrix`` (3, 3)."""
        ahead = self._matrix_or_none()
        return Rotation(matrix if ahead is None else ahead @ matrix)

    def apply(self, vector: Array) -> Expression:
        """The numeric ``vector`` (3,), rotated, shape (3, 1)."""
        inner = vector if self.constant is None else self.constant @ vector
        rotated = SX(inner) if self.about is None else self.about.apply(inner)
        return rotated if self.base is None else self.base @ rotated

    def matrix(self) -> Expression:
        """The rotation written out, shape (3, 3)."""
        return horzcat(*[self.apply(column) for column in _IDENTITY])

    def _matrix_or_none(self) -> Expression | None:
        if self.about is None and self.constant is None:
            return self.base
        return self.matrix()

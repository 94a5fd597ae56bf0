"""Rotations of a chain as cheap expressions.

Every hinge of a chain multiplies one more rotation on. Written as plain 3 x 3 products that is 45 operations
a joint; here most of them never arise. A rotation is kept in the form

    R = base . Rot(axis, angle) . constant

with ``axis`` and ``constant`` numeric. A further hinge whose axis is parallel to ``axis`` only adds its
angle, so a planar chain of n links needs n sines, n cosines and no products of rotations at all; entries that
are 0 or 1 by construction are numbers, and CasADi drops them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from jtik.symbolic import SX, Expression, cos, horzcat, sin
from jtik.types import Array

ROUNDING = 4 * float(np.finfo(np.float64).eps)
"""Entries of unit vectors this close to -1, 0 or 1 are those numbers, blurred by rounding."""

_IDENTITY = np.eye(3)


def snapped(unit: Array) -> Array:
    """``unit`` (a rotation or a unit vector) with entries that are 0 or +-1 up to rounding made exact."""
    nearest = np.round(unit)
    return np.where(np.abs(unit - nearest) <= ROUNDING, nearest, unit)


@dataclass(frozen=True)
class Turn:
    """A rotation by ``angle`` [rad] about the numeric unit vector ``axis`` (3,), with its sine and cosine."""

    axis: Array
    angle: Expression
    cosine: Expression
    sine: Expression

    @classmethod
    def about(cls, axis: Array, angle: Expression) -> Turn:
        """The turn by ``angle`` [rad] about ``axis`` (3,)."""
        return cls(axis, angle, cos(angle), sin(angle))

    def apply(self, vector: Array) -> Expression:
        """The numeric ``vector`` (3,) after the turn (Rodrigues), shape (3, 1)."""
        scale = float(np.linalg.norm(vector))
        along = _clean(self.axis * float(self.axis @ vector), scale)
        across = _clean(vector - along, scale)
        normal = _clean(np.cross(self.axis, vector), scale)
        return SX(along) + self.cosine * SX(across) + self.sine * SX(normal)


def _clean(vector: Array, scale: float) -> Array:
    return np.where(np.abs(vector) <= ROUNDING * scale, 0.0, vector)


@dataclass(frozen=True)
class Rotation:
    """The rotation base . turn . constant; None stands for the identity."""

    base: Expression | None = None
    turn: Turn | None = None
    constant: Array | None = None

    def then_constant(self, matrix: Array) -> Rotation:
        """This rotation followed by the numeric ``matrix`` (3, 3)."""
        total = snapped(matrix if self.constant is None else self.constant @ matrix)
        return replace(self, constant=None if np.array_equal(total, _IDENTITY) else total)

    def then_turn(self, axis: Array, angle: Expression) -> Rotation:
        """This rotation followed by ``angle`` [rad] about the numeric unit vector ``axis`` (3,)."""
        seen = snapped(axis if self.constant is None else self.constant @ axis)
        if self.turn is not None:
            side = float(self.turn.axis @ seen)
            if float(np.linalg.norm(np.cross(self.turn.axis, seen))) <= ROUNDING:
                total = self.turn.angle + angle if side > 0 else self.turn.angle - angle
                return replace(self, turn=Turn.about(self.turn.axis, total))
        if np.count_nonzero(seen) == 1:
            ahead = replace(self, constant=None)
            return Rotation(ahead._matrix_or_none(), Turn.about(seen, angle), self.constant)
        return Rotation(self._matrix_or_none(), Turn.about(snapped(axis), angle))

    def then_matrix(self, matrix: Expression) -> Rotation:
        """This rotation followed by the symbolic ``matrix`` (3, 3)."""
        ahead = self._matrix_or_none()
        return Rotation(matrix if ahead is None else ahead @ matrix)

    def apply(self, vector: Array) -> Expression:
        """The numeric ``vector`` (3,) after the rotation, shape (3, 1)."""
        inner = vector if self.constant is None else self.constant @ vector
        turned = SX(inner) if self.turn is None else self.turn.apply(inner)
        return turned if self.base is None else self.base @ turned

    def matrix(self) -> Expression:
        """The rotation written out, shape (3, 3)."""
        return horzcat(*[self.apply(column) for column in _IDENTITY])

    def _matrix_or_none(self) -> Expression | None:
        if self.turn is None and self.constant is None:
            return self.base
        return self.matrix()

"""Unit quaternions (w, x, y, z) as CasADi expressions.

Every formula is smooth at the identity, to any order of derivative. Near zero it is a power series in the squared
angle: the functions involved are even in the angle.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import factorial

from jtik.symbolic import Expression, atan2, cos, if_else, sin, sqrt, stack, sumsqr, vertcat

_COSINE = [(-1.0) ** k / factorial(2 * k) for k in range(8)]
_SINC = [(-1.0) ** k / factorial(2 * k + 1) for k in range(8)]
_ARCTAN = [(-1.0) ** k / (2 * k + 1) for k in range(9)]

SERIES_HALF_ANGLE_SQUARED = 1.0 / 16.0
"""Below it the exponential is its power series; the first omitted term is below 1e-23."""

SERIES_TANGENT_SQUARED = 0.01
"""Below it the logarithm is its power series; the first omitted term is below 1e-19."""


def _series(coefficients: Sequence[float], square: Expression) -> Expression:
    total: Expression = coefficients[-1]
    for coefficient in reversed(coefficients[:-1]):
        total = total * square + coefficient
    return total


def rotation_matrix(q: Expression) -> Expression:
    """The rotation of a quaternion, shape (3, 3); every non-zero multiple of it gives the same rotation."""
    w, x, y, z = (q[i] for i in range(4))
    s = 2 / sumsqr(q)
    return stack(
        [
            [1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
            [s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)],
            [s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)],
        ]
    )


def product(a: Expression, b: Expression) -> Expression:
    """The Hamilton product a b, shape (4, 1)."""
    aw, ax, ay, az = (a[i] for i in range(4))
    bw, bx, by, bz = (b[i] for i in range(4))
    return vertcat(
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def conjugate(q: Expression) -> Expression:
    """The conjugate, which is the inverse of a unit quaternion, shape (4, 1)."""
    return vertcat(q[0], -q[1], -q[2], -q[3])


def tangent(q: Expression) -> Expression:
    """The map from body angular velocity [rad/s] to dq/dt = 1/2 q (0, omega), shape (4, 3)."""
    w, x, y, z = (q[i] / 2 for i in range(4))
    return stack([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])


def exponential(omega: Expression) -> Expression:
    """The quaternion of a rotation vector ``omega`` [rad], shape (3, 1) -> (4, 1)."""
    square = sumsqr(omega) / 4
    small = square < SERIES_HALF_ANGLE_SQUARED
    bounded = if_else(small, square, 0)
    half = sqrt(if_else(small, 1, square))
    real = if_else(small, _series(_COSINE, bounded), cos(half))
    sinc = if_else(small, _series(_SINC, bounded), sin(half) / half)
    return vertcat(real, sinc / 2 * omega)


def logarithm(q: Expression) -> Expression:
    """The shortest rotation vector [rad] of a quaternion, shape (4, 1) -> (3, 1), norm at most pi."""
    side = if_else(q[0] < 0, -1, 1)
    w, v = side * q[0], side * q[1:4]
    square = sumsqr(v)
    small = square < SERIES_TANGENT_SQUARED * w * w
    real = if_else(small, w, 1)
    norm = sqrt(if_else(small, 1, square))
    series = _series(_ARCTAN, if_else(small, square, 0) / (real * real)) / real
    return 2 * if_else(small, series, atan2(norm, w) / norm) * v


def integrate(q: Expression, omega: Expression) -> Expression:
    """``q`` rotated by the rotation vector ``omega`` [rad] in the body frame, of unit norm, shape (4, 1)."""
    rotated = product(q, exponential(omega))
    return rotated / sqrt(sumsqr(rotated))


def difference(start: Expression, end: Expression) -> Expression:
    """The rotation vector [rad] in the body frame from ``start`` to ``end``, shape (3, 1)."""
    return logarithm(product(conjugate(start), end))

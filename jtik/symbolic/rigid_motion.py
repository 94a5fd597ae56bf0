"""The logarithm of a rigid motion (R, p) as CasADi expressions, in space and in the plane (formulations/tasks.md).

Its rotation part is the rotation vector of R, as in `rotation.log`. Its translation part is computed here.
"""

from __future__ import annotations

from jtik.symbolic.operations import (
    Expression,
    cos,
    cross,
    dot,
    identity,
    if_else,
    sin,
    skew,
    sqrt,
    sumsqr,
    vertcat,
)

_SMALL = 0.01
"""|phi|^2 below which series are used; the omitted terms are below 1e-14, and their effect on a result below 1e-16."""


def log_translation(phi: Expression, p: Expression) -> Expression:
    """G p (3, 1), with ``G = I - [phi] / 2 + c [phi]^2``, ``phi`` = log R and c of `rotation.log_rate`.

    Args:
        phi: rotation vector (3, 1) [rad].
        p: translation (3, 1) [m].
    """
    squared = sumsqr(phi)
    c, _ = _coefficients(squared)
    return p - cross(phi, p) / 2 + c * (dot(phi, p) * phi - squared * p)


def log_translation_rate(phi: Expression, p: Expression) -> Expression:
    """Derivative (3, 3) of `log_translation` with respect to ``phi``, for a constant p.

    Args:
        phi: rotation vector (3, 1) [rad].
        p: translation (3, 1) [m].
    """
    along, squared = dot(phi, p), sumsqr(phi)
    c, rate = _coefficients(squared)
    of_square = along * identity(3) + phi @ p.T - 2 * (p @ phi.T)
    return skew(p) / 2 + c * of_square + 2 * rate * ((along * phi - squared * p) @ phi.T)


def log_translation_in_the_plane(angle: Expression, p: Expression) -> Expression:
    """`log_translation` (2, 1) of a motion in the plane.

    Args:
        angle: rotation in (-pi, pi] [rad].
        p: translation (2, 1) [m].
    """
    c, _ = _coefficients(angle**2)
    diagonal = 1 - c * angle**2
    return vertcat(diagonal * p[0] + angle / 2 * p[1], diagonal * p[1] - angle / 2 * p[0])


def _coefficients(squared: Expression) -> tuple[Expression, Expression]:
    """c = (1 - h cot h) / (2 h)^2 with (2 h)^2 = ``squared``, and its derivative with respect to ``squared``."""
    small = squared < _SMALL
    safe = if_else(small, 1, squared)
    half = sqrt(safe) / 2
    cotangent = cos(half) / sin(half)
    c = (1 - half * cotangent) / safe
    rate = ((half / sin(half) ** 2 - cotangent) / (8 * half) - c) / safe
    near_c = 1 / 12 + squared * (1 / 720 + squared * (1 / 30240 + squared * (1 / 1209600 + squared / 47900160)))
    near_rate = 1 / 720 + squared * (1 / 15120 + squared * (1 / 403200 + squared / 11975040))
    return if_else(small, near_c, c), if_else(small, near_rate, rate)

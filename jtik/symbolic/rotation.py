"""The logarithm of SO(3) as a CasADi expression, the orientation error of every task.

Source: the quaternion of a rotation matrix taken from the largest diagonal entry of the 4x4 matrix ``4 q q'``
(Shepperd 1978), and ``log R = 2 atan2(|v|, w) v / |v|``. Exact and differentiable from angle zero to just below
pi. At pi both axes +u and -u are solutions; the one whose largest component is positive is returned.
"""

from __future__ import annotations

from jtik.symbolic.operations import Expression, atan2, cos, identity, if_else, sin, skew, sqrt, sumsqr, vertcat

_SMALL = 1e-12
"""|v|^2 below which 2 atan2(|v|, w) / |v| is 2 (1 + |v|^2 / 6), the series of 2 asin(|v|) / |v| of a unit quaternion.

Its next term is 3 / 20 |v|^4, below 1e-24. For `log_rate` it is the squared angle below which c is 1 / 12.
"""


def _largest_column(R: Expression) -> Expression:
    """The column of ``4 q q'`` with the largest diagonal entry d, divided by ``2 sqrt(d)``: the quaternion, wxyz."""
    xx, yy, zz = R[0, 0], R[1, 1], R[2, 2]
    wx, wy, wz = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    xy, xz, yz = R[0, 1] + R[1, 0], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1]
    columns = [
        (1 + xx + yy + zz, [1 + xx + yy + zz, wx, wy, wz]),
        (1 + xx - yy - zz, [wx, 1 + xx - yy - zz, xy, xz]),
        (1 - xx + yy - zz, [wy, xy, 1 - xx + yy - zz, yz]),
        (1 - xx - yy + zz, [wz, xz, yz, 1 - xx - yy + zz]),
    ]
    best, column = columns[0][0], vertcat(*columns[0][1])
    for diagonal, candidate in columns[1:]:
        larger = diagonal > best
        column = if_else(larger, vertcat(*candidate), column)
        best = if_else(larger, diagonal, best)
    return column / (2 * sqrt(best))


def log_rate(vector: Expression) -> Expression:
    """G (3, 3) with ``d/dt log R = G w`` for ``dR/dt = [w] R`` and ``vector`` = log R: I - [vector] / 2 + c [vector]^2.

    c = (1 - h cot h) / (2 h)^2 with h half the angle; 1/12 at zero and 1/pi^2 at pi (Bullo and Murray 1995).

    Args:
        vector: rotation vector (3, 1) [rad].
    """
    squared = sumsqr(vector)
    small = squared < _SMALL
    angle = sqrt(if_else(small, 1, squared))
    half = angle / 2
    c = if_else(small, 1 / 12, (1 - half * cos(half) / sin(half)) / angle**2)
    cross = skew(vector)
    return identity(3) - cross / 2 + c * (vector @ vector.T - squared * identity(3))


def log(R: Expression) -> Expression:
    """Rotation vector of a rotation matrix ``R`` (3, 3): axis times angle in [0, pi], shape (3, 1), [rad].

    Args:
        R: the rotation matrix (3, 3).
    """
    quaternion = _largest_column(R)
    quaternion = quaternion * if_else(quaternion[0] < 0, -1, 1)
    w, v = quaternion[0], quaternion[1:4]
    squared = sumsqr(v)
    small = squared < _SMALL
    length = sqrt(if_else(small, 1, squared))
    ratio = if_else(small, 2 * (1 + squared / 6), 2 * atan2(length, w) / length)
    return ratio * v

"""Signed distances of points and segments to boxes, as CasADi expressions (formulations/distances.md)."""

from __future__ import annotations

from jtik.geometry.centers import CENTER, beside
from jtik.symbolic import (
    TINY,
    Expression,
    dot,
    fabs,
    fmax,
    fmin,
    if_else,
    sqrt,
    sumsqr,
    without_derivative,
)

FLAT = 1e-14
"""Weight of the pull towards the middle where every point of a part of a segment is closest.

It makes the closest point unique and its derivative finite. The distance h of a segment of length l changes by less
than FLAT l^2 / h.
"""

PARALLEL = 1e-18
"""Square of the sine below which an edge of a box counts as parallel to a segment: a face is then less deep."""

BELOW_ALL = -1e9
"""A separation [m] that is never the largest."""


def point_to_box(point: Expression, half: Expression) -> Expression:
    """Signed distance [m] from a point to a box; negative inside.

    Args:
        point: the point (d, 1) [m] in the axes of the box, from its centre.
        half: half of the length of each edge (d, 1) [m].
    """
    beyond = fabs(point) - half
    return _length(fmax(beyond, 0)) + fmin(_largest(beyond), 0)


def segment_to_box(start: Expression, end: Expression, half: Expression) -> Expression:
    """Signed distance [m] from a segment to a box; where it enters the box minus the depth of penetration.

    Exact in both cases: the depth is the length of the shortest translation that separates them.

    Args:
        start: start of the segment (d, 1) [m] in the axes of the box, from its centre.
        end: its end.
        half: half of the length of each edge (d, 1) [m].
    """
    along = end - start
    share = _closest_share(start, along, half)
    closest = start + share * along
    outside = _length(closest - _within(closest, half))
    return outside + fmin(_separation(start, along, half), 0)


def _closest_share(start: Expression, along: Expression, half: Expression) -> Expression:
    """The share in [0, 1] of the segment whose point is closest to the box."""
    size = start.shape[0]
    inverse = 1 / (along + TINY)
    breaks = [_clamped((side * half[i] - start[i]) * inverse[i]) for i in range(size) for side in (-1, 1)]
    # the last share at which the distance does not yet rise, and the first at which it no longer falls
    last, first = _rate(start, along, half, 1) <= 0, _rate(start, along, half, 0) < 0
    for each in breaks:
        rate = _rate(start, along, half, each)
        last = fmax(last, (rate <= 0) * each)
        first = fmin(first, each + (rate < 0))  # a share plus one counts for nothing
    middle = without_derivative((first + last) / 2)
    # between the two the square of the distance is one parabola
    there = start + middle * along
    numerator: Expression = 0
    denominator: Expression = 0
    for i in range(size):
        beyond = fabs(there[i]) > half[i]
        face = if_else(there[i] > 0, half[i], -half[i])
        numerator = numerator + beyond * (face - start[i]) * along[i]
        denominator = denominator + beyond * along[i] ** 2
    pull = FLAT * sumsqr(along)
    return _clamped((numerator + pull * middle) / (denominator + pull + TINY))


def _rate(start: Expression, along: Expression, half: Expression, share: Expression) -> Expression:
    """Half of the derivative of the squared distance with respect to the share."""
    point = start + share * along
    return dot(point - _within(point, half), along)


def _separation(start: Expression, along: Expression, half: Expression) -> Expression:
    """The largest separation along a face normal, or along the normal of an edge and the segment; negative inside."""
    middle, size = start + along / 2, start.shape[0]
    faces = fabs(middle) - fabs(along) / 2 - half
    found = _largest(faces)
    for i, j in ((0, 1),) if size == 2 else ((0, 1), (1, 2), (2, 0)):
        square = along[i] ** 2 + along[j] ** 2
        reach = half[i] * fabs(along[j]) + half[j] * fabs(along[i])
        across = fabs(middle[i] * along[j] - middle[j] * along[i]) - reach
        edge = across / sqrt(square + TINY)
        found = fmax(found, if_else(square > PARALLEL * sumsqr(along), edge, BELOW_ALL))
    return found


def in_axes(point: Expression, center: Expression, rotation: Expression) -> Expression:
    """The point (d, 1) [m] in the axes of a rotation matrix (d, d), from a centre, but for 2e-14 m; see `beside`.

    Args:
        point: the point.
        center: the centre (d, 1) [m].
        rotation: the rotation matrix, with the axes as columns.
    """
    return rotation.T @ (point - beside(center))


def _length(vector: Expression) -> Expression:
    """The length of a vector; zero is rounded up, and the Hessian there is of moderate size."""
    return sqrt(sumsqr(vector) + CENTER**2)


def _within(point: Expression, half: Expression) -> Expression:
    return fmin(fmax(point, -half), half)


def _clamped(share: Expression) -> Expression:
    return fmin(fmax(share, 0), 1)


def _largest(column: Expression) -> Expression:
    found = column[0]
    for i in range(1, column.shape[0]):
        found = fmax(found, column[i])
    return found

"""The distance between two segments as a CasADi expression, without branches.

With u and v along the segments and w from the first start to the second, the lines are closest at the share
s = (w x v)'(u x v) / |u x v|^2 of the first. Clamped to [0, 1], then projected onto the second segment and back onto
the first, it is the closest pair of the segments: |w + t v - s u|^2 is convex in (s, t). The cross products make s
accurate for nearly parallel segments, too, where |u|^2 |v|^2 - (u'v)^2 would cancel.

First derivatives do not need those of the shares, since the distance is smallest there. They are left out, and added
for second derivatives as one Newton step from the shares found.
"""

from __future__ import annotations

import numpy as np

from jtik.symbolic import TINY, Expression, cross, dot, floor, fmax, fmin, if_else, norm, sumsqr
from jtik.types import Array

PARALLEL = 1e-6
"""Angle [rad] below which two segments count as parallel: the first share is then 0 or 1, whichever is closer.

The square of the distance changes by at most (1e-6 length)^2 / 4."""

CROSSING = 1e-9
"""Distance [m] below which segments count as crossing: the direction between their points is a rounding error."""

SHORTEST = 1e-10
"""Length [m] below which a segment counts as a point."""


def closest_points(
    start: Expression, end: Expression, other_start: Expression, other_end: Expression
) -> tuple[Expression, Expression]:
    """The points of two segments that are closest to each other, fixed on them in derivatives.

    Where several pairs are closest, as for parallel segments, it is one of them.

    Args:
        start: start of the first segment (2 or 3, 1) [m].
        end: its end.
        other_start: start of the second segment.
        other_end: its end.

    Returns:
        The point of the first and that of the second segment, of the same shape [m].
    """
    share, other, _ = _closest_shares(end - start, other_end - other_start, other_start - start)
    return start + share * (end - start), other_start + other * (other_end - other_start)


def segment_to_segment(
    start: Expression,
    end: Expression,
    other_start: Expression,
    other_end: Expression,
    *,
    first_order: bool = False,
) -> Expression:
    """Distance [m] between two segments; zero where they cross, with the gradient zero.

    Subtract two radii for the signed distance between capsules. It is exact but for rounding, and within 1e-6 rad of
    parallel to 2e-10 m for segments of 1 m that are 1 mm or more apart. Its gradient is continuous except where several
    pairs of points are closest. Its Hessian also jumps where a closest point reaches an end.

    Args:
        start: start of the first segment (2 or 3, 1) [m].
        end: its end.
        other_start: start of the second segment.
        other_end: its end.
        first_order: whether only the first derivatives have to be right, which takes fewer instructions.
    """
    u, v, w = end - start, other_end - other_start, other_start - start
    share, other, is_skew = _closest_shares(u, v, w)
    between = w + other * v - share * u
    between_points = norm(between)
    is_apart = between_points > CROSSING
    distance = if_else(is_apart, between_points, 0)
    if first_order:
        return distance
    # the decrease by a Newton step from the fixed points: zero, with the second derivatives that their motion adds
    free, other_free = (share > 0) * (share < 1), is_skew * (other > 0) * (other < 1)
    a, c, b = sumsqr(u) + (1 - free), sumsqr(v) + (1 - other_free), free * other_free * dot(u, v)
    g, h = free * dot(u, between), other_free * dot(v, between)
    decrease = (c * g**2 - 2 * b * g * h + a * h**2) / (a * c - b**2)
    return distance - if_else(is_apart, decrease / (2 * fmax(distance, CROSSING)), 0)


def _closest_shares(u: Expression, v: Expression, w: Expression) -> tuple[Expression, Expression, Expression]:
    """The shares of both segments at their closest points, without derivatives, and whether they are not parallel."""
    first, second = sumsqr(u), sumsqr(v)
    normal = _cross(u, v)
    square, numerator = sumsqr(normal), dot(_cross(w, v), normal)
    is_skew = square > PARALLEL**2 * first * second
    share = if_else(is_skew, _clamped(numerator / (square + TINY)), numerator > square / 2)
    other = _share(dot(share * u - w, v), second)
    share = _share(dot(w + other * v, u), first)
    return _fixed(share), _fixed(other), is_skew


def _fixed(share: Expression) -> Expression:
    """A share in [0, 1], rounded to 1e-15, whose derivative is zero."""
    return floor(share * 2**50) * 2.0**-50


def _cross(a: Expression, b: Expression) -> Expression:
    """The cross product; of vectors in the plane its third entry."""
    return cross(a, b) if a.shape[0] == 3 else a[0] * b[1] - a[1] * b[0]


def _clamped(share: Expression) -> Expression:
    return fmin(fmax(share, 0), 1)


def _share(along: Expression, square: Expression) -> Expression:
    """along / square in [0, 1]; zero on a segment that is a point."""
    return if_else(square > SHORTEST**2, _clamped(along / (square + TINY)), 0)


def segment_distances(start: Array, end: Array, other_start: Array, other_end: Array) -> Array:
    """The same distance for arrays of segments, (..., 3) each [m]: numbers, and many at once.

    Args:
        start: starts of the first segments (..., 3) [m].
        end: their ends.
        other_start: starts of the other segments (..., 3) [m].
        other_end: their ends.

    Returns:
        Distances (...,) [m].
    """
    u, v, w = end - start, other_end - other_start, other_start - start
    normal = np.cross(u, v)
    square, numerator = _dots(normal, normal), _dots(np.cross(w, v), normal)
    share = np.clip(np.divide(numerator, square, out=np.zeros_like(square), where=square > 0), 0, 1)
    other = _shares(_dots(share[..., None] * u - w, v), v)
    share = _shares(_dots(w + other[..., None] * v, u), u)
    distance: Array = np.linalg.norm(w + other[..., None] * v - share[..., None] * u, axis=-1)
    return distance


def _dots(a: Array, b: Array) -> Array:
    products: Array = (a * b).sum(-1)
    return products


def _shares(along: Array, segment: Array) -> Array:
    square = np.broadcast_to(_dots(segment, segment), along.shape)
    safe = np.where(square > SHORTEST**2, square, np.inf)
    shares: Array = np.clip(along / safe, 0, 1)
    return shares

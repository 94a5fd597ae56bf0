"""The distance between two segments as a CasADi expression, without branches.

With u and v along the segments and w from the first start to the second, the lines are closest at the share
s = (w x v)'(u x v) / |u x v|^2 of the first. Clamped to [0, 1], then projected onto the second segment and back onto
the first, it is the closest pair of the segments: |w + t v - s u|^2 is convex in (s, t). The cross products make s
accurate for nearly parallel segments, too, where a a' - b^2 would cancel.
"""

from __future__ import annotations

import numpy as np

from jtik.symbolic import Expression, cross, dot, fmax, fmin, if_else, norm, sumsqr, without_derivative
from jtik.types import Array

PARALLEL = 1e-6
"""Angle [rad] below which two segments count as parallel: the first share is then 0 or 1, whichever is closer.

The square of the distance changes by at most (1e-6 length)^2 / 4. Above it the derivative of the share is bounded, and
multiplied by a derivative of the distance that is zero but for rounding."""

SHORTEST = 1e-10
"""Length [m] below which a segment counts as a point."""


def closest_points(
    start: Expression,
    end: Expression,
    other_start: Expression,
    other_end: Expression,
    *,
    fixed: bool = False,
) -> tuple[Expression, Expression]:
    """The points of two segments that are closest to each other.

    Where several pairs are closest, as for parallel segments, it is one of them. The derivatives are finite everywhere.
    The points jump where segments pass through parallel; their distance does not.

    Args:
        start: start of the first segment (2 or 3, 1) [m].
        end: its end.
        other_start: start of the second segment.
        other_end: its end.
        fixed: whether the points are fixed on the segments in derivatives, which makes these shorter.

    Returns:
        The point of the first and that of the second segment, of the same shape [m].
    """
    u, v, w = end - start, other_end - other_start, other_start - start
    first, second = sumsqr(u), sumsqr(v)
    normal = _cross(u, v)
    square, numerator = sumsqr(normal), dot(_cross(w, v), normal)
    limit = PARALLEL**2 * first * second + SHORTEST**4
    share = if_else(square > limit, _clamped(numerator / fmax(square, limit)), numerator > square / 2)
    other = _share(dot(share * u - w, v), second)
    share = _share(dot(w + other * v, u), first)
    if fixed:
        share, other = without_derivative(share), without_derivative(other)
    return start + share * u, other_start + other * v


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
        first_order: whether only the first derivatives have to be right, which then take half of the instructions.
    """
    point, other = closest_points(start, end, other_start, other_end, fixed=first_order)
    return norm(point - other)


def _cross(a: Expression, b: Expression) -> Expression:
    """The cross product; of vectors in the plane its third entry."""
    return cross(a, b) if a.shape[0] == 3 else a[0] * b[1] - a[1] * b[0]


def _clamped(share: Expression) -> Expression:
    return fmin(fmax(share, 0), 1)


def _share(along: Expression, square: Expression) -> Expression:
    """along / square in [0, 1]; zero, without a derivative, on a segment that is a point."""
    return if_else(square > SHORTEST**2, _clamped(along / fmax(square, SHORTEST**2)), 0)


def segment_distances(start: Array, end: Array, other_start: Array, other_end: Array) -> Array:
    """The same distance for arrays of segments, (..., 3) each [m]: numbers, and many at once."""
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

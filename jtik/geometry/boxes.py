"""Signed distances of points and segments to boxes, as CasADi expressions (formulations/distances.md)."""

from __future__ import annotations

from jtik.geometry.centers import CENTER, beside
from jtik.symbolic import (
    TINY,
    Expression,
    fabs,
    fmax,
    fmin,
    sqrt,
    sumsqr,
    without_derivative,
)
from jtik.symbolic.held import Hold, not_held

FLAT = 1e-14
"""Weight of the pull towards the middle where every point of a part of a segment is closest.

It makes the closest point unique and its derivative finite. The distance h of a segment of length l changes by less
than FLAT l^2 / h.
"""

PARALLEL = 1e-18
"""Square of the sine below which an edge of a box counts as parallel to a segment: a face is then less deep."""

BELOW_ALL = 1e9
"""What is subtracted from a separation [m] so that it is never the largest."""

WITHIN = 1e6
"""Half of the width of a slab [m] that a segment parallel to it never leaves."""


def point_to_box(point: Expression, half: Expression, hold: Hold = not_held) -> Expression:
    """Signed distance [m] from a point to a box; negative inside.

    Args:
        point: the point (d, 1) [m] in the axes of the box, from its centre.
        half: half of the length of each edge (d, 1) [m].
        hold: marks what first derivatives may leave out, see `jtik.symbolic.held`.
    """
    beyond = fabs(point) - half
    return _length(_positive(beyond, hold)) + _depth([beyond[i] for i in range(half.shape[0])], hold)


def segment_to_box(start: Expression, end: Expression, half: Expression, hold: Hold = not_held) -> Expression:
    """Signed distance [m] from a segment to a box; where it enters the box minus the depth of penetration.

    Exact in both cases: the depth is the length of the shortest translation that separates them.

    Args:
        start: start of the segment (d, 1) [m] in the axes of the box, from its centre.
        end: its end.
        half: half of the length of each edge (d, 1) [m].
        hold: marks what first derivatives may leave out, see `jtik.symbolic.held`.
    """
    along = end - start
    closest = start + hold(_closest_share(start, along, half)) * along
    outside = _length(closest - hold(fmin(fmax(closest, -half), half)))
    return outside + _depth(_separations(start, along, half), hold)


def _closest_share(start: Expression, along: Expression, half: Expression) -> Expression:
    """The share in [0, 1] of the segment whose point is closest to the box (D1)."""
    size = start.shape[0]
    squares, lengths = along**2, fabs(along)
    inverse = 1 / (along + TINY)
    wide = half + (squares <= 0) * WITHIN
    first, second = (-wide - start) * inverse, (wide - start) * inverse
    # the line is between the faces i from the share enters[i] to leaves[i]
    enters, leaves = fmin(first, second), fmax(first, second)
    last, soonest = _largest([enters[i] for i in range(size)]), -_largest([-leaves[i] for i in range(size)])
    after, before = squares * (leaves <= soonest), squares * (enters >= last)
    weights = [sum((each[i] for i in range(size)), 0) for each in (after, before)]
    between = (weights[0] * soonest + weights[1] * last) / (weights[0] + weights[1] + TINY)
    between = fmin(fmax(between, soonest), last)  # but for rounding it is there
    middle = (fmax(last, 0) + fmin(soonest, 1)) / 2
    # where the line enters the box every share in between is a minimum, else the one that two pairs of faces agree on
    enters_box = last <= soonest
    found = enters_box * middle + (1 - enters_box) * between
    # the third pair of faces may join them: one parabola
    is_after, is_before = leaves <= found, enters >= found
    active = is_after + is_before
    numerator = (is_after - is_before) * lengths * half - active * start * along
    denominator = active * squares
    pull = FLAT * sumsqr(along)
    kept = without_derivative(_clamped(found))
    sums = [sum((each[i] for i in range(size)), 0) for each in (numerator, denominator)]
    return _clamped((sums[0] + pull * kept) / (sums[1] + pull + TINY))


def _separations(start: Expression, along: Expression, half: Expression) -> list[Expression]:
    """The separations along the face normals, and along the normals of an edge and the segment; negative inside."""
    middle, lengths, size = start + along / 2, fabs(along), start.shape[0]
    faces = fabs(middle) - lengths / 2 - half
    found = [faces[i] for i in range(size)]
    squares = along**2
    parallel = PARALLEL * sumsqr(along)
    for i, j in ((0, 1),) if size == 2 else ((0, 1), (1, 2), (2, 0)):
        square = squares[i] + squares[j]
        reach = half[i] * lengths[j] + half[j] * lengths[i]
        across = fabs(middle[i] * along[j] - middle[j] * along[i]) - reach
        found.append(across / sqrt(square + TINY) - (square <= parallel) * BELOW_ALL)
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


def _positive(vector: Expression, hold: Hold) -> Expression:
    """The positive part of each entry."""
    return fmax(vector, 0) if hold is not_held else hold(vector > 0) * vector


def _depth(separations: list[Expression], hold: Hold) -> Expression:
    """The largest separation where it is negative, else 0."""
    largest = _largest(separations)
    if hold is not_held:
        return fmin(largest, 0)
    chosen = [hold((each >= largest) * (each < 0)) for each in separations]
    share = hold(1 / (sum(chosen, 0) + TINY))  # equally large ones count alike
    return sum((each * separation for each, separation in zip(chosen, separations, strict=True)), 0) * share


def _clamped(share: Expression) -> Expression:
    return fmin(fmax(share, 0), 1)


def _largest(values: list[Expression]) -> Expression:
    found = values[0]
    for each in values[1:]:
        found = fmax(found, each)
    return found

"""Signed distances of points and segments to convex polygons, as CasADi expressions (formulations/distances.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from jtik.symbolic import TINY, Expression, dot, fmax, fmin, if_else, sqrt, sumsqr, vertcat
from jtik.symbolic.held import Hold, not_held

BELOW_ALL = -1e9
"""A separation [m] that is never the largest: that of a side without length."""


@dataclass(frozen=True)
class Sides:
    """The sides of a convex polygon; several corners may be one point.

    Attributes:
        vertices: its corners, counterclockwise, each (2, 1) [m].
    """

    vertices: Sequence[Expression]

    def pairs(self) -> list[tuple[Expression, Expression]]:
        """The ends of each side."""
        return list(zip(self.vertices, [*self.vertices[1:], self.vertices[0]], strict=True))

    def depths(self, point: Expression) -> list[Expression]:
        """Distance [m] of a point from the line of each side, negative inside.

        Args:
            point: the point (2, 1) [m].
        """
        found = []
        for start, end in self.pairs():
            along = end - start
            square = sumsqr(along)
            across = ((point[0] - start[0]) * along[1] - (point[1] - start[1]) * along[0]) / sqrt(square + TINY)
            found.append(if_else(square > 0, across, BELOW_ALL))
        return found


def point_to_polygon(point: Expression, sides: Sides, hold: Hold = not_held) -> Expression:
    """Signed distance [m] from a point (2, 1) to a convex polygon; negative inside.

    Args:
        point: the point (2, 1) [m].
        sides: the sides of the polygon.
        hold: marks what first derivatives may leave out, see `jtik.symbolic.held`.
    """
    squares = [_square(point, *side, hold) for side in sides.pairs()]
    return _signed(squares, sides.depths(point), hold)


def segment_to_polygon(start: Expression, end: Expression, sides: Sides, hold: Hold = not_held) -> Expression:
    """Signed distance [m] from a segment to a convex polygon; where they overlap minus the depth of penetration.

    Exact in both cases: the depth is the length of the shortest translation that separates them.

    Args:
        start: start of the segment (2, 1) [m].
        end: its end.
        sides: the sides of the polygon.
        hold: marks what first derivatives may leave out, see `jtik.symbolic.held`.
    """
    squares = [_square(vertex, start, end, hold) for vertex in sides.vertices]
    squares += [_square(point, *side, hold) for point in (start, end) for side in sides.pairs()]
    pairs = zip(sides.depths(start), sides.depths(end), strict=True)
    separations = [_extreme(fmin, each, hold) for each in pairs]
    along = end - start
    length = sqrt(sumsqr(along) + TINY)
    across = [(v[0] - start[0]) * along[1] - (v[1] - start[1]) * along[0] for v in sides.vertices]
    beside = _extreme(fmax, [_extreme(fmin, across, hold), -_extreme(fmax, across, hold)], hold) / length
    return _signed(squares, [*separations, if_else(sumsqr(along) > 0, beside, BELOW_ALL)], hold)


def corners(row: Expression) -> list[Expression]:
    """The corners in a row x0, y0, x1, y1, ... of coordinates, each (2, 1) [m]."""
    return [vertcat(row[i], row[i + 1]) for i in range(0, row.numel(), 2)]


def _square(point: Expression, start: Expression, end: Expression, hold: Hold) -> Expression:
    """Squared distance [m^2] from a point to a segment."""
    along = end - start
    share = fmin(fmax(dot(point - start, along) / (sumsqr(along) + TINY), 0), 1)
    return sumsqr(start + hold(share) * along - point)


def _signed(squares: Sequence[Expression], gaps: Sequence[Expression], hold: Hold) -> Expression:
    """The root of the smallest square where the largest gap is positive, else that gap."""
    gap = _extreme(fmax, gaps, hold)
    return if_else(hold(gap > 0), sqrt(_extreme(fmin, squares, hold) + TINY), gap)


def _extreme(larger_or_smaller: Expression, values: Sequence[Expression], hold: Hold) -> Expression:
    found = values[0]
    for each in values[1:]:
        found = larger_or_smaller(found, each)
    if hold is not_held:
        return found
    chosen = [hold(each == found) for each in values]
    share = hold(1 / sum(chosen, 0))  # equal ones count alike
    return share * sum((each * value for each, value in zip(chosen, values, strict=True)), 0)

"""Signed distances as CasADi expressions."""

from __future__ import annotations

from jtik.symbolic import TINY, Expression, dot, fmax, fmin, norm, sumsqr


def point_to_ball(point: Expression, center: Expression, radius: Expression) -> Expression:
    """Signed distance [m] from a point to the surface of a ball; negative inside."""
    return norm(point - center) - radius


def segment_to_ball(start: Expression, end: Expression, center: Expression, radius: Expression) -> Expression:
    """Signed distance [m] from the closest point of a segment to the surface of a ball; negative inside."""
    along = end - start
    parameter = fmin(fmax(dot(center - start, along) / (sumsqr(along) + TINY), 0), 1)
    return point_to_ball(start + parameter * along, center, radius)

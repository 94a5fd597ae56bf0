"""Signed distances of points and segments to balls, capsules and half-spaces, as CasADi expressions.

The derivations of these and of the other shapes are in formulations/distances.md.
"""

from __future__ import annotations

from jtik.geometry.centers import CENTER
from jtik.geometry.segments import segment_to_segment
from jtik.symbolic import TINY, Expression, dot, fabs, fmax, fmin, sqrt, sumsqr
from jtik.symbolic.held import Hold, not_held


def point_to_ball(point: Expression, center: Expression, radius: Expression) -> Expression:
    """Signed distance [m] from a point to the surface of a ball; negative inside, with the gradient 0 at the centre.

    Args:
        point: the point (d, 1) [m].
        center: centre of the ball (d, 1) [m].
        radius: its radius [m].
    """
    return sqrt(sumsqr(point - center) + CENTER**2) - radius


def segment_to_ball(
    start: Expression, end: Expression, center: Expression, radius: Expression, hold: Hold = not_held
) -> Expression:
    """Signed distance [m] from the closest point of a segment to the surface of a ball; negative inside.

    Args:
        start: start of the segment (d, 1) [m].
        end: its end.
        center: centre of the ball (d, 1) [m].
        radius: its radius [m].
        hold: marks what first derivatives may leave out, see `jtik.symbolic.held`.
    """
    along = end - start
    share = fmin(fmax(dot(center - start, along) / (sumsqr(along) + TINY), 0), 1)
    return point_to_ball(start + hold(share) * along, center, radius)


def point_to_half_space(point: Expression, origin: Expression, normal: Expression) -> Expression:
    """Signed distance [m] from a point to a half-space with a unit normal; negative inside.

    Args:
        point: the point (d, 1) [m].
        origin: a point of the boundary (d, 1) [m].
        normal: unit normal that points out of the half-space (d, 1).
    """
    return dot(normal, point - origin)


def segment_to_half_space(
    start: Expression, end: Expression, origin: Expression, normal: Expression, hold: Hold = not_held
) -> Expression:
    """Signed distance [m] from the deeper end of a segment to a half-space with a unit normal; negative inside.

    Args:
        start: start of the segment (d, 1) [m].
        end: its end.
        origin: a point of the boundary (d, 1) [m].
        normal: unit normal that points out of the half-space (d, 1).
        hold: marks what first derivatives may leave out, see `jtik.symbolic.held`.
    """
    rise = dot(normal, end - start)
    return dot(normal, start - origin) + (fmin(rise, 0) if hold is not_held else hold(rise < 0) * rise)


def point_to_capsule(
    point: Expression, start: Expression, end: Expression, radius: Expression, hold: Hold = not_held
) -> Expression:
    """Signed distance [m] from a point to the surface of a capsule; negative inside.

    Args:
        point: the point (d, 1) [m].
        start: start of the capsule's axis (d, 1) [m].
        end: its end.
        radius: radius of the capsule [m].
        hold: marks what first derivatives may leave out, see `jtik.symbolic.held`.
    """
    return segment_to_ball(start, end, point, radius, hold)


def segment_to_capsule(
    start: Expression,
    end: Expression,
    axis_start: Expression,
    axis_end: Expression,
    radius: Expression,
    hold: Hold = not_held,
) -> Expression:
    """Signed distance [m] between a segment and the surface of a capsule; negative where they overlap.

    In the plane a segment that crosses the axis is as deep as the shortest translation that separates them. In space,
    where two segments cross at single configurations only, the gradient there is zero.

    Args:
        start: start of the segment (d, 1) [m].
        end: its end.
        axis_start: start of the capsule's axis (d, 1) [m].
        axis_end: its end.
        radius: radius of the capsule [m].
        hold: marks what first derivatives may leave out, see `jtik.symbolic.held`.
    """
    distance = segment_to_segment(start, end, axis_start, axis_end, first_order=hold is not not_held)
    if start.shape[0] == 2:
        gap = _gap(start, end, axis_start, axis_end, hold)
        distance = distance + (fmin(gap, 0) if hold is not_held else hold(gap < 0) * gap)
    return distance - radius


def _gap(start: Expression, end: Expression, other_start: Expression, other_end: Expression, hold: Hold) -> Expression:
    """The larger separation of two segments in the plane along the normal of one of them; negative if they cross."""
    u, v = end - start, other_end - other_start
    between = (other_start + other_end - start - end) / 2
    separations = []
    for along, other in ((u, v), (v, u)):
        length = sqrt(sumsqr(along) + TINY)
        across = fabs(between[0] * along[1] - between[1] * along[0])
        separations.append((across - fabs(other[0] * along[1] - other[1] * along[0]) / 2) / length)
    if hold is not_held:
        return fmax(*separations)
    first = hold((separations[0] > separations[1]) + (separations[0] >= separations[1])) / 2  # equal ones count alike
    return first * separations[0] + (1 - first) * separations[1]

"""Signed distances of points and segments to cylinders, as CasADi expressions (formulations/distances.md)."""

from __future__ import annotations

from dataclasses import dataclass

from jtik.geometry.centers import CENTER, beside
from jtik.symbolic import TINY, Expression, dot, fabs, fmax, fmin, if_else, sqrt, sumsqr, without_derivative
from jtik.symbolic.held import Hold, not_held

HALVINGS = 22
"""Bisections for the closest point of a segment: to 2.4e-7 of its length, and one Newton step follows."""

FLAT = 1e-14
"""Weight that keeps the Newton step finite where all points of a segment are equally close."""


@dataclass(frozen=True)
class Axis:
    """A cylinder with flat ends, by its axis.

    Attributes:
        center: middle of its axis (3, 1) [m].
        direction: unit vector along it (3, 1).
        half: half of its length [m].
        radius: its radius [m].
    """

    center: Expression
    direction: Expression
    half: Expression
    radius: Expression

    @classmethod
    def between(cls, start: Expression, end: Expression, radius: Expression) -> Axis:
        """The cylinder around a segment (3, 1) [m].

        Args:
            start: start of the segment (3, 1) [m].
            end: its end.
            radius: radius of the cylinder [m].
        """
        along = end - start
        length = sqrt(sumsqr(along) + TINY)
        return cls(beside((start + end) / 2), along / length, length / 2, radius)

    def split(self, vector: Expression) -> tuple[Expression, Expression]:
        """The component of a vector along the axis, and the rest.

        Args:
            vector: the vector (3, 1).
        """
        height = dot(vector, self.direction)
        return height, vector - height * self.direction


def point_to_cylinder(point: Expression, axis: Axis, hold: Hold = not_held) -> Expression:
    """Signed distance [m] from a point (3, 1) to a cylinder; negative inside.

    Args:
        point: the point (3, 1) [m].
        axis: the cylinder.
        hold: marks what first derivatives may leave out, see `jtik.symbolic.held`.
    """
    height, across = axis.split(point - axis.center)
    return _depth(sqrt(sumsqr(across) + CENTER**2) - axis.radius, fabs(height) - axis.half, hold)


def segment_to_cylinder(start: Expression, end: Expression, axis: Axis, hold: Hold = not_held) -> Expression:
    """Signed distance [m] from the point of a segment that is closest to a cylinder, or deepest in it.

    The closest point is found by a fixed number of bisections and one Newton step: outside the distance is exact to
    1e-9 of the segment's length.

    Args:
        start: start of the segment (3, 1) [m].
        end: its end.
        axis: the cylinder.
        hold: marks what first derivatives may leave out, see `jtik.symbolic.held`.
    """
    height, across = axis.split(start - axis.center)
    rise, drift = axis.split(end - start)
    # the squared distance from the axis is a quadratic in the share
    square, slope, drift_squared = sumsqr(across), dot(across, drift), sumsqr(drift)

    def at(share: Expression) -> tuple[Expression, ...]:
        """Distance from the axis, its derivative, height from the nearer end's side, and its derivative."""
        reach = sqrt(fmax(square + share * (2 * slope + share * drift_squared), 0) + CENTER**2)
        upright = height + share * rise
        return (
            reach - axis.radius,
            (slope + share * drift_squared) / reach,
            fabs(upright) - axis.half,
            if_else(upright > 0, rise, -rise),
        )

    share: Expression = 0.5
    for k in range(HALVINGS):
        beside, outward, above, upward = at(share)
        outside = fmax(beside, 0) * outward + fmax(above, 0) * upward
        inside = if_else(beside > above, outward, upward)
        rate = if_else(fmax(beside, above) > 0, outside, inside)
        share = share + 0.5 ** (k + 2) * ((rate < 0) - (rate > 0))
    share = without_derivative(share)
    beside, outward, above, upward = at(share)
    rate = fmax(beside, 0) * outward + fmax(above, 0) * upward
    curvature = (beside > 0) * (outward**2 + beside * (drift_squared - outward**2) / (beside + axis.radius))
    curvature = curvature + (above > 0) * rise**2
    moved = fmin(fmax(-rate / (curvature + FLAT * (rise**2 + drift_squared) + TINY), -(0.5**HALVINGS)), 0.5**HALVINGS)
    share = fmin(fmax(share + moved, 0), 1)
    closest = start + hold(share) * (end - start)
    return point_to_cylinder(closest, axis, hold)


def _depth(beside: Expression, above: Expression, hold: Hold) -> Expression:
    """Signed distance of what is so far beyond the side and beyond the ends."""
    if hold is not_held:
        outside = sqrt(fmax(beside, 0) ** 2 + fmax(above, 0) ** 2 + CENTER**2)
        return outside + fmin(fmax(beside, above), 0)
    outside = sqrt((hold(beside > 0) * beside) ** 2 + (hold(above > 0) * above) ** 2 + CENTER**2)
    first = hold((beside > above) + (beside >= above)) / 2  # equal ones count alike
    inside = hold((beside < 0) * (above < 0))
    return outside + inside * (first * beside + (1 - first) * above)

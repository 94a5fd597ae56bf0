"""Centres of obstacles, beside which every distance has a gradient and a Hessian of moderate size."""

from __future__ import annotations

from jtik.symbolic import Expression, vertcat

CENTER = 2.0**-46
"""Distance [m] below which a point counts as at a centre: the rounding of coordinates of some dozens of metres."""

ASIDE = (1.0, 0.7, 0.45)
"""The direction from a centre to the point that takes its place, with no symmetry of common shapes."""


def beside(center: Expression) -> Expression:
    """The point (d, 1) [m] that takes the place of a centre, 1.3 `CENTER` away.

    At the centre itself every direction leads out as fast, and the gradient of a distance would be zero.
    """
    return center + vertcat(*(CENTER * each for each in ASIDE[: center.shape[0]]))

"""When a direction in the null space is larger than the rounding of its own computation."""

from __future__ import annotations

from jtik.symbolic import Expression

NOISE = 1e-13
"""|h| / |grad H| below which h = (I - J+ J) grad H is rounding, not a direction."""


def significant(length: Expression, gradient_norm: Expression) -> Expression:
    """1 where ``length`` = |h| is above the rounding of a gradient with this norm, else 0."""
    return length > NOISE * gradient_norm

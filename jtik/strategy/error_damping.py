"""Damping in proportion to the squared error, bounded for distant targets (formulations/damped.md)."""

from __future__ import annotations

from jtik.symbolic import Expression, fmin, sqrt, sumsqr
from jtik.symbolic.factorization import squared_length

def error_damping(J: Expression, residual: Expression, rate: float) -> Expression:
    """``rate`` times 1/2 |residual|^2, at most the curvature that J' J leaves out.

    More damping shortens a step for no reason: at a distant target the damping grows with the square of the distance,
    and the slope with the distance.

    Args:
        J: Jacobian (m, n).
        residual: the error (m, 1).
        rate: damping over half the squared error, [1 / rad^2].
    """
    squared = sumsqr(residual)
    return fmin(rate * squared / 2, sqrt(J.shape[1] / 2 * squared * squared_length(J)))

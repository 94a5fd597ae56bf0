"""Convexity test of a quadratic form: some solvers accept any stationary point."""

from __future__ import annotations

from functools import cache

import numpy as np

from jtik.symbolic import MX, Expression, Function, fabs, fmax, function, if_else, logic_and, numbers, symbol

ZERO_PIVOT = 1e-9
"""Pivots of at most this fraction of the largest diagonal entry count as zero; below minus it, as negative."""

ZERO_OFF_DIAGONAL = 1e-4
"""Off-diagonal entries up to this fraction count as zero: a semidefinite matrix bounds them by sqrt(pivot * pivot)."""


def is_convex(P: Expression) -> Expression:
    """1 where the symmetric ``P`` (n, n) is positive semidefinite to rounding, else 0: by the pivots of L D L'."""
    n = P.shape[0]
    if isinstance(P, MX):
        return _function(n)(P)
    rest = [[P[i, j] for j in range(i + 1)] for i in range(n)]
    scale: Expression = 0
    for i in range(n):
        scale = fmax(scale, fabs(rest[i][i]))
    convex: Expression = 1
    for j in range(n):
        pivot, zero = rest[j][j], rest[j][j] <= ZERO_PIVOT * scale
        convex = logic_and(convex, pivot >= -ZERO_PIVOT * scale)
        for i in range(j + 1, n):
            convex = logic_and(convex, if_else(zero, fabs(rest[i][j]) <= ZERO_OFF_DIAGONAL * scale, 1))
            factor = if_else(zero, 0, rest[i][j] / if_else(zero, 1, pivot))
            for k in range(j + 1, i + 1):
                rest[i][k] = rest[i][k] - factor * rest[k][j]
    return convex


@cache
def _function(n: int) -> Function:
    """The same for matrices of this size as a function."""
    P = symbol("P", n, n)
    return function("is_convex", [P], [is_convex(P)])


def smallest_eigenvalue(P: Expression) -> float | None:
    """The smallest eigenvalue of a numeric matrix, relative to its largest entry.

    None if the matrix has symbols or entries that are not finite, or is zero.
    """
    values = numbers(P)
    if values is None or not np.isfinite(values).all() or not values.any():
        return None
    return float(np.linalg.eigvalsh((values + values.T) / 2)[0] / np.abs(values).max())

"""Whether a quadratic form is convex: not every solver looks for more than a stationary point."""

from __future__ import annotations

import numpy as np

from jtik.symbolic import Expression, fabs, fmax, if_else, logic_and, numbers

FLAT = 1e-9
"""A pivot below this fraction of the largest diagonal entry counts as zero, above minus it as not negative."""

BESIDE = 1e-4
"""Largest entry beside a pivot that counts as zero: in a semidefinite matrix the geometric mean of two pivots."""


def convex(P: Expression) -> Expression:
    """1 where the symmetric ``P`` (n, n) is positive semidefinite to rounding, else 0: by the pivots of L D L'."""
    n = P.shape[0]
    rest = [[P[i, j] for j in range(i + 1)] for i in range(n)]
    scale: Expression = 0
    for i in range(n):
        scale = fmax(scale, fabs(rest[i][i]))
    good: Expression = 1
    for j in range(n):
        pivot, zero = rest[j][j], rest[j][j] <= FLAT * scale
        good = logic_and(good, pivot >= -FLAT * scale)
        for i in range(j + 1, n):
            good = logic_and(good, if_else(zero, fabs(rest[i][j]) <= BESIDE * scale, 1))
            factor = if_else(zero, 0, rest[i][j] / if_else(zero, 1, pivot))
            for k in range(j + 1, i + 1):
                rest[i][k] = rest[i][k] - factor * rest[k][j]
    return good


def lowest_eigenvalue(P: Expression) -> float | None:
    """Of a matrix of numbers, relative to its largest entry; None where it has symbols or something not finite."""
    values = numbers(P)
    if values is None or not np.isfinite(values).all() or not values.any():
        return None
    return float(np.linalg.eigvalsh((values + values.T) / 2)[0] / np.abs(values).max())

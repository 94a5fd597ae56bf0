"""Sums over many rows of a matrix as a call with a loop in it: the text of an expression does not grow with them."""

from __future__ import annotations

from jtik.symbolic.loops import looped
from jtik.symbolic.operations import Expression, horzcat


def weighted_sums(matrix: Expression, weights: Expression, values: Expression) -> tuple[Expression, Expression]:
    """M' diag(weights) M (n, n) and M' values (n, 1).

    They are less to build and to compile than `jtik.symbolic.gram` of many rows, and slower than that of a few.

    Args:
        matrix: M (m, n).
        weights: one for each row (m, 1).
        values: one for each row (m, 1).
    """
    product, sums = looped(_sums, matrix, weights, values)
    return product, sums


def _sums(matrix: Expression, weights: Expression, values: Expression) -> list[Expression]:
    weighted = horzcat(*[weights * matrix[:, j] for j in range(matrix.shape[1])])
    return [matrix.T @ weighted, matrix.T @ values]

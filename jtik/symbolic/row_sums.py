"""Sums over many rows of a matrix as a call with a loop in it: the text of an expression does not grow with them."""

from __future__ import annotations

from functools import cache

from jtik.symbolic.operations import MX, Expression, Function, function, horzcat


def weighted_sums(matrix: Expression, weights: Expression, values: Expression) -> tuple[Expression, Expression]:
    """M' diag(weights) M (n, n) and M' values (n, 1).

    They are less to build and to compile than `jtik.symbolic.gram` of many rows, and slower than that of a few.

    Args:
        matrix: M (m, n).
        weights: one for each row (m, 1).
        values: one for each row (m, 1).
    """
    found: tuple[Expression, Expression] = _sums(*matrix.shape)(matrix, weights, values)
    return found


@cache
def _sums(rows: int, columns: int) -> Function:
    matrix, weights, values = MX.sym("M", rows, columns), MX.sym("w", rows), MX.sym("v", rows)
    weighted = horzcat(*[weights * matrix[:, j] for j in range(columns)])
    return function("sums", [matrix, weights, values], [matrix.T @ weighted, matrix.T @ values], inline=False)

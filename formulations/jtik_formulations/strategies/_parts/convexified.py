"""A symmetric matrix made positive definite by a modified L D L' factorisation (formulations/second_order.md)."""

from __future__ import annotations

from collections.abc import Sequence

from jtik.symbolic import TINY, Expression, diag, fabs, fmax, fmin, if_else, logic_and, vertcat

FLAT = 1e-8
"""A pivot below this fraction of the largest entry counts as zero."""

RAISED = 1e-2
"""What such a pivot is raised to."""


def convexified(A: Expression) -> tuple[Expression, Expression, Expression]:
    """A symmetric matrix plus a diagonal that makes it positive definite.

    By the modified factorisation L D L' of Gill, Murray and Wright (1981): a pivot that is not above FLAT, or too small
    for the column it divides, is raised. The diagonal is exactly zero where A is positive definite.

    Args:
        A: symmetric matrix (n, n) with entries of order 1.

    Returns:
        The positive definite matrix (n, n), 1 where the diagonal is zero, and the smallest pivot or 0.
    """
    n = A.shape[0]
    diagonal = [fabs(A[i, i]) for i in range(n)]
    others = [fabs(A[i, j]) for i in range(n) for j in range(i)]
    bound = fmax(2 * largest(diagonal), largest(others)) + TINY  # of any entry of L D^1/2, squared
    rest = [[A[i, j] for j in range(i + 1)] for i in range(n)]
    added, definite, lowest = [], 1, 0
    for j in range(n):
        column = [rest[i][j] for i in range(j + 1, n)]
        smallest = largest([fabs(entry) for entry in column]) ** 2 / bound
        pivot = rest[j][j]
        good = logic_and(pivot > FLAT, pivot >= smallest)
        used = if_else(good, pivot, fmax(fmax(fabs(pivot), smallest), RAISED))
        added.append(used - pivot)
        definite = logic_and(definite, good)
        lowest = fmin(lowest, pivot)
        for i in range(j + 1, n):
            factor = rest[i][j] / used
            for k in range(j + 1, i + 1):
                rest[i][k] = rest[i][k] - factor * rest[k][j]
    return A + diag(vertcat(*added)), definite, lowest


def largest(values: Sequence[Expression]) -> Expression:
    """The largest of non-negative values; 0 of none."""
    found: Expression = 0
    for value in values:
        found = fmax(found, value)
    return found

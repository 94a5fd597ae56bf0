"""A symmetric matrix made positive definite by a modified L D L' factorisation (formulations/second_order.md)."""

from __future__ import annotations

from jtik.symbolic import (
    TINY,
    Expression,
    diag,
    fabs,
    fmax,
    fmin,
    if_else,
    logic_and,
    norm_inf,
    tril,
    vec,
    vertcat,
)

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
    bound = fmax(2 * norm_inf(diag(A)), norm_inf(vec(tril(A)))) + TINY  # of any entry of L D^1/2, squared
    rest, added, definite, lowest = A, [], 1, 0  # only the lower triangle of what is left is used
    for _ in range(A.shape[0]):
        pivot, column = rest[0, 0], rest[1:, 0]
        smallest = norm_inf(vertcat(0, column)) ** 2 / bound
        good = logic_and(pivot > FLAT, pivot >= smallest)
        used = if_else(good, pivot, fmax(fmax(fabs(pivot), smallest), RAISED))
        added.append(used - pivot)
        definite = logic_and(definite, good)
        lowest = fmin(lowest, pivot)
        rest = rest[1:, 1:] - (column / used) @ column.T
    return A + diag(vertcat(*added)), definite, lowest

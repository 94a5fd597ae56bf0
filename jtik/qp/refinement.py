"""Refinement of a QP's solution: equality rows that hold to rounding instead of to the solver's tolerance.

A solver satisfies rows and box to a tolerance of about 1e-8, and what is shorter than that is noise. Where a solution
is to lie in a null space, it is therefore corrected: variables whose bound is active are put on it, the others move by
the shortest displacement after which the rows hold. The solution stays in the box.
"""

from __future__ import annotations

from collections.abc import Sequence

from jtik.symbolic import (
    TINY,
    Expression,
    Function,
    diag,
    fmax,
    fmin,
    function,
    identity,
    if_else,
    logic_and,
    logic_not,
    logic_or,
    norm,
    norm_inf,
    solve_ldl,
    symbol,
    trace,
    vertcat,
)

DAMPING = 1e-14
"""Damping of the correction, relative to the squared norm of the rows: dependent rows must not enlarge it."""

LARGEST_CHANGE = 1e-2
"""Largest correction, relative to the solution: where it would be longer, the solution is shorter than its error."""

ROUNDS = 2
"""Corrections: a variable that the first one moves out of the box stays on its bound in the second one."""


def refinement(n: int, rows: int, exact: Sequence[int]) -> Function:
    """(C, l, u, lb, ub, x, box multipliers, accuracy) -> x, for QPs of n variables and this number of rows.

    Args:
        n: number of variables.
        rows: number of rows of C.
        exact: indices of the rows to refine; those whose bounds differ are left alone.
    """
    sizes = ((rows, n), (rows, 1), (rows, 1), (n, 1), (n, 1), (n, 1), (n, 1), (1, 1))
    given = [symbol(f"d{i}", *size) for i, size in enumerate(sizes)]
    C, low, high, *rest = given
    chosen = list(exact)
    return function("refined", given, [refined(C[chosen, :], low[chosen], high[chosen], *rest)])


def refined(
    C: Expression,
    low: Expression,
    high: Expression,
    lower: Expression,
    upper: Expression,
    x: Expression,
    multipliers: Expression,
    accuracy: Expression,
) -> Expression:
    """The solution x (n, 1) in the box with C x = ``low`` where low = high; only clipped to the box where that fails.

    Args:
        C: rows (k, n).
        low: their lower bounds (k, 1).
        high: their upper bounds (k, 1).
        lower: lower bounds of x (n, 1).
        upper: upper bounds of x (n, 1).
        x: the solver's solution (n, 1).
        multipliers: multipliers of the box (n, 1), positive at an upper bound.
        accuracy: what the solution is checked against: the largest correction, relative to a solution longer than 1,
            and the distance from a bound up to which a variable with a multiplier is put on it.
    """
    k = C.shape[0]
    equal = vertcat(*[low[i] == high[i] for i in range(k)])
    E, wanted = diag(equal) @ C, if_else(equal, low, 0)
    clipped = fmin(fmax(x, lower), upper)
    at_upper = logic_and(multipliers > 0, x >= upper - accuracy)
    at_lower = logic_and(multipliers < 0, x <= lower + accuracy)
    y = if_else(at_upper, upper, if_else(at_lower, lower, clipped))
    free = logic_not(logic_or(logic_or(at_upper, at_lower), y != x))
    for _ in range(ROUNDS):
        F = E @ diag(free)
        gram = F @ F.T
        gram = gram + diag(1 - equal) + (DAMPING * trace(gram) + TINY) * identity(k)
        for _ in range(2):  # the second time without the rounding and the damping of the first
            y = y + F.T @ solve_ldl(gram, wanted - E @ y)
        inside = fmin(fmax(y, lower), upper)
        free, y = logic_and(free, inside == y), inside
    better = norm_inf(wanted - E @ y) < norm_inf(wanted - E @ clipped)
    size = norm(x)
    small = norm(y - x) <= fmin(accuracy * fmax(1, size), LARGEST_CHANGE * size)
    is_number = logic_or(x <= 0, x >= 0)  # clipping hides NaN
    return if_else(is_number, if_else(logic_and(better, small), y, clipped), x)

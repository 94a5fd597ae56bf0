"""Refinement of a QP's solution: equality rows that hold to rounding instead of to the solver's tolerance.

A solver satisfies rows and box to a tolerance of about 1e-8, and what is shorter than that is noise. Where a solution
is to lie in a null space, it is therefore corrected: variables whose bound is active are put on it, the others move by
the shortest displacement after which the rows hold. The solution stays in the box.
"""

from __future__ import annotations

from collections.abc import Sequence

from jtik.qp.rows import LARGEST_UNROLLED
from jtik.symbolic import (
    MX,
    TINY,
    Expression,
    Function,
    diag,
    either,
    fmax,
    fmin,
    function,
    identity,
    if_else,
    logic_and,
    logic_not,
    logic_or,
    looped,
    mmax,
    norm,
    norm_inf,
    solve_ldl,
    symbol,
    trace,
    vertcat,
)

ROUNDING = 1e-14
"""Violation of the rows, relative to the solution, up to which nothing is corrected."""

DAMPING = 1e-14
"""Damping of the correction, relative to the squared norm of the rows: dependent rows must not enlarge it."""

LARGEST_CHANGE = 1e-2
"""Largest correction, relative to the solution: where it would be longer, the solution is shorter than its error."""

ROUNDS = 2
"""Corrections: a variable that the first one moves out of the box stays on its bound in the second one."""


def refinement(n: int, rows: int, exact: Sequence[int]) -> Function:
    """(C, l, u, lb, ub, x, box multipliers, accuracy) -> x, for QPs of n variables and this number of rows.

    The result is in the box, and violates no other row more than x or the accuracy; x itself where it would. Where x
    is in the box and the rows hold to rounding, as they mostly do, nothing else is evaluated.

    Args:
        n: number of variables.
        rows: number of rows of C.
        exact: indices of the rows to refine; those whose bounds differ are left alone.
    """
    sizes = ((rows, n), (rows, 1), (rows, 1), (n, 1), (n, 1), (n, 1), (n, 1), (1, 1))
    given = [symbol(f"d{i}", *size) for i, size in enumerate(sizes)]
    C, low, high, lower, upper, x, multipliers, accuracy = given
    chosen = list(exact)
    equal = vertcat(*[low[i] == high[i] for i in chosen])
    E, to = diag(equal) @ C[chosen, :], if_else(equal, low[chosen], 0)
    in_box = norm_inf(x - fmin(fmax(x, lower), upper)) <= 0
    holds = logic_and(in_box, norm(to - E @ x) <= ROUNDING * norm(x))
    y, clipped = _corrected(E, to, 1 - equal, lower, upper, x, multipliers, accuracy)
    allowed = fmax(accuracy, _violation(C, low, high, x))  # other rows, of other units, must not suffer
    corrected = if_else(_violation(C, low, high, clipped) <= allowed, clipped, x)
    corrected = if_else(_violation(C, low, high, y) <= allowed, y, corrected)
    keep, correct = function("as_it_is", given, [x]), function("corrected", given, [corrected])
    arguments = [MX.sym(f"a{i}", *size) for i, size in enumerate(sizes)]
    condition = function("holds", given, [holds])(*arguments)
    return function("refined", arguments, [either(keep, correct)(condition, *arguments)])


def _corrected(
    E: Expression,
    to: Expression,
    free_rows: Expression,
    lower: Expression,
    upper: Expression,
    x: Expression,
    multipliers: Expression,
    accuracy: Expression,
) -> tuple[Expression, Expression]:
    """The solution x (n, 1) in the box with E x = ``to``, or only clipped to the box where that fails; and clipped.

    Both are NaN where x is.

    Args:
        E: rows (k, n).
        to: their right-hand sides (k, 1).
        free_rows: 1 for the rows that are zeros and need not hold (k, 1).
        lower: lower bounds of x (n, 1).
        upper: upper bounds of x (n, 1).
        x: the solver's solution (n, 1).
        multipliers: multipliers of the box (n, 1), positive at an upper bound.
        accuracy: what the solution is checked against: the largest correction, relative to a solution longer than 1,
            and the distance from a bound up to which a variable with a multiplier is put on it.
    """
    is_number = logic_or(x <= 0, x >= 0)  # clipping hides NaN
    clipped = if_else(is_number, fmin(fmax(x, lower), upper), x)
    at_upper = logic_and(multipliers > 0, x >= upper - accuracy)
    at_lower = logic_and(multipliers < 0, x <= lower + accuracy)
    y = if_else(at_upper, upper, if_else(at_lower, lower, clipped))
    free = logic_not(logic_or(logic_or(at_upper, at_lower), y != x))
    for _ in range(ROUNDS):
        F = E @ diag(free)
        gram = F @ F.T
        gram = gram + diag(free_rows) + (DAMPING * trace(gram) + TINY) * identity(E.shape[0])
        for _ in range(2):  # the second time without the rounding and the damping of the first
            y = y + F.T @ solve_ldl(gram, to - E @ y)
        inside = fmin(fmax(y, lower), upper)
        free, y = logic_and(free, inside == y), inside
    better = norm(to - E @ y) < norm(to - E @ clipped)
    size = norm(x)
    small = norm(y - x) <= fmin(accuracy * fmax(1, size), LARGEST_CHANGE * size)
    return if_else(logic_and(better, small), y, clipped), clipped


def _violation(C: Expression, low: Expression, high: Expression, x: Expression) -> Expression:
    """Largest violation of a row."""
    return looped(_violated, C, low, high, x, when=C.numel() > LARGEST_UNROLLED)[0]


def _violated(C: Expression, low: Expression, high: Expression, x: Expression) -> list[Expression]:
    Cx = C @ x
    return [fmax(fmax(mmax(low - Cx), mmax(Cx - high)), 0)]

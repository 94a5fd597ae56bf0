"""The quadratic programs of several levels of priority, in order of priority (formulations/lexicographic_qp.md)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from jtik.qp import QPSolution, QuadraticProgram, Rows
from jtik.symbolic import (
    TINY,
    Expression,
    diag,
    fabs,
    fmax,
    fmin,
    gram,
    horzcat,
    identity,
    if_else,
    logic_and,
    logic_not,
    logic_or,
    mmax,
    mmin,
    norm,
    ratio,
    sqrt,
    sumsqr,
    vertcat,
    zeros,
)
from jtik.symbolic.factorization import RowSpace

DEFINITE = 1e-8
"""Smallest curvature of a level's quadratic program, relative to |J|^2: keeps it strictly convex."""

MISSED = 1e-5
"""Remaining fraction of a level's error above which limits, not damping or rounding, are the reason."""

ACTIVE = 1e-4
"""Smallest multiplier of such a limit, relative to |J| times the remaining error."""

Solve = Callable[[QuadraticProgram], QPSolution]
"""What solves quadratic programs, such as ``model.solve``."""


@dataclass(frozen=True)
class Descent:
    """The displacement of all levels.

    Attributes:
        dq: displacement (n, 1).
        free: 0 for a joint whose limit keeps a level from its target, else 1, (n, 1). Moving it away from the limit
            increases that level's error, so that lower levels do not use it.
        missed: for each level the norm of the error that remains because of limits and rows, 0 where none does.
    """

    dq: Expression
    free: Expression
    missed: Sequence[Expression]


def descend(
    J: Expression,
    r: Expression,
    levels: Sequence[Sequence[int]],
    box: tuple[Expression, Expression],
    solve: Solve,
    *,
    damping: float = 0.0,
    added_damping: Expression = 0,
    rows: Rows | None = None,
    start: Expression | None = None,
    weak_motion: Expression = 0,
) -> Descent:
    """The displacement that lexicographically minimises |r_k + J_k dq| over the levels k, within the box and the rows.

    Args:
        J: Jacobian of all levels, (m, n).
        r: residual, (m, 1).
        levels: rows of each level, the highest first.
        box: lower and upper bounds of dq, (n, 1) each, with 0 between them.
        solve: solves the quadratic programs.
        damping: of each level's step, in proportion to half its squared error.
        added_damping: damping of all levels' steps.
        rows: inequalities that hold at every level; ``start`` must satisfy them.
        start: displacement to which the first level adds its own, within the box; 0 by default.
        weak_motion: displacement that the first level subtracts from its own (n, 1), ``model.weak_motion``.
    """
    n = J.shape[1]
    x = zeros(n) if start is None else start
    free, above = vertcat(*[1] * n), list[int]()
    missed = list[Expression]()
    for k, level in enumerate(map(list, levels)):
        # a joint whose limit is active for a level above is not available to this level
        space = RowSpace(J[above + level, :] @ diag(free) if above else J[level, :])
        kept = []
        if above:
            bounds = [space.dependent_bounds(side)[: len(above)] for side in (-1, 1)]
            kept = [Rows("levels above", space.unit_basis[: len(above), :], *bounds)]
        own = space.unit_basis[len(above) :, :]  # directions that move this level and none above it
        back = 0 if above else weak_motion
        step = _Level(J[level, :], r[level], own, box, kept, damping, added_damping, rows, f"level {k}", back)
        x, active, remaining = step.solved(x, solve)
        free = vertcat(*[logic_and(free[j], logic_not(active[j])) for j in range(n)])
        above = above + level
        missed.append(remaining)
    return Descent(x, free, missed)


@dataclass(frozen=True)
class _Level:
    """One level of priority.

    Attributes:
        J: its Jacobian (m, n).
        r: its residual (m, 1).
        own: orthonormal rows of the directions that move this level and none above it (m, n).
        box: lower and upper bounds of the displacement of all levels, (n, 1) each.
        kept: rows that keep the levels above as they are.
        damping: damping over half the squared error.
        added_damping: damping that is added to it.
        rows: inequalities that hold at every level.
        name: name of its quadratic program.
        weak_motion: displacement that it subtracts from its own (n, 1).
    """

    J: Expression
    r: Expression
    own: Expression
    box: tuple[Expression, Expression]
    kept: list[Rows]
    damping: float
    added_damping: Expression
    rows: Rows | None
    name: str
    weak_motion: Expression = 0

    def solved(self, x: Expression, solve: Solve) -> tuple[Expression, list[Expression], Expression]:
        """Add this level's displacement to the displacement x of the levels above.

        Returns the displacement, 1 for each joint whose limit keeps the level from its target, and the norm of the
        error that remains because of limits and rows.
        """
        J, (low, high), (_, n) = self.J, self.box, self.J.shape
        error = self.r + J @ x
        mu = self.damping * sumsqr(error) / 2 + self.added_damping
        y = self._without_limits(error, mu) - self.weak_motion
        inside = fmin(fmax(x + y, low), high) - x
        part = fmin(1, ratio(norm(inside), norm(y)))  # far outside the box a shorter start is better scaled
        start = x + part * y
        size = sumsqr(J.reshape((-1, 1)))
        scale = fmax(mu, DEFINITE * size) + TINY  # at this scale the solver's tolerance is a tolerance of dq
        curved = (J @ self.own.T) / sqrt(scale) @ self.own
        lower, upper, kept = low - start, high - start, self.kept
        solved = logic_and(part >= 1, logic_and(mmax(lower) <= 0, mmin(upper) >= 0))
        if self.rows:  # rows that are violated by rounding at a level above may stay violated
            shifted = self._shifted(self.rows, x, start)
            kept = [*kept, shifted]
            solved = logic_and(solved, logic_and(mmax(shifted.lower) <= 0, mmin(shifted.upper) >= 0))
        solution = solve(
            QuadraticProgram(
                P=gram(curved) + identity(n),
                q=(part - 1) * (curved.T @ (curved @ y) + mu / scale * y),  # zero where no limit is active
                lower=lower,
                upper=upper,
                rows=kept,
                name=self.name,
                closed_form=(zeros(n), solved),
            )
        )
        reached = fmin(fmax(start + solution.x, low), high)  # else rounding could make levels below infeasible
        remaining = norm(self.r + J @ reached)
        missed = remaining > MISSED * norm(error)
        smallest = fmax(ACTIVE * sqrt(size) * remaining, 10 * scale * norm(reached - x))
        multipliers = [scale * fabs(solution.box_multipliers[j]) for j in range(n)]
        limited = mmax(vertcat(*multipliers)) > smallest
        if self.rows:
            sizes = scale * self.rows.sizes(solution.multipliers(self.rows.name))
            limited = logic_or(limited, mmax(sizes) > smallest)
        short = if_else(logic_and(missed, limited), remaining, 0)
        return reached, [logic_and(missed, each > smallest) for each in multipliers], short

    def _without_limits(self, error: Expression, mu: Expression) -> Expression:
        """-(C' C + mu I)^-1 C' error with C = J on this level's own directions; the shortest of all solutions."""
        C, m = self.J @ self.own.T, self.J.shape[0]
        return -self.own.T @ RowSpace(horzcat(C, sqrt(mu) * identity(m))).least_squares(error).vector[:m]

    @staticmethod
    def _shifted(rows: Rows, x: Expression, start: Expression) -> Rows:
        """The rows for a displacement from ``start``; x satisfies them."""
        used, before = rows.product(start), rows.product(x)
        return Rows(rows.name, rows.matrix, fmin(rows.lower, before) - used, fmax(rows.upper, before) - used)

"""The programs of several levels of priority, one after the other (formulations/lexicographic_qp.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from jtik.qp import QPSolution, QuadraticProgram, Rows
from jtik.symbolic import (
    TINY,
    Expression,
    diag,
    fabs,
    fmax,
    fmin,
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
"""Least curvature of a level's program, relative to |J|^2: keeps it definite, decides what nothing else decides."""

MISSED = 1e-5
"""Fraction of a level's error that is left where limits keep it from its aim, rather than damping or rounding."""

PRESSED = 1e-4
"""Least multiplier of a limit that does, relative to |J| times the error that is left."""


class Solver(Protocol):
    """What answers programs, such as a local model."""

    def solve(self, program: QuadraticProgram) -> QPSolution:
        """The answer."""


@dataclass(frozen=True)
class Descent:
    """What the levels came to.

    Attributes: step (n, 1); free (n, 1), 0 for a joint whose limit keeps a level from its aim: whoever moves it away
    from there makes that level worse, so it has nothing left to give to what comes below; else 1; missed, for each
    level the norm of the error that limits and rows leave of it, 0 where they do not keep it from its aim.
    """

    step: Expression
    free: Expression
    missed: Sequence[Expression]


def descend(
    J: Expression,
    r: Expression,
    levels: Sequence[Sequence[int]],
    box: tuple[Expression, Expression],
    solver: Solver,
    *,
    damping: float = 0.0,
    brake: Expression = 0,
    rows: Rows | None = None,
    start: Expression | None = None,
) -> Descent:
    """x (n, 1) that lexicographically minimises |r_k + J_k x| over the levels k, within the box and the rows.

    Args:
        J: Jacobian of all levels, (m, n).
        r: residual, (m, 1).
        levels: rows of each level, the highest first.
        box: lower and upper bounds of x, (n, 1) each, with 0 between them.
        solver: what answers the programs.
        damping: of each level's step, in proportion to half its squared error.
        brake: damping of all levels' steps.
        rows: inequalities that hold at every level; ``start`` must satisfy them.
        start: the x to which the first level adds its own, within the box; 0 by default.
    """
    n = J.shape[1]
    x = zeros(n) if start is None else start
    free, above = vertcat(*[1] * n), list[int]()
    missed = list[Expression]()
    for k, level in enumerate(map(list, levels)):
        # a joint that a level above has pressed against its limit is none of this level's
        space = RowSpace(J[above + level, :] @ diag(free) if above else J[level, :])
        kept = []
        if above:
            bounds = [space.dependent_bounds(side)[: len(above)] for side in (-1, 1)]
            kept = [Rows("levels above", space.unit_basis[: len(above), :], *bounds)]
        own = space.unit_basis[len(above) :, :]  # what this level can move and none above it feels
        x, pressed, left = _level(J[level, :], r[level], own, x, box, solver, kept, damping, brake, rows, f"level {k}")
        free = vertcat(*[logic_and(free[j], logic_not(pressed[j])) for j in range(n)])
        above = above + level
        missed.append(left)
    return Descent(x, free, missed)


def _level(
    J: Expression,
    r: Expression,
    own: Expression,
    x: Expression,
    box: tuple[Expression, Expression],
    solver: Solver,
    kept: list[Rows],
    damping: float,
    brake: Expression,
    rows: Rows | None,
    name: str,
) -> tuple[Expression, list[Expression], Expression]:
    """From the answer of the levels above to that of this one too; which joints' limits keep it from its aim; and what
    error limits and rows leave of it."""
    (low, high), (m, n) = box, J.shape
    C = J @ own.T
    error = r + J @ x
    mu = damping * sumsqr(error) / 2 + brake
    # the answer without limits: (C' C + mu I)^-1 C' error, and of all least-squares answers the shortest
    y = -own.T @ RowSpace(horzcat(C, sqrt(mu) * identity(m))).least_squares(error).vector[:m]
    inside = fmin(fmax(x + y, low), high) - x
    part = fmin(1, ratio(norm(inside), norm(y)))  # far outside the box, numbers of its size are better
    start = x + part * y
    size = sumsqr(J.reshape((-1, 1)))
    scale = fmax(mu, DEFINITE * size) + TINY  # at this scale the solver's tolerance is one of joints
    curved = C / sqrt(scale) @ own
    room = [low - start, high - start]
    there = logic_and(part >= 1, logic_and(mmax(room[0]) <= 0, mmin(room[1]) >= 0))
    if rows:  # what rounding broke above may stay
        used = rows.matrix @ start
        lower, upper = fmin(rows.lower, rows.matrix @ x), fmax(rows.upper, rows.matrix @ x)
        kept = [*kept, Rows(rows.name, rows.matrix, lower - used, upper - used)]
        there = logic_and(there, logic_and(mmax(lower - used) <= 0, mmin(upper - used) >= 0))
    answer = solver.solve(
        QuadraticProgram(
            P=curved.T @ curved + identity(n),
            q=(part - 1) * (curved.T @ (curved @ y) + mu / scale * y),  # zero where no limit is in the way
            lower=room[0],
            upper=room[1],
            rows=kept,
            name=name,
            closed_form=(zeros(n), there),
        )
    )
    reached = fmin(fmax(start + answer.x, low), high)  # what rounding left outside would be infeasible below
    left = norm(r + J @ reached)
    missed = left > MISSED * norm(error)
    moved = norm(reached - x)
    force = [scale * fabs(answer.box_multipliers[j]) for j in range(n)]
    least = fmax(PRESSED * sqrt(size) * left, 10 * scale * moved)
    held = mmax(vertcat(*force)) > least
    if rows:
        used = answer.multipliers(rows.name)
        pressing = [scale * fabs(used[i]) * norm(rows.matrix[i, :]) for i in range(rows.count)]
        held = logic_or(held, mmax(vertcat(*pressing)) > least)
    short = if_else(logic_and(missed, held), left, 0)
    return reached, [logic_and(missed, each > least) for each in force], short

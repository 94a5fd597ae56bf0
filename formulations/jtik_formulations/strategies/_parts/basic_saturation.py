"""Saturation as first published: each trial fixes one more joint; the best one is used (formulations/sns.md)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

from jtik.symbolic import Expression, diag, fabs, fmax, fmin, if_else, logic_and, logic_not, vertcat, zeros
from jtik.symbolic.factorization import RowSpace

WITHIN = 1e-12
"""Distance beyond a bound up to which a displacement counts as inside [rad] or [m]."""

SIGN = 1e-12
"""Magnitude, relative to the largest_entry entry, from which an entry of a direction has a sign."""


@dataclass(frozen=True)
class BasicSaturation:
    """A displacement x in a box, found by repeatedly fixing the joint that leaves the box first.

    Attributes:
        lower: lower bounds of x (n, 1), at largest_scale 0.
        upper: upper bounds of x (n, 1), at smallest_scale 0.
        x: the displacement (n, 1).
        rows: Jacobians of the tasks so far (k, n).
        scale: s of the last task.
    """

    lower: Expression
    upper: Expression
    x: Expression
    rows: Expression
    scale: Expression

    @classmethod
    def initial(cls, lower: Expression, upper: Expression) -> BasicSaturation:
        """No displacement and no task."""
        n = lower.shape[0]
        return cls(lower, upper, zeros(n), zeros(0, n), 1)

    def with_task(self, J: Expression, change: Expression) -> BasicSaturation:
        """Add a task: J x changes by s ``change`` (m, 1), with s at most 1, the largest of all trials."""
        rows = vertcat(self.rows, J)
        k, n = rows.shape
        kept, change = rows @ self.x, vertcat(zeros(self.rows.shape[0]), change)
        free, fixed = zeros(n) + 1, zeros(n)
        x, scale, full_rank, rank = self.x, 0, 1, None
        for _ in range(max(n - k, 0) + 1):
            space = RowSpace(rows @ diag(free))
            rank = space.rank if rank is None else rank
            full_rank = logic_and(full_rank, space.rank >= rank)
            direction = space.least_squares(change).vector
            base = fixed + space.least_squares(kept - rows @ fixed).vector
            share, fits, critical = self._share(base, direction, free)
            better = logic_and(full_rank, logic_and(fits, share > scale))
            x, scale = if_else(better, base + share * direction, x), if_else(better, share, scale)
            fixed = if_else(critical, if_else(direction > 0, self.upper, self.lower), fixed)
            free = logic_and(free, logic_not(critical))
        return replace(self, x=fmin(fmax(x, self.lower), self.upper), rows=rows, scale=scale)

    def towards(self, wanted: Expression) -> BasicSaturation:
        """Add the largest share of ``wanted`` (n, 1), a null-space displacement of the tasks, that the box allows."""
        share: Expression = 1
        for i in range(wanted.shape[0]):
            margin = if_else(wanted[i] > 0, self.upper[i] - self.x[i], self.x[i] - self.lower[i])
            share = fmin(share, if_else(fabs(wanted[i]) > 0, margin / if_else(wanted[i] == 0, 1, fabs(wanted[i])), inf))
        return replace(self, x=fmin(fmax(self.x + fmax(share, 0) * wanted, self.lower), self.upper))

    def _share(
        self, base: Expression, direction: Expression, free: Expression
    ) -> tuple[Expression, Expression, Expression]:
        """The largest s in [0, 1] with base + s direction in the box; 1 if it exists; 1 for the limiting joint."""
        n = range(direction.shape[0])
        largest_scale, smallest_scale, largest_entry = inf, -inf, 0
        for i in n:
            largest_entry = fmax(largest_entry, fabs(direction[i]))
        ends = []
        for i in n:
            moving = fabs(direction[i]) > SIGN * largest_entry
            divisor = if_else(moving, direction[i], 1)
            up, down = (self.upper[i] - base[i]) / divisor, (self.lower[i] - base[i]) / divisor
            inside = logic_and(base[i] >= self.lower[i] - WITHIN, base[i] <= self.upper[i] + WITHIN)
            end_at_rest, start_at_rest = if_else(inside, inf, -inf), if_else(inside, -inf, inf)
            ends.append(if_else(free[i], if_else(moving, fmax(up, down), end_at_rest), inf))
            largest_scale = fmin(largest_scale, ends[i])
            smallest_scale = fmax(
                smallest_scale, if_else(free[i], if_else(moving, fmin(up, down), start_at_rest), -inf)
            )
        fits = logic_and(smallest_scale <= largest_scale, logic_and(largest_scale >= 0, smallest_scale <= 1))
        unassigned: Expression = largest_scale < 1
        critical = []
        for end in ends:
            critical.append(logic_and(unassigned, end <= largest_scale))
            unassigned = logic_and(unassigned, logic_not(critical[-1]))
        return fmin(fmax(largest_scale, 0), 1), fits, vertcat(*critical)

"""Saturation as first published: one joint more at a time, the best of the trials (formulations/sns.md)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

from jtik.symbolic import Expression, diag, fabs, fmax, fmin, if_else, logic_and, logic_not, vertcat, zeros
from jtik.symbolic.factorization import RowSpace

WITHIN = 1e-12
"""What a displacement may lie beyond a bound and still count as inside [rad] or [m]."""

SIGN = 1e-12
"""Size, relative to the largest, from which an entry of a direction has a sign."""


@dataclass(frozen=True)
class BasicSaturation:
    """A displacement x in a box, found by fixing the joint that leaves it first, again and again.

    Attributes:
        lower, upper: the box, (n, 1) each, lower <= 0 <= upper.
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
    def at_rest(cls, lower: Expression, upper: Expression) -> BasicSaturation:
        """No displacement, nothing to keep."""
        n = lower.shape[0]
        return cls(lower, upper, zeros(n), zeros(0, n), 1)

    def with_task(self, J: Expression, change: Expression) -> BasicSaturation:
        """J x changes by s ``change`` (m, 1), with the largest s of all trials, up to 1; earlier tasks stay done."""
        rows = vertcat(self.rows, J)
        k, n = rows.shape
        kept, wanted = rows @ self.x, vertcat(zeros(self.rows.shape[0]), change)
        free, fixed = zeros(n) + 1, zeros(n)
        x, scale, goes_on, rank = self.x, 0, 1, None
        for _ in range(max(n - k, 0) + 1):
            space = RowSpace(rows @ diag(free))
            rank = space.rank if rank is None else rank
            goes_on = logic_and(goes_on, space.rank >= rank)
            slope = space.least_squares(wanted).vector
            base = fixed + space.least_squares(kept - rows @ fixed).vector
            share, fits, critical = self._share(base, slope, free)
            better = logic_and(goes_on, logic_and(fits, share > scale))
            x, scale = if_else(better, base + share * slope, x), if_else(better, share, scale)
            fixed = if_else(critical, if_else(slope > 0, self.upper, self.lower), fixed)
            free = logic_and(free, logic_not(critical))
        return replace(self, x=fmin(fmax(x, self.lower), self.upper), rows=rows, scale=scale)

    def towards(self, wish: Expression) -> BasicSaturation:
        """As far along ``wish`` (n, 1), which moves no task, as the box allows, up to all of it."""
        share: Expression = 1
        for i in range(wish.shape[0]):
            room = if_else(wish[i] > 0, self.upper[i] - self.x[i], self.x[i] - self.lower[i])
            share = fmin(share, if_else(fabs(wish[i]) > 0, room / if_else(wish[i] == 0, 1, fabs(wish[i])), inf))
        return replace(self, x=fmin(fmax(self.x + fmax(share, 0) * wish, self.lower), self.upper))

    def _share(
        self, base: Expression, slope: Expression, free: Expression
    ) -> tuple[Expression, Expression, Expression]:
        """The largest s in 0 to 1 for which base + s slope is in the box; whether there is one; who limits s (n, 1)."""
        n = range(slope.shape[0])
        most, least, largest = inf, -inf, 0
        for i in n:
            largest = fmax(largest, fabs(slope[i]))
        ends = []
        for i in n:
            moves = fabs(slope[i]) > SIGN * largest
            divisor = if_else(moves, slope[i], 1)
            up, down = (self.upper[i] - base[i]) / divisor, (self.lower[i] - base[i]) / divisor
            inside = logic_and(base[i] >= self.lower[i] - WITHIN, base[i] <= self.upper[i] + WITHIN)
            still_end, still_start = if_else(inside, inf, -inf), if_else(inside, -inf, inf)
            ends.append(if_else(free[i], if_else(moves, fmax(up, down), still_end), inf))
            most = fmin(most, ends[i])
            least = fmax(least, if_else(free[i], if_else(moves, fmin(up, down), still_start), -inf))
        fits = logic_and(least <= most, logic_and(most >= 0, least <= 1))
        open_: Expression = most < 1
        critical = []
        for end in ends:
            critical.append(logic_and(open_, end <= most))
            open_ = logic_and(open_, logic_not(critical[-1]))
        return fmin(fmax(most, 0), 1), fits, vertcat(*critical)

"""Displacements that saturate in the null space: the arithmetic of SNS, on matrices (formulations/sns.md).

`Saturation` is the shortest displacement x inside a box that does what it must. It is followed while that grows: first
each task by as much as the box allows, in its direction, then a wish within what the tasks leave free. A leg is
piecewise linear; each of its rounds ends where one joint meets a bound or comes off it. Nothing branches: a round
without anything left to do changes nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from jtik.symbolic import (
    TINY,
    Expression,
    dot,
    fabs,
    fmax,
    fmin,
    identity,
    if_else,
    logic_and,
    logic_not,
    mmin,
    norm,
    ratio,
    sqrt,
    sumsqr,
    vertcat,
    zeros,
)
from jtik.symbolic.factorization import squared_length

NEVER = 1e300
"""Longer than any leg."""

FOREVER = 1e306
"""A pressure that no leg takes away."""

DEPENDENT = 1e-8
"""Relative length of what is left of a row below which it depends on the rows and bounds before it."""

SIGN = 1e-11
"""Size from which a component of what is left of a unit direction has a sign."""


@dataclass(frozen=True)
class Saturation:
    """A displacement between bounds, which joints are at one, and how it answers to forces.

    Attributes:
        lower, upper: the box, (n, 1) each, lower <= 0 <= upper; infinite entries are no bounds.
        x: the displacement (n, 1).
        side: 1 for a joint at its upper bound, -1 at its lower, 0 for a free one (n, 1).
        pressure: the multiplier of its bound, from 0 up at an upper one, down at a lower one, 0 for a free joint;
            FOREVER, with its sign, at a bound without which a task would not get as far as it gets (n, 1).
        response: (n, n), from forces on free joints and displacements of the others to displacements of the free ones
            and forces held by the others; while all are free the projector on what the rows kept leave.
        scale: s of the last task, the share of it that fits into the box, 0 to 1.
        rounds: how many joints may come to or off a bound in a leg. Where more had to, s is smaller than it could be;
            direction and box are kept all the same.
    """

    lower: Expression
    upper: Expression
    x: Expression
    side: Expression
    pressure: Expression
    response: Expression
    scale: Expression
    rounds: int

    @classmethod
    def at_rest(cls, lower: Expression, upper: Expression, *, rounds: int) -> Saturation:
        """No displacement, nothing to keep."""
        n = lower.shape[0]
        none, all_of_it = zeros(n), identity(n) + zeros(n, n)
        return cls(lower, upper, none, none, none, all_of_it, 1, rounds)

    def with_task(self, J: Expression, change: Expression) -> Saturation:
        """J x changes by s ``change`` with the largest s up to 1; of all such x the shortest.

        Args:
            J: Jacobian (m, n).
            change: of J x (m, 1), in the range of J on what earlier tasks leave free.
        """
        along, across = turned(J, change)
        here = self
        for i in range(across.shape[0]):
            here = here._keeping(across[i, :].T, squared_length(J))
        steep = norm(along)
        total, direction = norm(change) / steep, along / steep
        here, rate, left = here._followed(direction, total, by_itself=True)
        stuck = logic_and(left > 0, norm(_free(here.side) * rate) <= DEPENDENT)
        needed = logic_and(stuck, fabs(here.side * rate) > SIGN)
        here = replace(here, pressure=if_else(needed, FOREVER * here.side, here.pressure))
        return replace(here._keeping(direction, 1), scale=if_else(sumsqr(change) > 0, 1 - left / total, 1))

    def towards(self, wish: Expression) -> Saturation:
        """Of all x that do the tasks as this one does the nearest to ``wish`` (n, 1)."""
        length = norm(wish)
        return self._followed(wish / length, length, by_itself=False)[0]

    def _rate(self, force: Expression) -> Expression:
        """How free joints move and pressures grow under a force that grows by ``force`` (n, 1)."""
        free = _free(self.side)
        return self.response @ (free * force) + (1 - free) * force

    def _keeping(self, row: Expression, squared_scale: Expression) -> Saturation:
        """From now on row' x (n, 1) stays as it is. Rank is decided relative to the root of ``squared_scale``."""
        here, rate = self._exchanged(self._rate(row), squared_scale)
        squared = sumsqr(_free(here.side) * rate)
        drop = ratio(squared > DEPENDENT**2 * squared_scale, squared)
        return replace(here, response=here.response - (drop * rate) @ rate.T)

    def _exchanged(self, rate: Expression, squared_scale: Expression) -> tuple[Saturation, Expression]:
        """Where joints at bounds already hold a row: one of them comes off its bound, and the row will hold it.

        The row's own multiplier grows, either way, until the pressure of one is gone.
        """
        if self.side.is_zero():  # at rest
            return self, rate
        held = sumsqr(_free(self.side) * rate) <= DEPENDENT**2 * squared_scale
        scaled = held * rate / (sqrt(squared_scale) + TINY)
        waits = self._waits(_free(self.side), scaled, 1)
        way = if_else(mmin(waits) < NEVER, 1, -1)
        here, after, _ = self._round(way * scaled, NEVER, by_itself=True)
        return here, if_else(held, way * (sqrt(squared_scale) + TINY), 0) * after + (1 - held) * rate

    def _followed(
        self, direction: Expression, total: Expression, *, by_itself: bool
    ) -> tuple[Saturation, Expression, Expression]:
        """Under a force that grows along ``direction``, to ``total``; or, ``by_itself``, until x went so far along it.

        Also the rate at the end and what is left of ``total``.
        """
        here, rate, left = self, self._rate(direction), total
        for _ in range(self.rounds):
            here, rate, left = here._round(rate, left, by_itself=by_itself)
        return replace(here, x=fmin(fmax(here.x, self.lower), self.upper)), rate, left

    def _round(
        self, rate: Expression, left: Expression, *, by_itself: bool
    ) -> tuple[Saturation, Expression, Expression]:
        """One linear piece, to the next event or the end of the leg."""
        free = _free(self.side)
        motion = free * rate
        squared = sumsqr(motion)
        moves = squared > DEPENDENT**2
        pace = moves * squared if by_itself else 1
        waits = self._waits(free, rate, logic_not(moves))
        next_event: Expression = NEVER
        for i in range(waits.shape[0]):
            next_event = fmin(next_event, waits[i])
        end = fmax(fmin(left / fmax(pace, DEPENDENT**2), NEVER), NEVER * (pace <= 0) * (left > 0))
        ends = logic_and(end < NEVER, end <= next_event)
        time = fmax(fmin(end, next_event), 0)
        time = (time < NEVER) * time
        open_ = logic_and(logic_not(ends), next_event < NEVER)
        event = []
        for i in range(waits.shape[0]):
            event.append(logic_and(open_, waits[i] <= next_event))
            open_ = logic_and(open_, logic_not(event[-1]))
        marked = vertcat(*event)
        after = replace(
            self,
            x=self.x + (time * moves) * motion,
            pressure=(1 - marked) * (self.pressure + time * (rate - motion)),
            side=(1 - marked) * self.side + marked * free * (2 * (rate > 0) - 1),
        )
        response, rate = self._pivoted(marked, rate)
        return replace(after, response=response), rate, if_else(ends, 0, fmax(left - time * pace, 0))

    def _waits(self, free: Expression, rate: Expression, still: Expression) -> Expression:
        """How long each free joint goes on before it meets a bound, how long the others stay pressed against theirs."""
        small = fabs(rate) <= SIGN
        pace = 1 / (rate + small)
        to_bound = fmax((self.upper - self.x) * pace, (self.lower - self.x) * pace)
        wait = if_else(free, to_bound, -self.pressure * pace)
        goes_on = small + free * still + (self.side * rate > 0)
        return fmax(wait, NEVER * goes_on)

    def _pivoted(self, event: Expression, rate: Expression) -> tuple[Expression, Expression]:
        """Response and rate after the joint that ``event`` marks with 1 has become bound, or free.

        A principal pivot: what was given of that joint and what followed change places.
        """
        S, n = self.response, rate.shape[0]
        way = 1 - 2 * fabs(dot(event, self.side))
        column = S @ event
        pivot = dot(column, event)
        q = column - way * event
        scaled = q / (pivot + (pivot == 0))
        corner = 2 * way * event
        after = zeros(n, n)
        for i in range(n):
            for k in range(i + 1):
                after[i, k] = after[k, i] = S[i, k] - scaled[i] * q[k]
            after[i, i] -= corner[i]
        return after, rate - dot(rate, event) * scaled


def _free(side: Expression) -> Expression:
    """1 for joints at no bound."""
    return 1 - fabs(side)


def turned(J: Expression, change: Expression) -> tuple[Expression, Expression]:
    """The rows of J turned so that ``change`` lies along the first: that row (n, 1), and the others.

    By a Householder reflection.
    """
    sign = if_else(change[0] >= 0, 1, -1)
    mirror = vertcat(change[0] + sign * norm(change), *[change[i] for i in range(1, change.shape[0])])
    reflected = J - (2 / sumsqr(mirror) * mirror) @ (mirror.T @ J)
    return -sign * reflected[0, :].T, reflected[1:, :]

"""Displacements that saturate in the null space: the arithmetic of SNS, on matrices (formulations/sns.md).

`Saturation` is the shortest displacement x inside a box that achieves the tasks. It is computed by continuation: first
each task displacement grows in its direction as far as the box allows, then x approaches a wanted displacement in the
null space of the tasks. x is piecewise linear along such a path; each round of it ends where one joint reaches a bound
or leaves it. The code has no branches: after the end of a path, further rounds change nothing.
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

UNLIMITED = 1e300
"""Longer than any path."""

PERMANENT = 1e306
"""A multiplier that no path reduces to zero."""

DEPENDENT = 1e-8
"""Relative length of a projected row below which the row depends on the rows and bounds before it."""

SIGN = 1e-11
"""Magnitude from which a component of a projected unit direction has a sign."""


@dataclass(frozen=True)
class Saturation:
    """A displacement within bounds, the active bounds, and the response of the displacement to forces on the joints.

    Attributes:
        lower: lower bounds of x (n, 1), at most 0; minus infinity for none.
        upper: upper bounds of x (n, 1), at least 0; infinity for none.
        x: the displacement (n, 1).
        side: 1 for a joint at its upper bound, -1 at its lower, 0 for a free one (n, 1).
        multiplier: multiplier of each joint's bound (n, 1): non-negative at an upper bound, non-positive at a lower
            one, 0 for a free joint; PERMANENT, with that sign, at a bound that determines the scale of a task.
        response: (n, n), from forces on free joints and displacements of the others to displacements of the free
            joints and reaction forces of the others; with all joints free, the projector to the null space of the rows.
        scale: s of the last task, the share of it that fits into the box, 0 to 1.
        rounds: how many joints may reach or leave a bound along a path. If more would have to, s is smaller than
            possible; direction and box are stationary kept.
    """

    lower: Expression
    upper: Expression
    x: Expression
    side: Expression
    multiplier: Expression
    response: Expression
    scale: Expression
    rounds: int

    @classmethod
    def initial(cls, lower: Expression, upper: Expression, *, rounds: int) -> Saturation:
        """No displacement and no task."""
        n = lower.shape[0]
        none, projector = zeros(n), identity(n) + zeros(n, n)
        return cls(lower, upper, none, none, none, projector, 1, rounds)

    def with_task(self, J: Expression, change: Expression) -> Saturation:
        """Add a task: J x changes by s ``change`` with the largest s up to 1; of all such x the shortest.

        Args:
            J: Jacobian (m, n).
            change: wanted change of J x (m, 1), in the range of J times the null-space projector of earlier tasks.
        """
        along, across = rotated_rows(J, change)
        result = self
        for i in range(across.shape[0]):
            result = result._with_row(across[i, :].T, squared_length(J))
        row_length = norm(along)
        total, direction = norm(change) / row_length, along / row_length
        result, rate, remaining = result._follow(direction, total, by_itself=True)
        blocked = logic_and(remaining > 0, norm(_free(result.side) * rate) <= DEPENDENT)
        determines = logic_and(blocked, fabs(result.side * rate) > SIGN)
        result = replace(result, multiplier=if_else(determines, PERMANENT * result.side, result.multiplier))
        return replace(result._with_row(direction, 1), scale=if_else(sumsqr(change) > 0, 1 - remaining / total, 1))

    def towards(self, wanted: Expression) -> Saturation:
        """Of all x with the same task displacements, the closest to ``wanted`` (n, 1)."""
        length = norm(wanted)
        return self._follow(wanted / length, length, by_itself=False)[0]

    def _rate(self, force: Expression) -> Expression:
        """The rates of free joints and of multipliers under a force on the joints with the rate ``force`` (n, 1)."""
        free = _free(self.side)
        return self.response @ (free * force) + (1 - free) * force

    def _with_row(self, row: Expression, squared_scale: Expression) -> Saturation:
        """Keep row' x, with ``row`` (n, 1), from now on. Rank is decided relative to the root of ``squared_scale``."""
        result, rate = self._exchanged(self._rate(row), squared_scale)
        squared = sumsqr(_free(result.side) * rate)
        drop = ratio(squared > DEPENDENT**2 * squared_scale, squared)
        return replace(result, response=result.response - (drop * rate) @ rate.T)

    def _exchanged(self, rate: Expression, squared_scale: Expression) -> tuple[Saturation, Expression]:
        """Where active bounds already determine row' x, release one of them, which the row then replaces.

        The row's multiplier grows, in either direction, until the multiplier of one bound is zero.
        """
        if self.side.is_zero():  # no bound is active yet
            return self, rate
        determined = sumsqr(_free(self.side) * rate) <= DEPENDENT**2 * squared_scale
        scaled = determined * rate / (sqrt(squared_scale) + TINY)
        times = self._times_to_events(_free(self.side), scaled, 1)
        sign = if_else(mmin(times) < UNLIMITED, 1, -1)
        result, after, _ = self._round(sign * scaled, UNLIMITED, by_itself=True)
        return result, if_else(determined, sign * (sqrt(squared_scale) + TINY), 0) * after + (1 - determined) * rate

    def _follow(
        self, direction: Expression, total: Expression, *, by_itself: bool
    ) -> tuple[Saturation, Expression, Expression]:
        """Follow the path of a force that grows along ``direction`` up to the length ``total``.

        With ``by_itself``, ``total`` is instead the length of the displacement along ``direction``.

        Returns the result, the rate at its end, and the remaining part of ``total``.
        """
        result, rate, remaining = self, self._rate(direction), total
        for _ in range(self.rounds):
            result, rate, remaining = result._round(rate, remaining, by_itself=by_itself)
        return replace(result, x=fmin(fmax(result.x, self.lower), self.upper)), rate, remaining

    def _round(
        self, rate: Expression, remaining: Expression, *, by_itself: bool
    ) -> tuple[Saturation, Expression, Expression]:
        """One linear piece of a path: to the next event or to the end of the path."""
        free = _free(self.side)
        motion = free * rate
        squared = sumsqr(motion)
        moving = squared > DEPENDENT**2
        speed = moving * squared if by_itself else 1
        times = self._times_to_events(free, rate, logic_not(moving))
        next_event: Expression = UNLIMITED
        for i in range(times.shape[0]):
            next_event = fmin(next_event, times[i])
        end = fmax(fmin(remaining / fmax(speed, DEPENDENT**2), UNLIMITED), UNLIMITED * (speed <= 0) * (remaining > 0))
        ends = logic_and(end < UNLIMITED, end <= next_event)
        time = fmax(fmin(end, next_event), 0)
        time = (time < UNLIMITED) * time
        unassigned = logic_and(logic_not(ends), next_event < UNLIMITED)
        event = []
        for i in range(times.shape[0]):
            event.append(logic_and(unassigned, times[i] <= next_event))
            unassigned = logic_and(unassigned, logic_not(event[-1]))
        marked = vertcat(*event)
        after = replace(
            self,
            x=self.x + (time * moving) * motion,
            multiplier=(1 - marked) * (self.multiplier + time * (rate - motion)),
            side=(1 - marked) * self.side + marked * free * (2 * (rate > 0) - 1),
        )
        response, rate = self._pivoted(marked, rate)
        return replace(after, response=response), rate, if_else(ends, 0, fmax(remaining - time * speed, 0))

    def _times_to_events(self, free: Expression, rate: Expression, stationary: Expression) -> Expression:
        """The times until each free joint reaches a bound, and until the multipliers of the others are zero."""
        small = fabs(rate) <= SIGN
        inverse_rate = 1 / (rate + small)
        to_bound = fmax((self.upper - self.x) * inverse_rate, (self.lower - self.x) * inverse_rate)
        time_to_event = if_else(free, to_bound, -self.multiplier * inverse_rate)
        no_event = small + free * stationary + (self.side * rate > 0)
        return fmax(time_to_event, UNLIMITED * no_event)

    def _pivoted(self, event: Expression, rate: Expression) -> tuple[Expression, Expression]:
        """Response and rate after the joint for which ``event`` is 1 has reached a bound, or remaining it.

        A principal pivot: for that joint, the given and the resulting quantity are exchanged.
        """
        S, n = self.response, rate.shape[0]
        sign = 1 - 2 * fabs(dot(event, self.side))
        column = S @ event
        pivot = dot(column, event)
        q = column - sign * event
        scaled = q / (pivot + (pivot == 0))
        corner = 2 * sign * event
        after = zeros(n, n)
        for i in range(n):
            for k in range(i + 1):
                after[i, k] = after[k, i] = S[i, k] - scaled[i] * q[k]
            after[i, i] -= corner[i]
        return after, rate - dot(rate, event) * scaled


def _free(side: Expression) -> Expression:
    """1 for joints that are not at a bound, else 0."""
    return 1 - fabs(side)


def rotated_rows(J: Expression, change: Expression) -> tuple[Expression, Expression]:
    """The rows of J rotated by a Householder reflection so that ``change`` lies along the first row.

    Returns that row (n, 1), and the others (m - 1, n).
    """
    sign = if_else(change[0] >= 0, 1, -1)
    mirror = vertcat(change[0] + sign * norm(change), *[change[i] for i in range(1, change.shape[0])])
    reflected = J - (2 / sumsqr(mirror) * mirror) @ (mirror.T @ J)
    return -sign * reflected[0, :].T, reflected[1:, :]

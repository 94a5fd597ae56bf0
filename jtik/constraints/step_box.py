"""The box in which a step of a given time must end: limits of position, velocity and acceleration in one.

The labels (M1) to (M7) are those of formulations/limits.md, (Q1) that of formulations/motion.md.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from jtik.arguments import positive_number
from jtik.constraints.limits import Bounds
from jtik.symbolic import Expression, Function, fmax, fmin, function, sqrt, symbol, vertcat
from jtik.symbolic.compile import bind
from jtik.types import Array


def braking(distance: Expression, change: float | Expression) -> Expression:
    """The longest step towards a limit at ``distance`` after which a joint can still stop before it (M3).

    Each following step is shorter by ``change``. A negative distance is returned as it is: the step back to the limit.
    """
    return 2 * distance / (1 + sqrt(1 + 2 * fmax(distance, 0) / change))


def approach(distance: Expression, back: Expression, change: Expression | None, gain: float) -> Expression:
    """The longest step towards a limit: a share of its distance, and not too long to stop (M4).

    Outside the limit, where the distance is negative, it is the step back to the limit.

    Args:
        distance: distance to the limit.
        back: how far the joint is outside its other limit. The share does not shorten the way back.
        change: largest change of the step; None without an acceleration limit.
        gain: the share, in (0, 1].
    """
    longest = distance if change is None else braking(distance, change)
    return longest if gain == 1 else fmin(longest, fmax(gain * distance, back))


def box_function(bounds: Bounds) -> Function:
    """(q, displacement of the last step (n, 1), (dt, dt of the last step)) -> box (lower, upper) of the next q."""
    robot = bounds.robot
    q, last, clock = symbol("q", robot.nq), symbol("last", robot.n), symbol("clock", 2)
    dt, lower, upper = clock[0], [-math.inf] * robot.nq, [math.inf] * robot.nq
    for i, j in bounds.bounded:
        largest_step = bounds.velocity[j] * dt
        change = bounds.acceleration[j] * dt**2 if bounds.acceleration[j] < math.inf else None
        low, high = _allowed(last[j] * (dt / clock[1]), largest_step, change)
        limits = bounds.lower[i], bounds.upper[i]
        lower[i], upper[i] = _merged(q[i], limits, low, high, change, bounds.position_gain)
    return function("step_box", [q, last, clock], [vertcat(*lower), vertcat(*upper)])


def _allowed(last: Expression, largest_step: Expression, change: Expression | None) -> tuple[Expression, Expression]:
    """Displacements that (M1) and (M2) allow; if the two do not intersect, the one of (M2) closest to (M1)."""
    if change is None:
        return -largest_step, largest_step
    smallest, largest = last - change, last + change
    return fmin(fmax(-largest_step, smallest), largest), fmin(fmax(largest_step, smallest), largest)


def _merged(
    q: Expression,
    limits: tuple[float, float],
    low: Expression,
    high: Expression,
    change: Expression | None,
    gain: float,
) -> tuple[Expression, Expression]:
    """The same with the position limits (M5), as positions; if the two do not intersect, the closest to the limit."""
    (lower, upper), down, up = limits, q + low, q + high
    lowest, highest = lower, upper
    if change is not None or gain < 1:
        if lower > -math.inf:
            lowest = fmax(q - approach(q - lower, fmax(q - upper, 0), change, gain), lower)
        if upper < math.inf:
            highest = fmin(q + approach(upper - q, fmax(lower - q, 0), change, gain), upper)
        # outside one limit, the return is no longer than the other limit allows
        lowest, highest = fmin(lowest, fmax(highest, q)), fmax(highest, fmin(lowest, q))
    return fmin(fmax(lowest, down), up), fmin(fmax(highest, down), up)


BRAKING_RATE = 10.0
"""Rate at which a timed step slows down the motion of the joints that its task does not need [1/s]."""


class StepBox:
    """The box of each step, written to memory that a solver reads, from the step before it.

    Args:
        bounds: the limits.
        box: what `box_function` returns for them.
        lower: memory of the lower bounds of q (nq,).
        upper: memory of the upper bounds of q (nq,).
        share: memory of the share of a null-space displacement that a step takes, (1,).
        time: memory of the duration of a step that brakes towards its target (1,); None for one that does not.
        null_space_rate: rate of the motion in the null space [1/s].
        ahead: whether a step starts where the last motion leads, rather than where the joints stop.

    Attributes:
        lower: lower bounds of q (nq,).
        upper: upper bounds of q (nq,).
        ahead: whether a step starts where the last motion leads, rather than at q.
        remembers: whether the box depends on the last step.
        dt: the duration; that given last, where it was a float [s].
        q: memory of where the step begins (nq,).
        last: memory of the displacement of the last step (n,).
        clock: memory of the duration, that of the last step [s], and the share of the last speed that a step keeps.
    """

    def __init__(
        self,
        bounds: Bounds,
        box: Function,
        lower: Array,
        upper: Array,
        *,
        share: Array,
        null_space_rate: float,
        time: Array | None = None,
        ahead: bool = True,
    ) -> None:
        self._bounds, self._robot = bounds, bounds.robot
        self.remembers = bool((bounds.acceleration < math.inf).any())
        self.ahead = self.remembers and ahead
        self._vector = self._robot.nq == self._robot.n
        self._unboxed = bounds.unboxed
        self.q, self.last = np.zeros(self._robot.nq), np.zeros(self._robot.n)
        self.clock = np.array([math.nan, 1.0, 0.0])
        self.dt = float("nan")  # an object of its own: "math.nan is self.dt" would pass for a known duration
        self._share, self._rate = share, null_space_rate
        self._time = np.zeros(1) if time is None else time
        self.lower, self.upper = lower, upper
        self._evaluate = bind(box, [self.q, self.last, self.clock[:2]], [lower, upper])

    def narrow(self, q: Array, dt: float) -> None:
        """Write the box of a step of ``dt`` [s] from ``q`` (nq,).

        Raises:
            ArgumentError: when dt is not a positive number.
        """
        if dt is not self.dt:
            self.lasts(dt)
        self.q[:] = q
        self._evaluate()

    def lasts(self, dt: float) -> None:
        """Take ``dt`` [s] as the duration of the steps to come.

        Raises:
            ArgumentError: when dt is not a positive number.
        """
        if type(dt) is not float or dt != self.dt:
            self.dt = seconds = positive_number("dt", dt)
            self.clock[0] = self._time[0] = seconds
            self.clock[2] = decay = math.exp(-BRAKING_RATE * seconds) if self.ahead else 0.0
            self._share[0] = 1.0 if math.isinf(self._rate) else -math.expm1(-self._rate * seconds) * (1 - decay)
        else:
            self.dt = dt

    def start(self) -> Array:
        """Where the step starts, (nq,): q, or with acceleration limits where the last motion leads (Q1)."""
        if not self.ahead:
            return self.q
        ahead = self.last * (self.clock[2] * self.clock[0] / self.clock[1])
        if self._vector:
            start: Array = np.clip(self.q + ahead, self.lower, self.upper)
            return start
        return self._inside(self._robot.integrate(self.q, ahead))

    def displacement(self, q: Array) -> Array:
        """The displacement from where the step begins to ``q`` (nq,), (n,)."""
        with np.errstate(invalid="ignore"):  # an infinite q, which is refused after the step
            return q - self.q if self._vector else self._robot.difference(self.q, q)

    def braked(self) -> Array:
        """The configuration of the box closest to q, (nq,): the strongest braking."""
        return self._inside(self.q)

    def moved(self, q: Array) -> None:
        """Remember that the step ended at ``q`` (nq,)."""
        if not self.remembers:
            return
        if self._vector:
            np.subtract(q, self.q, self.last)
        else:
            self.last[:] = self._robot.difference(self.q, q)
        self.clock[1] = self.clock[0]

    def rest(self) -> None:
        """Forget the last step: the robot is at rest."""
        self.last[:] = 0

    def moves(self, velocity: Array) -> None:
        """Take a velocity (n,) [rad/s] as that of the last step."""
        self.last[:], self.clock[1] = velocity, 1.0

    def slowed(self, q: Array) -> Array:
        """``q`` (nq,), or the configuration before it at which no ball or free joint exceeds its limits (M7)."""
        if not self._unboxed.size:
            return q
        displacement, base = self._robot.difference(self.q, q), np.zeros(self._robot.n)
        scalar_q, scalar_v = self._robot.scalar_q, self._robot.scalar_v
        base[scalar_v] = self._inside(self.q)[scalar_q] - self.q[scalar_q]
        last = self.last[self._unboxed] * (self.clock[0] / self.clock[1])
        largest_step = self._bounds.velocity[self._unboxed] * self.clock[0]
        change = self._bounds.acceleration[self._unboxed] * self.clock[0] ** 2
        low, high = (np.clip(end, last - change, last + change) for end in (-largest_step, largest_step))
        base[self._unboxed] = stay = np.clip(0.0, low, high)
        share = _share(displacement[self._unboxed] - stay, low - stay, high - stay)
        if share >= 1:
            return q
        return self._inside(self._robot.integrate(self.q, base + share * (displacement - base)))

    def _inside(self, q: Array) -> Array:
        """q clamped to the box."""
        q, scalar = q.copy(), self._robot.scalar_q
        q[scalar] = np.clip(q[scalar], self.lower[scalar], self.upper[scalar])
        return q


def _share(displacement: Array, low: Array, high: Array) -> float:
    """Largest share of the displacement, at most 1, that stays between low <= 0 and high >= 0."""
    margin = np.where(displacement > 0, high, low)
    beyond = (displacement < low) | (displacement > high)
    shares: NDArray[np.float64] = np.divide(margin, displacement, out=np.ones(len(displacement)), where=beyond)
    return float(shares.min(initial=1.0))

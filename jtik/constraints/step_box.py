"""The box in which a step of given length in time must end: position, velocity and acceleration limits in one.

Derived in formulations/limits.md, whose labels the code carries.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from jtik._loop.options import positive
from jtik.constraints.limits import Bounds
from jtik.symbolic import Expression, Function, fmax, fmin, function, sqrt, symbol, vertcat
from jtik.symbolic.compile import bind
from jtik.types import Array


def braking(room: Expression, change: float | Expression) -> Expression:
    """The longest step into ``room`` after which steps that shrink by ``change`` each still end inside (M3).

    Room below 0 is a way back, and a step as long as that is the answer.
    """
    return 2 * room / (1 + sqrt(1 + 2 * fmax(room, 0) / change))


def box_function(bounds: Bounds) -> Function:
    """(q, displacement of the last step (n, 1), (dt, dt of the last step)) -> box (lower, upper) on the next q."""
    robot = bounds.robot
    q, last, clock = symbol("q", robot.nq), symbol("last", robot.n), symbol("clock", 2)
    dt, lower, upper = clock[0], [-math.inf] * robot.nq, [math.inf] * robot.nq
    for i, j in bounds.bounded:
        reach = bounds.velocity[j] * dt
        change = bounds.acceleration[j] * dt**2 if bounds.acceleration[j] < math.inf else None
        low, high = _allowed(last[j] * (dt / clock[1]), reach, change)
        lower[i], upper[i] = _merged(q[i], bounds.lower[i], bounds.upper[i], low, high, change)
    return function("step_box", [q, last, clock], [vertcat(*lower), vertcat(*upper)])


def _allowed(last: Expression, reach: Expression, change: Expression | None) -> tuple[Expression, Expression]:
    """Displacements that (M1) and (M2) allow; where the two do not meet, the one of (M2) nearest to (M1)."""
    if change is None:
        return -reach, reach
    least, most = last - change, last + change
    return fmin(fmax(-reach, least), most), fmin(fmax(reach, least), most)


def _merged(
    q: Expression, lower: float, upper: float, low: Expression, high: Expression, change: Expression | None
) -> tuple[Expression, Expression]:
    """The same with the position limits (M4), as positions; where the two do not meet, the nearest to the limit."""
    down, up = q + low, q + high
    least, most = -math.inf, math.inf
    if lower > -math.inf:
        least = lower if change is None else fmax(q - braking(q - lower, change), lower)
    if upper < math.inf:
        most = upper if change is None else fmin(q + braking(upper - q, change), upper)
    if change is not None:  # outside one limit: the way back is no longer than the other limit allows
        least, most = fmin(least, fmax(most, q)), fmax(most, fmin(least, q))
    return fmin(fmax(least, down), up), fmin(fmax(most, down), up)


class StepBox:
    """The box of each step in turn, written where a solver reads it; it remembers the last step.

    Attributes: lower, upper: the memory written to, (nq,) each.
    """

    def __init__(self, bounds: Bounds, box: Function, lower: Array, upper: Array) -> None:
        self._bounds, self._robot = bounds, bounds.robot
        self._remembers = bool((bounds.acceleration < math.inf).any())
        self._plain = self._robot.nq == self._robot.n
        self._whole = bounds.whole
        self._q, self._last, self._clock = np.zeros(self._robot.nq), np.zeros(self._robot.n), np.ones(2)
        self._dt = self._before = 1.0
        self.lower, self.upper = lower, upper
        self._evaluate = bind(box, [self._q, self._last, self._clock], [lower, upper])

    def narrow(self, q: Array, dt: float) -> None:
        """The box of a step of ``dt`` [s] from ``q`` (nq,).

        Raises:
            ArgumentError: when dt is no positive number.
        """
        if dt != self._dt:
            self._clock[0] = self._dt = positive("dt", dt)
        self._q[:] = q
        self._evaluate()

    def moved(self, q: Array) -> None:
        """The step that was narrowed last ended at ``q`` (nq,)."""
        if not self._remembers:
            return
        if self._plain:
            np.subtract(q, self._q, self._last)
        else:
            self._last[:] = self._robot.difference(self._q, q)
        if self._before != self._dt:
            self._clock[1] = self._before = self._dt

    def rest(self) -> None:
        """Forget the last step: the robot stands."""
        self._last[:] = 0

    def slowed(self, q: Array) -> Array:
        """``q``, or how far the way to it leads where ball or free joints would be too fast (M6), (nq,)."""
        if not self._whole.size:
            return q
        way, base = self._robot.difference(self._q, q), np.zeros(self._robot.n)
        scalar_q, scalar_v = self._robot.scalar_q, self._robot.scalar_v
        base[scalar_v] = self._inside(self._q)[scalar_q] - self._q[scalar_q]
        last = self._last[self._whole] * (self._clock[0] / self._clock[1])
        reach = self._bounds.velocity[self._whole] * self._dt
        change = self._bounds.acceleration[self._whole] * self._dt**2
        low, high = (np.clip(end, last - change, last + change) for end in (-reach, reach))
        base[self._whole] = stay = np.clip(0.0, low, high)
        share = _share(way[self._whole] - stay, low - stay, high - stay)
        if share >= 1:
            return q
        return self._inside(self._robot.integrate(self._q, base + share * (way - base)))

    def _inside(self, q: Array) -> Array:
        """q led into the box."""
        q, scalar = q.copy(), self._robot.scalar_q
        q[scalar] = np.clip(q[scalar], self.lower[scalar], self.upper[scalar])
        return q


def _share(way: Array, low: Array, high: Array) -> float:
    """How much of the way, at most 1, stays between low <= 0 and high >= 0."""
    room = np.where(way > 0, high, low)
    beyond = (way < low) | (way > high)
    shares: NDArray[np.float64] = np.divide(room, way, out=np.ones(len(way)), where=beyond)
    return float(shares.min(initial=1.0))

"""Timing of a path in joint space: as fast as limits of velocity and acceleration allow, from rest to rest.

The path q(u) goes through the samples by monotone cubics (PCHIP): between two samples no joint leaves the range of the
two, so that position limits that hold at the samples hold everywhere. Along it x = (du/dt)^2 is linear in u within each
cell of a grid, so that d2u/dt2 = x'/2 is constant there. Then

    dq/dt   = q'(u) sqrt(x),        d2q/dt2 = q'(u) x'/2 + q''(u) x,

and within a cell the acceleration of a joint is a quadratic in u, whose largest value is known in closed form. The
profile x comes from TOPP-RA (Pham and Pham, 2018) where the package toppra is installed, else from a forward and a
backward pass in which each of the two parts of the acceleration has half of it. Last, time is scaled so that the
largest share of any limit that is used is exactly one: the limits hold at all times, not only on the grid.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from jtik.errors import ArgumentError
from jtik.types import Array

CELLS = 400
"""Smallest number of cells of the grid."""

SPACING = 1e-3
"""Samples nearer than this to the one before are left out: the largest motion of a joint between them [rad] or [m]."""

TINY = 1e-12
"""Smallest first or second derivative along a path that limits its speed."""

PASSES = 10
"""Passes of the smoothing; more of them make no path faster."""


@dataclass(frozen=True, eq=False)
class TimedPath:
    """A path with its profile.

    Attributes:
        grid: the grid (m + 1,), in units of u.
        coefficients: (4, m, n) of the cubic of each cell in u minus its begin, the cube first.
        x: (du/dt)^2 on the grid (m + 1,), 0 at both ends.
        method: "toppra" or "trapezoid".
    """

    grid: Array
    coefficients: Array
    x: Array
    method: str

    @property
    def starts(self) -> Array:
        """Time at which each cell begins, and the end, (m + 1,) [s]."""
        roots = np.sqrt(self.x)
        return np.concatenate([[0.0], np.cumsum(2 * np.diff(self.grid) / (roots[1:] + roots[:-1]))])

    @property
    def duration(self) -> float:
        """Time from the beginning to the end [s]."""
        return float(self.starts[-1])

    def slower(self, factor: float) -> TimedPath:
        """The path in ``factor`` times the time."""
        return TimedPath(self.grid, self.coefficients, self.x / factor**2, self.method)

    def at(self, times: Array) -> tuple[Array, Array, Array]:
        """Positions, velocities and accelerations (k, n) at times (k,) [s]."""
        starts = self.starts
        cell = np.clip(np.searchsorted(starts, times, side="right") - 1, 0, len(self.grid) - 2)
        size = np.diff(self.grid)
        rate = (np.diff(self.x) / (2 * size))[cell]
        begin = np.sqrt(self.x)[cell]
        passed = np.clip(times - starts[cell], 0, None)
        along = np.clip(begin * passed + rate * passed**2 / 2, 0, size[cell])[:, None]
        speed = np.clip(begin + rate * passed, 0, None)[:, None]
        a, b, c, d = (self.coefficients[i, cell] for i in range(4))
        q = ((a * along + b) * along + c) * along + d
        first = (3 * a * along + 2 * b) * along + c
        second = 6 * a * along + 2 * b
        return q, first * speed, first * rate[:, None] + second * speed**2

    def used(self, velocity: Array, acceleration: Array) -> float:
        """The factor by which time must be stretched so that limits (n,) just hold; below 1 there is time to spare."""
        size = np.diff(self.grid)[:, None]
        a, b, c, _ = self.coefficients
        slope = np.diff(self.x)[:, None] / size
        begin = self.x[:-1, None]
        fastest = np.sqrt(np.maximum(self.x[1:], self.x[:-1]))[:, None]
        speeds = _largest(3 * a, 2 * b, c, size) * fastest
        # q' x'/2 + q'' x, with q' = 3 a s^2 + 2 b s + c, q'' = 6 a s + 2 b, x = begin + slope s
        quadratic = 3 * a * slope / 2 + 6 * a * slope
        linear = b * slope + 6 * a * begin + 2 * b * slope
        constant = c * slope / 2 + 2 * b * begin
        accelerations = _largest(quadratic, linear, constant, size)
        ratios = [float((speeds / velocity).max()), float(np.sqrt((accelerations / acceleration).max()))]
        return max(ratios)


def timed_path(waypoints: Array, velocity: Array, acceleration: Array, *, method: str | None = None) -> TimedPath:
    """The path through configurations in the shortest time, from rest to rest.

    Args:
        waypoints: configurations of revolute and prismatic joints, (k, n).
        velocity: largest speeds (n,) [rad/s] or [m/s], infinite for none.
        acceleration: largest accelerations (n,) [rad/s^2] or [m/s^2], finite.
        method: "toppra" or "trapezoid"; by default the faster of both; the second where toppra is not installed.

    Raises:
        ArgumentError: when no joint moves, or the method cannot be used.
    """
    kept = thinned(waypoints)
    if len(kept) < 2:
        raise ArgumentError("attempt", "one in which no joint moves", "an attempt in which the robot moves")
    if method not in (None, "toppra", "trapezoid"):
        raise ArgumentError("method", repr(method), "'toppra', 'trapezoid' or None for the faster of both")
    grid, coefficients = _cells(kept)
    profiles: dict[str, Array] = {}
    if method != "trapezoid":
        found = _toppra(grid, coefficients, velocity, acceleration)
        if found is None and method == "toppra":
            raise ArgumentError("method", "'toppra', which is not installed or finds no profile", "'trapezoid'")
        profiles |= {} if found is None else {"toppra": found}
    if method != "toppra":
        profiles["trapezoid"] = _passes(grid, coefficients, velocity, acceleration)
    paths = [TimedPath(grid, coefficients, x, name) for name, x in profiles.items()]
    paths = [path.slower(path.used(velocity, acceleration) * (1 + 1e-9)) for path in paths]
    return min(paths, key=lambda path: path.duration)


def smoothed(waypoints: Array, tolerance: float) -> Array:
    """The waypoints, smoothed within a tolerance; the first and the last stay.

    Each pass takes the mean of a waypoint and its neighbours, and moves it back to where no joint is farther from the
    given waypoint than the tolerance. Every joint stays within the range of its neighbours, so that position limits
    that hold at the waypoints go on to hold.

    Args:
        waypoints: configurations (k, n).
        tolerance: largest change of any joint [rad] or [m].
    """
    found = waypoints.copy()
    for _ in range(PASSES if len(waypoints) > 2 else 0):
        for _ in range(2):
            found[1:-1] = (found[:-2] + found[1:-1] + found[2:]) / 3
        found = waypoints + np.clip(found - waypoints, -tolerance, tolerance)
    return found


def thinned(waypoints: Array) -> Array:
    """The waypoints without those that are hardly away from the one before; the last one always stays."""
    kept = [0]
    for i in range(1, len(waypoints)):
        if np.abs(waypoints[i] - waypoints[kept[-1]]).max(initial=0.0) >= SPACING:
            kept.append(i)
    last = len(waypoints) - 1
    if kept[-1] != last and (waypoints[kept[-1]] != waypoints[last]).any():
        kept[-1:] = [last] if len(kept) > 1 else [kept[-1], last]
    return waypoints[kept]


def _cells(waypoints: Array) -> tuple[Array, Array]:
    """The grid and the cubics of a path, which is parametrised by the length of its chords."""
    from scipy.interpolate import PchipInterpolator

    chords = np.linalg.norm(np.diff(waypoints, axis=0), axis=1)
    u = np.concatenate([[0.0], np.cumsum(chords)])
    found = PchipInterpolator(u, waypoints, axis=0).c
    parts = max(2, -(-CELLS // len(chords)))
    begin = np.arange(parts) / parts * chords[:, None]  # (segments, parts)
    a, b, c, d = (np.repeat(each[:, None], parts, axis=1) for each in found)
    s = begin[:, :, None]
    moved = [a, 3 * a * s + b, (3 * a * s + 2 * b) * s + c, ((a * s + b) * s + c) * s + d]
    grid = np.append((u[:-1, None] + begin).ravel(), u[-1])
    return grid, np.array([each.reshape(len(grid) - 1, -1) for each in moved])


def _passes(grid: Array, coefficients: Array, velocity: Array, acceleration: Array) -> Array:
    """A profile by a forward and a backward pass: a trapezoid whose height follows the path."""
    size = np.diff(grid)
    a, b, c, _ = coefficients
    first = np.maximum(_largest(3 * a, 2 * b, c, size[:, None]), TINY)
    second = np.maximum(_largest(0 * a, 6 * a, 2 * b, size[:, None]), TINY)
    highest = np.minimum((velocity / first) ** 2, acceleration / 2 / second).min(axis=1)
    rate = (acceleration / 2 / first).min(axis=1)
    x = np.concatenate([[0.0], np.minimum(highest[1:], highest[:-1]), [0.0]])
    for i in range(len(size)):
        x[i + 1] = min(x[i + 1], x[i] + 2 * rate[i] * size[i])
    for i in reversed(range(len(size))):
        x[i] = min(x[i], x[i + 1] + 2 * rate[i] * size[i])
    return x


def _toppra(grid: Array, coefficients: Array, velocity: Array, acceleration: Array) -> Array | None:
    """The profile of TOPP-RA; None where toppra is not installed or finds none."""
    try:
        import toppra
        from toppra.algorithm import TOPPRA
        from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint
        from toppra.interpolator import AbstractGeometricPath
    except ImportError:
        return None

    class Path(AbstractGeometricPath):  # type: ignore[misc]
        """The cubics as toppra reads a path."""

        def __call__(self, position: Any, order: int = 0) -> Array:
            at = np.atleast_1d(position)
            cell = np.clip(np.searchsorted(grid, at, side="right") - 1, 0, len(grid) - 2)
            s = (at - grid[cell])[:, None]
            a, b, c, d = (coefficients[i, cell] for i in range(4))
            values = [((a * s + b) * s + c) * s + d, (3 * a * s + 2 * b) * s + c, 6 * a * s + 2 * b][order]
            if order == 2:  # where two cells meet, the larger of both
                before, ended = np.maximum(cell - 1, 0), (s == 0) & (cell[:, None] > 0)
                length = (grid[before + 1] - grid[before])[:, None]
                left = 6 * coefficients[0, before] * length + 2 * coefficients[1, before]
                values = np.where(ended & (np.abs(left) > np.abs(values)), left, values)
            chosen: Array = values[0] if np.ndim(position) == 0 else values
            return chosen

        @property
        def dof(self) -> int:
            return int(coefficients.shape[2])

        @property
        def path_interval(self) -> Array:
            return np.array([grid[0], grid[-1]])

    toppra.setup_logging("CRITICAL")
    bounded = np.minimum(velocity, 1e4)
    constraints = [
        JointVelocityConstraint(np.stack([-bounded, bounded], axis=1)),
        JointAccelerationConstraint(np.stack([-acceleration, acceleration], axis=1)),
    ]
    found = TOPPRA(constraints, Path(), gridpoints=grid, solver_wrapper="seidel").compute_parameterization(0.0, 0.0)
    rates = found[1]
    if rates is None or not np.isfinite(rates).all() or (rates[1:-1] <= 0).any():
        return None
    x: Array = np.asarray(rates, dtype=np.float64) ** 2
    x[0] = x[-1] = 0.0
    return x


def _largest(quadratic: Array, linear: Array, constant: Array, size: Array) -> Array:
    """Largest absolute value of quadratic s^2 + linear s + constant for s in [0, size], elementwise."""
    with np.errstate(divide="ignore", invalid="ignore"):
        vertex = np.where(quadratic != 0, -linear / (2 * quadratic), 0.0)
    inside = np.clip(np.nan_to_num(vertex), 0, size)
    values = [np.abs((quadratic * s + linear) * s + constant) for s in (0 * size, inside, size + 0 * inside)]
    largest: Array = np.maximum.reduce(np.broadcast_arrays(*values))
    return largest

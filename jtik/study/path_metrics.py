"""Path metrics: figures from the iterations of a solve, or from the configurations along a path."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from jtik.result.solution import Trace
from jtik.robot import Robot
from jtik.types import Array

ROUNDING = 1e-12
"""Relative rise of V that is attributed to rounding."""

NAN = float("nan")


def last_attempt(trace: Trace) -> slice:
    """Rows of the last attempt; all rows without restarts."""
    attempt = trace.figures.get("attempt")
    if attempt is None or not len(attempt):
        return slice(0, len(trace))
    return slice(int(np.argmax(attempt == attempt[-1])), len(trace))


def iterates(trace: Trace) -> Array:
    """Configurations of the last attempt, from its start to the answer, (k, nq)."""
    return trace.q[last_attempt(trace).start :]


def monotone(trace: Trace, V_end: float, tolerance: float) -> float:
    """1 if V never rose at an accepted step of the last attempt, 0 if it did, NaN without a step.

    Args:
        trace: the iterations.
        V_end: V at the answer.
        tolerance: error up to which a configuration is on target [m], [rad]. Rises of V on target, while H is
            minimised, are ignored.
    """
    rows = last_attempt(trace)
    own = trace.figures.get("V")
    V = np.append(own[rows], V_end) if own is not None else trace.error[rows.start :] ** 2 / 2
    if len(V) < 2:
        return NAN
    accepted = _accepted(trace)[rows]
    off_target = trace.error[rows.start + 1 :] > tolerance
    rises = accepted & off_target & ~(V[1:] <= V[:-1] * (1 + ROUNDING))
    return 0.0 if rises.any() else 1.0


def leakage(trace: Trace) -> float:
    """Largest ``|J nu| / |nu|`` of an accepted null-space step nu of the last attempt; NaN without one."""
    rows, own = last_attempt(trace), trace.figures.get("leakage")
    if own is None:
        return NAN
    figures = own[rows][_accepted(trace)[rows]]
    figures = figures[np.isfinite(figures)]
    return float(figures.max()) if len(figures) else NAN


def path_length(robot: Robot, q: Array) -> float:
    """Sum of the joint-space distances between consecutive configurations (k, nq) [rad] and [m]."""
    return float(np.linalg.norm(displacements(robot, q), axis=1).sum())


def smoothness(robot: Robot, q: Array, dt: float | None) -> float:
    """Root mean square acceleration along a path (k, nq) with time step dt [rad/s^2]; NaN below 3 configurations."""
    if dt is None or len(q) < 3:
        return NAN
    accelerations = np.diff(displacements(robot, q), axis=0) / dt**2
    return float(np.sqrt((accelerations**2).sum(axis=1).mean()))


def drift(robot: Robot, q: Array) -> float:
    """Joint-space distance between the first and the last configuration of a closed path [rad] and [m]."""
    return float(np.linalg.norm(displacements(robot, q[[0, -1]])))


def _accepted(trace: Trace) -> Any:
    """Which steps were accepted; where the trace has no such figure, the steps that changed q."""
    own = trace.figures.get("accepted")
    moved = (trace.q[1:] != trace.q[:-1]).any(axis=1)
    return moved if own is None else np.where(np.isfinite(own), own == 1.0, moved)


def displacements(robot: Robot, q: Array) -> Array:
    """Displacements (k - 1, n) between configurations (k, nq)."""
    if robot.nq == robot.n:
        return np.diff(q, axis=0)
    return np.array([robot.difference(start, end) for start, end in pairwise(q)]).reshape(-1, robot.n)

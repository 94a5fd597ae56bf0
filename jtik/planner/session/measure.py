"""Figures of the arm, ten times a second: distances, the report of the problem, and what it does in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from typing import Any

import numpy as np

from jtik.result import Status
from jtik.result.report import Report
from jtik.robot import Robot
from jtik.symbolic import Expression, fmin, function, symbol, vertcat
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array

ABSENT = 1e8
"""Distance from which on an obstacle counts as absent [m]."""

FALLS = 1e-4
"""Relative gradient of the error above which the arm still comes nearer to the target."""


class Gauge:
    """Distances of the joints and of the links of a robot to the obstacles.

    Args:
        robot: the robot.
        measures: two obstacle criteria with the same slots, which measure the joints and the links.
    """

    def __init__(self, robot: Robot, measures: Sequence[Any]) -> None:
        q, first = symbol("q", robot.nq), measures[0].slots(robot).parameters(())
        self._values: dict[str, Array] = dict(first)
        symbols = {name: symbol(name, *(*value.shape, 1, 1)[:2]) for name, value in first.items()}
        kinematics = robot.at(q)
        columns = []
        self._names: list[str] = []
        self._sizes = []
        for measure in measures:
            bodies = measure.distances(kinematics, symbols)
            columns += [minimum(distances) for distances in bodies]
            self._names += measure.body_names(robot)
            self._sizes.append(len(bodies))
        self._measure = CompiledFunction(function("gauge", [q, *symbols.values()], [vertcat(*columns)]))

    def fill(self, values: Mapping[str, Array]) -> None:
        """Set the obstacles, as `jtik.geometry.Slots.parameters` gives them."""
        self._values = dict(values)

    def distances(self, q: Array) -> Array:
        """Distance of each body to its nearest obstacle [m], (bodies,); infinite without an obstacle.

        Args:
            q: configuration (nq,).
        """
        found: Array = self._measure(q, *self._values.values())[0][:, 0]
        return np.where(found < ABSENT, found, np.inf)

    def clearance(self, distances: Array) -> dict[str, float]:
        """The smallest of these distances, of joints and of links [m]; none where it is infinite."""
        joints = self._sizes[0]
        smallest = {"joints": distances[:joints].min(initial=np.inf), "links": distances[joints:].min(initial=np.inf)}
        return {name: float(value) for name, value in smallest.items() if value < np.inf}

    def nearer(self, distances: Array, safe: float) -> tuple[str, ...]:
        """Names of the bodies that are nearer than ``safe`` [m]."""
        return tuple(name for name, distance in zip(self._names, distances, strict=True) if distance < safe)


def figures(report: Report) -> dict[str, Any]:
    """The figures of `StatusLine` that a report has."""
    values = {name: float(value) for name, value in report.values.items()}
    found: dict[str, Any] = {
        "error": float(np.linalg.norm(report.error)),
        "V": 0.5 * float(report.residual @ report.residual),
        "H": sum(values.values()),
        "criteria": values,
        "active_limits": report.active_limits,
    }
    if report.finite:
        singular = np.linalg.svd(report.weighted, compute_uv=False)
        rank = int((singular > report.rank_threshold * np.linalg.norm(report.weighted)).sum())
        found["manipulability"] = float(np.prod(singular)) if len(singular) else 0.0
        found["null_space"] = report.weighted.shape[1] - rank
    return found


def words(report: Report, *, moving: bool, guided: bool) -> str:
    """What the arm does, as a sentence.

    Args:
        report: the report of the configuration, for the target as it is.
        moving: whether the arm has moved since the last time.
        guided: whether the target moves.
    """
    if not report.finite:
        return Status.NOT_FINITE.value
    if guided:
        return "follows the target"
    if report.reached:
        return "on target; the criterion still falls" if moving else "at rest on the target"
    of_all, of_free = report.relative_gradient
    if moving and of_free > FALLS:
        return "on the way to the target"
    if report.active_clearances:
        return Status.BLOCKED.value
    if of_free > FALLS:
        return Status.STALLED.value
    return Status.LIMITS.value if of_all > FALLS else Status.LOCAL_MINIMUM.value


def minimum(distances: Sequence[Expression]) -> Expression:
    """The smallest of several expressions."""
    return reduce(fmin, distances)

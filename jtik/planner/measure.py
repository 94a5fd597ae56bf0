"""Figures of the arm, ten times a second: distances, the report of the problem, and what it does in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jtik.result import Status
from jtik.result.report import Report
from jtik.robot import Robot
from jtik.symbolic import function, symbol, vertcat
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array

FALLS = 1e-4
"""Relative gradient of the error above which the arm still comes nearer to the target."""


class Gauge:
    """Distances of the joints and of the links of a robot to the obstacles, those in a clearance's own places.

    Args:
        robot: the robot.
        measure: a criterion that measures distances of joints and links.
    """

    def __init__(self, robot: Robot, measure: Any) -> None:
        self._names: list[str] = list(measure.body_names(robot))
        self._joints = len(robot.moving_frames)
        q, first = symbol("q", robot.nq), dict(measure.parameters(robot))
        self._values = {name: np.array(value, dtype=float) for name, value in first.items()}
        symbols = {name: symbol(name, *(*value.shape, 1, 1)[:2]) for name, value in self._values.items()}
        distances = measure.distances(robot.at(q), symbols)
        self._slots = len(distances[0]) if distances else 0
        flat = [each for of_body in distances for each in of_body]
        self._measure = CompiledFunction(function("gauge", [q, *symbols.values()], [vertcat(*flat)]))
        self._present = np.ones(self._slots, dtype=bool)

    def fill(self, values: Mapping[str, Array]) -> None:
        """Set the obstacles."""
        self._values.update({name: value for name, value in values.items() if name in self._values})
        self._present = values["radii"] > 0

    def distances(self, q: Array) -> Array:
        """Distance of each body to its nearest obstacle [m], (bodies,); infinite without an obstacle.

        Args:
            q: configuration (nq,).
        """
        if not self._present.any() or not self._names:
            return np.full(len(self._names), np.inf)
        flat = self._measure(q, *self._values.values())[0]
        found: Array = flat.reshape(-1, self._slots)[:, self._present].min(axis=1)
        return found

    def clearance(self, distances: Array) -> dict[str, float]:
        """The smallest of these distances, of joints and of links [m]; empty without an obstacle."""
        if not self._present.any():
            return {}
        parts = {"joints": distances[: self._joints], "links": distances[self._joints :]}
        return {name: float(part.min()) for name, part in parts.items() if part.size}

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
    if moving:
        return "on the way to the target"
    if report.active_clearances:
        return Status.BLOCKED.value
    of_all, of_free = report.relative_gradient
    if of_free > FALLS:
        return Status.STALLED.value
    return Status.LIMITS.value if of_all > FALLS else Status.LOCAL_MINIMUM.value

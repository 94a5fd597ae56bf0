"""The table of attempts as the page shows it: measures, the path of the end effector, postures along it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from jtik.errors import JtikError
from jtik.planner.attempts.attempt import Attempt
from jtik.planner.attempts.history import History
from jtik.planner.session.arm import Arm
from jtik.planner.session.frames import plain
from jtik.planner.session.targets import guided_frame
from jtik.types import Array

POINTS, POSTURES = 240, 7
"""Largest number of points of a path, and of postures along it."""

Row = Mapping[str, Any]


class AttemptRows:
    """Rows of the table of attempts. What is computed of an attempt is kept as long as the attempt is in the history.

    Args:
        arm: the robot.
        measure: gives the measures of an attempt by name.
    """

    def __init__(self, arm: Arm, measure: Callable[[Attempt], Mapping[str, Any]]) -> None:
        self._arm = Arm(arm.robot, arm.tip)  # of its own: compiled functions are of one thread
        self._measure = measure
        self._kept: dict[str, tuple[Attempt, dict[str, Any]]] = {}

    def of(self, history: History) -> Iterator[tuple[Row, ...]]:
        """The rows, again after each attempt that had to be measured."""
        self._kept = {
            each.name: self._kept[each.name]
            for each in history
            if each.name in self._kept and self._kept[each.name][0] is each
        }
        yield self._rows(history)
        for attempt in history:
            if attempt.name not in self._kept:
                self._kept[attempt.name] = (attempt, self._computed(attempt))
                yield self._rows(history)

    def _rows(self, history: History) -> tuple[Row, ...]:
        rows = []
        for attempt in history:
            _, computed = self._kept.get(attempt.name, (attempt, {}))
            rows.append(
                {
                    "name": attempt.name,
                    "duration": attempt.duration,
                    "strategy": attempt.strategy,
                    "criteria": list(attempt.criteria),
                    "parent": attempt.parent,
                    "branched_at": attempt.branched_at,
                    "chosen": attempt.name == history.chosen,
                    **computed,
                }
            )
        return tuple(rows)

    def _computed(self, attempt: Attempt) -> dict[str, Any]:
        try:
            measures: dict[str, Any] = plain(dict(self._measure(attempt)))
        except JtikError as error:  # an attempt of another robot, from a plan that was loaded
            measures = {"error": str(error)}
        tip = self._arm.robot.frame_names.index(guided_frame(attempt.settings, self._arm))
        path = [self._arm.poses(q)[tip, :3] for q in _spread(attempt.configurations, POINTS)]
        postures = [self._links(q) for q in _spread(attempt.configurations, POSTURES)]
        return {"measures": measures, "path": np.round(path, 5).tolist(), "postures": postures}

    def _links(self, q: Array) -> list[Any]:
        """Both ends of each link of the skeleton (links, 2, 3) [m]."""
        poses, robot = self._arm.poses(q), self._arm.robot
        index = robot.frame_names.index
        pairs = [[poses[index(inner), :3], poses[index(outer), :3]] for inner, outer in robot.segments]
        links: list[Any] = np.round(pairs, 5).tolist()
        return links


def _spread(rows: Array, most: int) -> Array:
    """At most so many rows, evenly, the first and the last among them."""
    chosen = np.unique(np.linspace(0, len(rows) - 1, min(most, len(rows))).round().astype(int))
    spread: Array = rows[chosen]
    return spread

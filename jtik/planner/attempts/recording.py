"""An attempt while it is recorded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from jtik.planner.attempts.attempt import MOST_SAMPLES, Attempt, SceneChange
from jtik.planner.files.plain import plain_mapping
from jtik.types import Array

FIRST_ROWS = 4096
"""Number of samples for which there is room at first; the room doubles."""


class Recording:
    """An attempt while it is recorded: one sample a step, and the changes of the scene.

    Args:
        beginning: an attempt with the first sample, or with the samples of the attempt from which it branches; the
            first sample that is added follows its last one after ``dt``.

    Attributes:
        beginning: the attempt that was given.
    """

    def __init__(self, beginning: Attempt) -> None:
        self.beginning = beginning
        self._width = beginning.configurations.shape[1]
        self._rows = np.empty((FIRST_ROWS, 1 + self._width + beginning.targets.shape[1]))
        self._count = 0
        self._scenes: list[SceneChange] = []
        self._offset: float | None = None

    def __len__(self) -> int:
        return len(self.beginning) + self._count

    def add(self, time: float, q: Array, target: Array) -> None:
        """Add a sample.

        Args:
            time: time of the clock [s]. A sample that is not after the one before replaces it.
            q: configuration (nq,) [rad] and [m].
            target: position (2,) or (3,) [m], or position and quaternion (7,).
        """
        if self._offset is None:
            self._offset = self.beginning.duration + self.beginning.dt - time
        own = time + self._offset
        if self._count and own <= self._rows[self._count - 1, 0]:
            own = self._rows[self._count - 1, 0]
        elif len(self) < MOST_SAMPLES:
            if self._count == len(self._rows):
                self._rows = np.concatenate([self._rows, np.empty_like(self._rows)])
            self._count += 1
        else:
            return
        row = self._rows[self._count - 1]
        row[0], row[1 : 1 + self._width], row[1 + self._width :] = own, q, target

    def change_scene(self, scene: Mapping[str, Any]) -> None:
        """Note that the obstacles are others from the last sample on: a dict of `jtik.Scene.to_dict`."""
        time = float(self._rows[self._count - 1, 0]) if self._count else self.beginning.duration
        if self._scenes and self._scenes[-1][0] == time:
            self._scenes.pop()
        self._scenes.append((time, plain_mapping("scene", scene)))

    def attempt(self) -> Attempt:
        """What has been recorded so far."""
        first, rows = self.beginning, self._rows[: self._count]
        return replace(
            first,
            times=np.concatenate([first.times, rows[:, 0]]),
            configurations=np.concatenate([first.configurations, rows[:, 1 : 1 + self._width]]),
            targets=np.concatenate([first.targets, rows[:, 1 + self._width :]]),
            scenes=_merged(first.scenes, self._scenes),
        )


def _merged(before: tuple[SceneChange, ...], after: list[SceneChange]) -> tuple[SceneChange, ...]:
    """The changes in order; of two at one time the later one."""
    if after:
        before = tuple(change for change in before if change[0] < after[0][0])
        if not before and after[0][0] > 0:  # the scene was empty until then
            before = ((0.0, {}),)
    return (*before, *after)

"""An attempt while it is recorded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from jtik.planner.attempt import MOST_SAMPLES, Attempt, SceneChange
from jtik.planner.plain import plain_mapping
from jtik.types import Array


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
        self._times: list[float] = []
        self._configurations: list[Array] = []
        self._targets: list[Array] = []
        self._scenes: list[SceneChange] = []
        self._offset: float | None = None

    def __len__(self) -> int:
        return len(self.beginning) + len(self._times)

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
        if self._times and own <= self._times[-1]:
            self._configurations[-1], self._targets[-1] = np.array(q), np.array(target)
        elif len(self) < MOST_SAMPLES:
            self._times.append(own)
            self._configurations.append(np.array(q, dtype=np.float64))
            self._targets.append(np.array(target, dtype=np.float64))

    def change_scene(self, scene: Mapping[str, Any]) -> None:
        """Note that the obstacles are others from the last sample on: a dict of `jtik.Scene.to_dict`."""
        time = self._times[-1] if self._times else self.beginning.duration
        if self._scenes and self._scenes[-1][0] == time:
            self._scenes.pop()
        self._scenes.append((time, plain_mapping("scene", scene)))

    def attempt(self) -> Attempt:
        """What has been recorded so far."""
        first = self.beginning
        if not self._times:
            return replace(first, scenes=_merged(first.scenes, self._scenes))
        return replace(
            first,
            times=np.concatenate([first.times, self._times]),
            configurations=np.concatenate([first.configurations, self._configurations]),
            targets=np.concatenate([first.targets, self._targets]),
            scenes=_merged(first.scenes, self._scenes),
        )


def _merged(before: tuple[SceneChange, ...], after: list[SceneChange]) -> tuple[SceneChange, ...]:
    """The changes in order; of two at one time the later one."""
    if after:
        before = tuple(change for change in before if change[0] < after[0][0])
        if not before and after[0][0] > 0:  # the scene was empty until then
            before = ((0.0, {}),)
    return (*before, *after)

"""Configurations from which a search starts again."""

from __future__ import annotations

import math

import numpy as np

from jtik.robot import Robot
from jtik.types import Array


class RestartConfigurations:
    """Restart configurations: uniform within the limits, the same for the same seed.

    A length without limits, such as the position of a free base, is drawn within 1 m of where the search began.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        scalar = [joint for joint in robot.independent_joints if joint.type.is_scalar]
        unlimited = np.zeros(robot.nq, dtype=bool)
        for joint in robot.independent_joints:
            where = robot.q_slice(joint.name)
            if joint in scalar:
                unbounded = not (math.isfinite(joint.lower) and math.isfinite(joint.upper))
                unlimited[where] = unbounded and not joint.type.rotational[0]
            else:
                unlimited[where.start : where.start + joint.type.nq - 4] = True
        self._unlimited = unlimited if unlimited.any() else None
        self._drawn: dict[int, Array] = {}

    @property
    def depend_on_start(self) -> bool:
        """Whether they depend on where a search began."""
        return self._unlimited is not None

    def table(self, seed: int, count: int, start: Array) -> Array:
        """The first ``count`` restarts of a search that began at ``start`` (nq,); (count, nq), contiguous."""
        drawn = self._drawn.get(seed)
        if drawn is None or len(drawn) < count:
            generator = np.random.default_rng(seed)
            rows = [self._robot.random_configuration(generator) for _ in range(count)]
            drawn = self._drawn[seed] = np.array(rows).reshape(count, self._robot.nq)
        if self._unlimited is None:
            return drawn if len(drawn) == count else drawn[:count]
        return np.where(self._unlimited, drawn[:count] + start, drawn[:count])

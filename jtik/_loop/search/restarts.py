"""Configurations from which a search starts again."""

from __future__ import annotations

import math

import numpy as np

from jtik._loop.search.jump import Jump
from jtik.robot import JointType, Robot
from jtik.types import Array

BLOCK = 32
"""Number of restarts that are drawn at once. Only the first block of the latest seed is kept."""

REACH = 1.0
"""A length without limits is drawn within this distance of where the search began [m]."""


class RestartConfigurations:
    """Restart configurations: uniform within the limits, the same for the same seed, drawn when they are needed.

    A length without one of its limits, such as the position of a free base, is drawn within `REACH` of where the
    search began, and within the limit that it has.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        unlimited = np.zeros(robot.nq, dtype=bool)
        for joint in robot.independent_joints:
            where = robot.q_slice(joint.name)
            if joint.type is JointType.PRISMATIC:
                i = where.start
                unlimited[i] = not (math.isfinite(robot.lower[i]) and math.isfinite(robot.upper[i]))
            elif not joint.type.is_scalar:
                unlimited[where.start : where.start + joint.type.nq - 4] = True
        self._unlimited = unlimited if unlimited.any() else None
        self._first: tuple[int, Array] = (-1, np.zeros((0, robot.nq)))
        self._drawing: tuple[int, int, np.random.Generator] | None = None

    @property
    def depend_on_start(self) -> bool:
        """Whether they depend on where a search began."""
        return self._unlimited is not None

    def block(self, seed: int, number: int, start: Array, jump: Jump | None = None) -> tuple[Array, int, int]:
        """The block that contains restart ``number``, 1 for the first.

        Args:
            seed: the seed.
            number: the restart.
            start: where the search began, (nq,).
            jump: the jump limit within which to draw; None for the limits of the robot.

        Returns:
            The configurations, (BLOCK, nq), contiguous; and the numbers of the first and the last.
        """
        index = (number - 1) // BLOCK
        first = 1 + index * BLOCK
        drawn = self._block(seed, index)
        if jump is not None:
            drawn = jump.drawn(drawn, np.random.default_rng([seed, index]))
        elif self._unlimited is not None:
            drawn = self._about(start, drawn)
        return drawn, first, first + BLOCK - 1

    def _block(self, seed: int, index: int) -> Array:
        """A block of configurations within the limits of the robot."""
        if index == 0:
            if self._first[0] != seed:
                generator = np.random.default_rng(seed)
                self._first = seed, self._draw(generator)
                self._drawing = seed, 1, generator
            return self._first[1]
        if self._drawing is None or self._drawing[0] != seed or self._drawing[1] > index:
            self._drawing = seed, 0, np.random.default_rng(seed)
        _, following, generator = self._drawing
        self._drawing = None  # where Ctrl-C ends this, the generator is used no more
        for _ in range(following, index + 1):
            drawn = self._draw(generator)
        self._drawing = seed, index + 1, generator
        return drawn

    def _draw(self, generator: np.random.Generator) -> Array:
        rows = [self._robot.random_configuration(generator) for _ in range(BLOCK)]
        return np.array(rows).reshape(BLOCK, self._robot.nq)

    def _about(self, start: Array, drawn: Array) -> Array:
        """Configurations whose lengths without limits are about ``start``; beyond their one limit, mirrored at it."""
        lower, upper = self._robot.lower, self._robot.upper
        rows = drawn.copy()
        for i in np.flatnonzero(self._unlimited if self._unlimited is not None else []):
            if math.isfinite(lower[i]):
                rows[:, i] = lower[i] + np.abs(start[i] + drawn[:, i] - (lower[i] + REACH) - lower[i])
            elif math.isfinite(upper[i]):
                rows[:, i] = upper[i] - np.abs(upper[i] - (start[i] + drawn[:, i] - (upper[i] - REACH)))
            else:
                rows[:, i] = start[i] + drawn[:, i]
        return rows

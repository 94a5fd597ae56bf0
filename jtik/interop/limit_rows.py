"""Limits of other libraries as rows on the displacement of a jtik robot: what mink's and pink's have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from jtik.errors import ArgumentError
from jtik.qp import Elastic, Rows
from jtik.robot import Robot
from jtik.strategy import LocalModel
from jtik.types import Array


class Inequality(NamedTuple):
    """G dq <= h: (k, n) and (k,)."""

    G: Array
    h: Array


class LimitRows(ABC):
    """A limit of another library on the displacement dq of a jtik robot, made by that library's ``limit_rows``."""

    library: str

    def __init__(self, robot: Robot, dt: float) -> None:
        if not 0 < dt < np.inf:
            raise ArgumentError("dt", dt, "a positive time [s]")
        self._robot = robot

    def __call__(self, q: Any) -> Inequality:
        """The rows at q (nq,) that say something: those without a bound are left out."""
        found = self._all(self._robot.configuration(q))
        bounded = np.isfinite(found.h)
        return Inequality(found.G[bounded], found.h[bounded])

    def rows(self, model: LocalModel, name: str | None = None, *, elastic: Elastic | None = None) -> Rows:
        """Rows for the program of a strategy, evaluated by the library in the middle of the step.

        A limit of theirs may ask for a motion, h < 0, and two of them for motions that contradict each other: then the
        program has no answer and the solve ends as `jtik.Status.UNSOLVED`. With ``elastic`` they give way.
        """
        k, n, name = len(self._all(self._robot.neutral).h), model.robot.n, name or f"{self.library} limit"
        G, h = model.compute(name, self._padded, [model.here.q], [(k, n), (k, 1)])
        return Rows(name, G, -np.inf + 0 * h, h, elastic)

    def _padded(self, arguments: Sequence[Array]) -> list[Array]:
        """All rows, always as many, those without a bound as 0 dq <= 1."""
        G, h = self._all(arguments[0])
        bounded = np.isfinite(h)
        return [np.where(bounded[:, None], G, 0.0), np.where(bounded, h, 1.0)]

    @abstractmethod
    def _all(self, q: Array) -> Inequality:
        """The rows at q (nq,)."""

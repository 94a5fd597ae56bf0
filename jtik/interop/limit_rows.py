"""Limits of mink and pink as rows on the displacement of a jtik robot: the part that both share."""

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
    """The inequality G dq <= h.

    Attributes:
        G: matrix (k, n).
        h: bounds (k,).
    """

    G: Array
    h: Array


class LimitRows(ABC):
    """A limit of another library on the displacement dq of a jtik robot, made by that module's ``limit_rows``.

    Args:
        robot: the robot.
        dt: duration of a step [s].

    Raises:
        ArgumentError: when ``dt`` is not positive.
    """

    library: str

    def __init__(self, robot: Robot, dt: float) -> None:
        if not 0 < dt < np.inf:
            raise ArgumentError("dt", dt, "a positive time [s]")
        self._robot = robot

    def __call__(self, q: Any) -> Inequality:
        """The rows at q (nq,) that have a bound."""
        found = self._all(self._robot.configuration(q))
        bounded = np.isfinite(found.h)
        return Inequality(found.G[bounded], found.h[bounded])

    def rows(self, model: LocalModel, name: str | None = None, *, elastic: Elastic | None = None) -> Rows:
        """Rows for the quadratic program of a strategy; the library evaluates them during the step.

        A limit of mink or pink may require a motion, h < 0, and two limits may require contradicting motions. The
        quadratic program then has no solution, and the solve ends with `jtik.Status.UNSOLVED`. With ``elastic`` the
        limits are relaxed.

        Args:
            model: the local model of the step.
            name: name of the rows; "mink limit" or "pink limit" by default.
            elastic: the penalty at which the rows may be violated; None for hard rows.
        """
        k, n, name = len(self._all(self._robot.neutral).h), model.robot.n, name or f"{self.library} limit"
        G, h = model.compute(name, self._padded, [model.here.q], [(k, n), (k, 1)])
        return Rows(name, G, -np.inf + 0 * h, h, elastic)

    def _padded(self, arguments: Sequence[Array]) -> list[Array]:
        """All rows, with a constant number of them: rows without a bound become 0 dq <= 1."""
        G, h = self._all(arguments[0])
        bounded = np.isfinite(h)
        return [np.where(bounded[:, None], G, 0.0), np.where(bounded, h, 1.0)]

    @abstractmethod
    def _all(self, q: Array) -> Inequality:
        """All rows at q (nq,)."""

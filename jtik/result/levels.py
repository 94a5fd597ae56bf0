"""Levels of priority at one configuration: which are reached, and whether the others are as near as those allow."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jtik.result.length import length
from jtik.result.reduced_gradient import reduced_gradient
from jtik.result.relaxation import Relaxation
from jtik.types import Array

Rows = tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Levels:
    """Levels of priority at one configuration.

    Attributes:
        rows: the rows of each level, the highest first.
        tasks: the rows of each task, by name.
        error: task error e, (m,), rows in [m] or [rad].
        linear: for each row, whether it is a length [m] rather than an angle [rad], (m,).
        residual: weighted task error, (m,).
        weighted: Jacobian of the residual, (m, n).
        limits: velocity indices of the joints at their upper limit, and of those at their lower limit.
        tolerances: of position [m] and orientation [rad].
        rank_threshold: singular values up to this fraction of the norm count as zero.
    """

    rows: tuple[Rows, ...]
    tasks: Mapping[str, Rows]
    error: Array
    linear: NDArray[np.bool_]
    residual: Array
    weighted: Array
    limits: tuple[Rows, Rows]
    tolerances: tuple[float, float]
    rank_threshold: float

    @property
    def reached(self) -> int:
        """How many levels are reached before the first that is not."""
        for count, rows in enumerate(self.rows):
            if not self._within(rows):
                return count
        return len(self.rows)

    def relative_gradient(self) -> tuple[float, float]:
        """The largest relative gradient of the levels that are not reached, where the levels above stay as they are.

        The first is that of all joints, the second that of the joints that no limit keeps from following its negative.
        """
        of_all = of_free = 0.0
        for k in range(self.reached, len(self.rows)):
            if self._within(self.rows[k]):
                continue
            above, own = [row for rows in self.rows[:k] for row in rows], list(self.rows[k])
            distance, scale = length(self.residual[own]) or 1.0, length(self.weighted[own]) or 1.0
            J, gradient = self.weighted[above], self.weighted[own].T @ (self.residual[own] / distance)
            for limits, kept in ((((), ()), False), (self.limits, True)):
                free, reduced, _ = reduced_gradient(J, gradient, *limits, self.rank_threshold)
                rate = length(reduced[free]) / scale
                of_all, of_free = (of_all, max(of_free, rate)) if kept else (max(of_all, rate), of_free)
        return of_all, of_free

    def relaxed(self) -> tuple[Relaxation, ...]:
        """What remains of the error of each task that is not reached."""
        found = []
        for name, rows in self.tasks.items():
            errors = self._errors(rows)
            for error, tolerance, unit in zip(errors, self.tolerances, ("m", "rad"), strict=True):
                if error > tolerance:
                    found.append(Relaxation(f"task {name!r}", error, unit))
        return tuple(found)

    def _errors(self, rows: Rows) -> tuple[float, float]:
        """Norms of those of the rows that are lengths [m] and angles [rad]."""
        error, linear = self.error[list(rows)], self.linear[list(rows)]
        return length(error[linear]), length(error[~linear])

    def _within(self, rows: Rows) -> bool:
        """Whether the errors of the rows are within the tolerances."""
        return all(error <= limit for error, limit in zip(self._errors(rows), self.tolerances, strict=True))

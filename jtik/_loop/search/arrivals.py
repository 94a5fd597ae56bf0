"""Where the attempts of a search arrived at the target: which arrivals are distinct, and which is the best."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from jtik._loop.search.continuum import Continuum
from jtik._step.stopping import Code
from jtik.robot import Robot
from jtik.types import Array

DISTINCT = 1e-2
"""Two configurations are distinct where a joint differs by more than this [rad] or [m]."""

BETWEEN = (0.25, 0.5, 0.75)
"""Where on the way from one arrival to another the error is evaluated."""


class SearchResult(NamedTuple):
    """Where a search ended.

    Attributes:
        q: configuration, (nq,).
        code: code of the last call.
        iterations: calls that tried a step.
        escapes: saddle escapes.
        restarts: restarts used.
        errors: norms of position [m] and orientation [rad] rows at q; None where the last call did not give them.
        alternatives: the other arrivals of a search for several, the best first.
    """

    q: Array
    code: Code
    iterations: int
    escapes: int
    restarts: int
    errors: tuple[float, float] | None = None
    alternatives: tuple[SearchResult, ...] = ()

    def misses(self, position: float, orientation: float) -> bool:
        """Whether the errors alone show that the target is not reached, so that the status need not be computed."""
        return self.errors is not None and (self.errors[0] > position or self.errors[1] > orientation)


class Arrivals:
    """The distinct arrivals of one search (formulations/restarts.md).

    Two arrivals are one where no joint differs by more than `DISTINCT`, apart from whole turns of the joints that can
    turn, where the robot stays on target all the straight way from one to the other, or where both are of the
    continuum of a singular pose. Of these the one with the smaller cost is kept.

    Args:
        robot: the robot.
        continuum: the continua of singular poses.
        target: the numbers of the target.
        cost: of a configuration: the criterion, or without one the distance from where the search began.
        on_target: whether a configuration is on target.
    """

    def __init__(
        self,
        robot: Robot,
        continuum: Continuum,
        target: Array,
        *,
        cost: Callable[[Array], float],
        on_target: Callable[[Array], bool],
    ) -> None:
        self._robot, self._continuum, self._target = robot, continuum, target
        self._cost, self._on_target = cost, on_target
        self.found: list[SearchResult] = []

    def add(self, arrival: SearchResult) -> None:
        """Another arrival."""
        for i, known in enumerate(self.found):
            if self._is_one(known.q, arrival.q):
                if self._cost(arrival.q) < self._cost(known.q):
                    self.found[i] = arrival
                return
        self.found.append(arrival)

    def best(self, iterations: int, escapes: int, restarts: int) -> SearchResult:
        """The arrival with the smallest cost, with the others; the figures are those of the whole search."""
        first, *others = self.found if len(self.found) == 1 else sorted(self.found, key=lambda each: self._cost(each.q))
        alternatives = tuple(others)
        return first._replace(iterations=iterations, escapes=escapes, restarts=restarts, alternatives=alternatives)

    def _is_one(self, q: Array, other: Array) -> bool:
        v = self._continuum.way(q, other)
        if np.abs(v).max() <= DISTINCT:
            return True
        if all(self._on_target(np.asarray(self._robot.integrate(q, share * v))) for share in BETWEEN):
            return True
        return self._continuum.leads(q, other, self._target, DISTINCT, self._on_target)

"""Directions of a null-space jog: a joint, the descent of a criterion, a vector, or one of a smooth basis."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from jtik._step.symbolic_problem import SymbolicProblem
from jtik.arguments import finite_array, integer
from jtik.errors import ArgumentError
from jtik.types import Array

DESCENT = "descent"
"""The direction of steepest descent of all criteria together."""


class Wish(NamedTuple):
    """What the operator asks for.

    Attributes:
        vector: motion of the joints, whose part in the null space is the direction (n,).
        weights: of the negative gradients of the criteria that are added to it.
        column: which direction of the smooth basis it is; None for a wish.
        words: what it is, for a report.
    """

    vector: Array
    weights: Array
    column: int | None
    words: str


class DirectionReader:
    """Reads the argument ``direction``.

    Args:
        problem: the problem.
    """

    def __init__(self, problem: SymbolicProblem) -> None:
        robot = problem.robot
        self._n, self._none = robot.n, np.zeros(robot.n)
        self._no_weights = np.zeros(len(problem.terms.named))
        self._known: dict[str, Wish] = {}
        for joint in robot.independent_joints:
            if joint.type.is_scalar:
                unit = np.zeros(robot.n)
                unit[robot.v_slice(joint.name)] = 1
                self._known[joint.name] = Wish(unit, self._no_weights, None, f"joint {joint.name!r}")
        for i, (name, _, _) in enumerate(problem.terms.named):
            weights = self._no_weights.copy()
            weights[i] = 1
            self._known.setdefault(name, Wish(self._none, weights, None, f"the criterion {name!r}"))
        if problem.has_criterion:
            self._known.setdefault(DESCENT, Wish(self._none, self._no_weights + 1, None, "the criteria"))

    def read(self, direction: Any) -> Wish:
        """The wish that ``direction`` is.

        Raises:
            ArgumentError: for anything else.
        """
        if isinstance(direction, str):
            if direction in self._known:
                return self._known[direction]
            raise ArgumentError("direction", direction, self._accepted())
        if direction is None or isinstance(direction, (int, np.integer)):
            index = 0 if direction is None else integer("direction", direction, accepted=self._accepted())
            if index >= self._n:
                raise ArgumentError("direction", direction, self._accepted())
            return Wish(self._none, self._no_weights, index, f"direction {index}")
        vector = finite_array("direction", direction, (self._n,), self._accepted())
        length = float(np.linalg.norm(vector))
        if not 0 < length < np.inf:
            raise ArgumentError("direction", direction, self._accepted())
        return Wish(vector / length, self._no_weights, None, "the vector")

    def _accepted(self) -> str:
        names = ", ".join(map(repr, self._known)) or "none"
        return f"a name of {names}; a vector ({self._n},), not zero; an index from 0 to {self._n - 1}; or None"

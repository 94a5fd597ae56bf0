"""Where a case starts: the caller's configuration, or one drawn."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from jtik.problems.subject import Subject
from jtik.types import Array


class Starts:
    """Draws starts within the limits, or always gives the same one.

    Args:
        subject: robot and tasks.
        q0: the start of every case, (nq,), or None to draw each by `Robot.random_configuration`.

    Raises:
        ArgumentError: when q0 is no configuration of the reduced robot.
    """

    def __init__(self, subject: Subject, q0: ArrayLike | None) -> None:
        self._robot = subject.robot
        self._given = None if q0 is None else subject.robot.configuration(q0, argument="q0")

    def draw(self, generator: np.random.Generator) -> Array:
        """One start (nq,)."""
        return self._robot.random_configuration(generator) if self._given is None else self._given.copy()

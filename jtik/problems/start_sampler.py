"""Start configurations of cases: given by the caller, or drawn."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from jtik.problems.problem_setup import ProblemSetup
from jtik.types import Array


class StartSampler:
    """Draws start configurations within the limits, or returns a given one.

    Args:
        setup: robot and tasks.
        q0: start of every case, (nq,); None draws each by `Robot.random_configuration`.

    Raises:
        ArgumentError: if q0 is not a configuration of the reduced robot.
    """

    def __init__(self, setup: ProblemSetup, q0: ArrayLike | None) -> None:
        self._robot = setup.robot
        self._given = None if q0 is None else setup.robot.configuration(q0, argument="q0")

    def draw(self, generator: np.random.Generator) -> Array:
        """One start (nq,)."""
        return self._robot.random_configuration(generator) if self._given is None else self._given.copy()

"""The numbers a compiled step reads besides q and its state, in one piece of memory."""

from __future__ import annotations

import numpy as np

from jtik._step.stopping import Settings
from jtik.criterion import Parameters
from jtik.types import Array


class Memory:
    """Target, parameters, lower and upper limits, and settings, one after the other.

    Attributes: whole, all of them; parts, a view of each, in this order.
    """

    def __init__(self, target_size: int, parameters: Parameters, lower: Array, upper: Array) -> None:
        first = [np.zeros(target_size), parameters.memory, lower, upper, np.array(Settings())]
        self._ends = np.cumsum([len(part) for part in first])[:-1]
        self.whole: Array = np.concatenate(first)
        self.parts = self.split(self.whole)
        parameters.memory = self.parts[1]

    def split(self, whole: Array) -> list[Array]:
        """Views of the parts of a copy of it."""
        return np.split(whole, self._ends)

"""The inputs of the compiled step besides q and its state: one named structure, as symbols and as memory."""

from __future__ import annotations

import math
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from jtik.criterion import Parameters
from jtik.symbolic import Expression
from jtik.types import Array

T = TypeVar("T")


class Settings(NamedTuple):
    """The numbers of a solve that may change from one to the next.

    Attributes:
        position_tolerance: norm of the position error that counts as reached [m].
        orientation_tolerance: norm of the orientation error that counts as reached [rad].
        optimality_tolerance: null-space residual, relative to max(1, |dH/dv|), that counts as stationary.
        until_stationary: 1 to continue until the criterion is stationary, 0 to stop at the target.
        null_space_share: share of a null-space displacement that a timed step takes, (0, 1].
        null_space_again: 0 if only the first step from a start takes it, else 1.
        braking_time: duration of a step that brakes towards its target [s]; infinite for one that does not.
        rests: 1 in `step` without a time, which comes to rest at a target out of reach, else 0.
    """

    position_tolerance: Any = 1e-6
    orientation_tolerance: Any = 1e-6
    optimality_tolerance: Any = 1e-6
    until_stationary: Any = 1.0
    null_space_share: Any = 1.0
    null_space_again: Any = 1.0
    braking_time: Any = math.inf
    rests: Any = 0.0

    @classmethod
    def of(cls, column: Expression) -> Settings:
        """The named entries of a column of settings."""
        return cls(*[column[i] for i in range(len(cls._fields))])


SETTING = Settings(*range(len(Settings._fields)))
"""Position of each setting within its column, by name."""


class Inputs(NamedTuple, Generic[T]):
    """Arguments of the compiled step between q and state, in their order.

    Attributes:
        target: target of the tasks, (target size,).
        parameters: live parameters of the criteria and clearances, one after the other.
        lower: lower limits of q, (nq,) [rad] or [m].
        upper: upper limits of q, (nq,) [rad] or [m].
        settings: a column of `Settings`.
    """

    target: T
    parameters: T
    lower: T
    upper: T
    settings: T


class InputMemory:
    """The inputs as numbers in one contiguous array, which is copied at once.

    Attributes:
        numbers: all inputs, one after the other.
        inputs: a view of each.
    """

    def __init__(self, target_size: int, parameters: Parameters, lower: Array, upper: Array) -> None:
        first = [np.zeros(target_size), parameters.memory, lower, upper, np.array(Settings())]
        ends = np.cumsum([len(part) for part in first]).tolist()
        self._slices = [slice(end - len(part), end) for part, end in zip(first, ends, strict=True)]
        self.numbers: Array = np.concatenate(first)
        self.inputs = self.views(self.numbers)
        parameters.memory = self.inputs.parameters

    def views(self, numbers: Array) -> Inputs[Array]:
        """A view of each input within ``numbers``, which is `numbers` or a copy of it."""
        return Inputs(*[numbers[where] for where in self._slices])

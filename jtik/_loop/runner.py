"""The fused step bound to memory of its own, ready for the loop."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from jtik._step.fused import FusedStep
from jtik._step.inputs import Inputs
from jtik._step.stopping import StepOutcome
from jtik.types import Array


class Runner:
    """The fused step on memory of its own. Calls alternate between two memories, so that nothing is copied.

    Attributes: inputs: what it reads between q and state, where it is; view: the outcome of the last call.
    """

    def __init__(self, fused: FusedStep, inputs: Inputs[Array], nq: int) -> None:
        self.fused, self.inputs = fused, inputs
        self.first_state = fused.first_state
        self._patience = fused.state.slices["patience"].start
        self.q = (np.zeros(nq), np.zeros(nq))
        self.state = (self.first_state.copy(), self.first_state.copy())
        self.outcome = np.zeros(len(StepOutcome._fields))
        self.record = np.zeros(fused.record.size)
        records = [self.record] if fused.record.size else []
        self.calls = tuple(
            fused.bind(
                [self.q[a], *inputs, self.state[a]],
                [self.q[1 - a], self.state[1 - a], self.outcome, *records],
            )
            for a in (0, 1)
        )
        self.view = memoryview(self.outcome.data)
        self.at = 0

    def start(self, q: ArrayLike, patience: float = math.inf) -> None:
        """Begin afresh at ``q`` (nq,); give up after ``patience`` calls without progress."""
        self.q[0][:] = q
        self.state[0][:] = self.first_state
        self.state[0][self._patience] = patience
        self.at = 0

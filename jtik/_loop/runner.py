"""The runner: the fused step bound to memory of its own, ready for the loop."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from jtik._step.fused_step import FusedStep
from jtik._step.inputs import Inputs
from jtik._step.stopping import StepOutcome
from jtik.qp.fast_path import StepPath
from jtik.types import Array

OF_ERROR = ("remaining", "left", "smallest", "unimproved")
"""Entries of the state that tell what the error of earlier steps was."""


class Runner:
    """The fused step on memory of its own. Calls alternate between two memories, so that nothing is copied.

    Attributes:
        fused: the fused step.
        inputs: what a call reads besides q and state, where it is.
        first_state: the state of a first call.
        q: the two memories of q, (nq,) each.
        state: the two memories of the state.
        outcome: the outcome of the last call, in the order of `StepOutcome`.
        view: the same as a memoryview, which is faster to read.
        record: figures of the last call; empty where the fused step gives none.
        calls: the two calls; ``calls[0]`` reads memory 0 and writes memory 1.
        at: which memory holds q.
        evaluated: whether the outcome of a call has the errors where its step ends, not where it starts.
        explorer: gives the runner that takes over where V has stopped falling, of a strategy that explores; or None.
        pauses: whether a solve is interrupted where V has stopped falling, for what the loop can do there.
        violation: where the state has the smallest violation of the clearances so far; None without any to restore.
    """

    def __init__(self, fused: FusedStep, inputs: Inputs[Array], nq: int) -> None:
        self.fused, self.inputs = fused, inputs
        self.first_state = fused.first_state
        self.explorer: Callable[[], Runner] | None = None
        self.pauses = False
        self.evaluated = "V" not in fused.state.slices
        self._patience = fused.state.slices["patience"].start
        self.violation = fused.state.slices["violation"].start if "violation" in fused.state.slices else None
        self.q = (np.zeros(nq), np.zeros(nq))
        self.state = (self.first_state.copy(), self.first_state.copy())
        self.outcome = np.zeros(len(StepOutcome._fields))
        self.record = np.zeros(fused.record.size)
        self._expected = [StepPath.FAST]
        self.calls = self._bound(fused)
        self.view = memoryview(self.outcome.data)
        self.at = 0

    def adopt(self, fused: FusedStep) -> None:
        """Run another form of the same step, on the same memory, from the next call on."""
        self.fused, self.calls = fused, self._bound(fused)

    def _bound(self, fused: FusedStep) -> tuple[Callable[[], None], ...]:
        records = [self.record] if fused.record.size else []
        return tuple(
            fused.bind(
                [self.q[a], *self.inputs, self.state[a]],
                [self.q[1 - a], self.state[1 - a], self.outcome, *records],
                self._expected,
            )
            for a in (0, 1)
        )

    def settle(self) -> None:
        """Let the first memory hold q and state, where the native step begins."""
        if self.at:
            self.q[0][:], self.state[0][:], self.at = self.q[1], self.state[1], 0

    def take_over(self, other: Runner) -> None:
        """Repeat the last call of another runner, from the same configuration and with the same state."""
        before = 1 - other.at
        self.start(other.q[before])
        for name, where in other.fused.state.slices.items():
            if name != "patience" and name in self.fused.state.slices:
                self.state[0][self.fused.state.slices[name]] = other.state[before][where]

    def hand_back(self, other: Runner) -> None:
        """Write where the last call ended into another runner."""
        other.at = self.at
        other.q[other.at][:] = self.q[self.at]
        other.outcome[:] = self.outcome

    def start(self, q: ArrayLike, patience: float = math.inf) -> None:
        """Begin an attempt.

        Args:
            q: where it begins, (nq,).
            patience: calls without progress after which it ends.
        """
        self.q[0][:] = q
        self.state[0][:] = self.first_state
        self.state[0][self._patience] = patience
        self._expected[0] = StepPath.FAST  # what came before does not matter, not even for rounding
        self.at = 0

    def wait(self) -> None:
        """Double the calls without progress after which the attempt is interrupted again."""
        self.state[self.at][self._patience] *= 2

    def restart(self, q: ArrayLike) -> None:
        """Begin anew after a step that ended in stagnation. What is left of the error stays known: it damps the steps.

        Args:
            q: where it begins, (nq,).
        """
        slices = self.fused.state.slices
        left = {name: self.state[self.at][slices[name]].copy() for name in OF_ERROR if name in slices}
        self.start(q)
        for name, value in left.items():
            self.state[0][slices[name]] = value

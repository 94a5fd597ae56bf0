"""Exploration: steps beside the solve, where V has stopped falling off the target (formulations/exploration.md).

A monotone strategy ends in the first local minimum of V. Where V has not fallen for some calls, steps are made from a
second configuration, the explorer, which begins at q and takes every step. q waits. As soon as V at the explorer is
below V at q, q moves there and the ordinary steps go on; after a number of exploring steps they go on from q. The step
of a solve does not explore: the loop goes on with the one that does, from the same state, once V has not fallen for
`STUCK` calls (`jtik._loop.search.attempts`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from jtik._step.active_set import clamped
from jtik._step.solve_progress import FALL, STUCK
from jtik._step.stopping import Code
from jtik.strategy import Evaluation, LocalModel
from jtik.strategy.merit import SUFFICIENT
from jtik.symbolic import Expression, if_else, logic_and, logic_not, logic_or, vertcat
from jtik.types import Array

EXPLORATION = 100.0
"""Most exploring steps of an attempt."""


def initial_exploration(nq: int) -> dict[str, Array]:
    """The state that a solve starts from: not exploring, no exploring step taken."""
    return {"exploring": np.zeros(1), "explored": np.zeros(1), "explorer": np.zeros(nq), "waiting": np.zeros(3)}


def start_of_step(state: Mapping[str, Expression], q: Expression) -> Expression:
    """Where the step is made (nq, 1): at the explorer while it explores, else at q."""
    return if_else(state["exploring"], state["explorer"], q) if "exploring" in state else q


@dataclass(frozen=True)
class Exploration:
    """The exploration in one call of the step.

    Attributes:
        state: the state of the step.
        q: the configuration that waits (nq, 1).
        here: task and criterion where the step is made.
        active: 1 if this call explores.
    """

    state: Mapping[str, Expression]
    q: Expression
    here: Evaluation
    active: Expression

    @classmethod
    def of(cls, model: LocalModel, state: Mapping[str, Expression], q: Expression) -> Exploration:
        """What this call does.

        Args:
            model: the local model where the step is made.
            state: the state of the step.
            q: the configuration from which the call was made (nq, 1).
        """
        stuck = logic_and(state["without_progress"] + 1 >= STUCK, FALL**2 * state["best"] <= model.here.V_to_target)
        begins = logic_and(stuck, state["explored"] < EXPLORATION)
        if model.has_criterion:
            begins = logic_and(begins, logic_not(model.near_target))
        return cls(state, q, model.here, logic_or(state["exploring"], begins))

    @cached_property
    def V(self) -> Expression:
        """V at q."""
        return if_else(self.state["exploring"], self.state["waiting"][0], self.here.V_to_target)

    def errors(self, of_step: tuple[Expression, Expression]) -> tuple[Expression, Expression]:
        """Norms of the errors at q [m], [rad], from those where the step is made."""
        before = self.state["exploring"]
        position, orientation = (if_else(before, self.state["waiting"][1 + i], of_step[i]) for i in (0, 1))
        return position, orientation

    def lands(self, accepted: Expression, candidate: Evaluation) -> Expression:
        """1 if q moves to the candidate: after an exploring step only where V is below that at q."""
        below = self.V - candidate.V_to_target >= SUFFICIENT * self.V
        return logic_and(accepted, logic_or(logic_not(self.active), below))

    def configuration(self, model: LocalModel, end: Evaluation, landed: Expression) -> Expression:
        """q after the call (nq, 1): where the step ends if q has moved, else q within the limits."""
        return if_else(landed, end.q, clamped(self.q, model.lower, model.upper, model.bounded))

    def code(self, code: Expression, done: Expression) -> Expression:
        """The code of the call: an explorer that cannot go on does not end the solve."""
        return if_else(logic_and(self.state["exploring"], logic_not(done)), Code.CONTINUE, code)

    def after(
        self,
        after: Mapping[str, Expression],
        first: Mapping[str, Array],
        *,
        moved: Expression,
        landed: Expression,
        end: Evaluation,
        errors: tuple[Expression, Expression],
    ) -> dict[str, Expression]:
        """The state after the call, from that after a step that does not explore.

        The strategy begins anew after an exploring step, and calls are not counted while it explores.

        Args:
            after: the state after a step that does not explore.
            first: the state that a solve starts from.
            moved: 1 if the step was taken.
            landed: 1 if q has moved.
            end: task and criterion at the end of the step.
            errors: norms of the errors at q before the call [m], [rad].
        """
        known = {"best", "patience", "neighbourhood", "without_progress"}
        state = {
            name: value if name in known else if_else(self.active, first[name], value) for name, value in after.items()
        }
        state["without_progress"] = if_else(self.active, logic_not(landed) * STUCK, after["without_progress"])
        taken = if_else(logic_or(moved, logic_not(self.active)), self.state["explored"] + self.active, EXPLORATION)
        goes_on = logic_and(self.active, logic_and(moved, logic_not(landed)))
        state["explored"] = taken
        state["exploring"] = logic_and(goes_on, taken < EXPLORATION)
        state["explorer"] = end.q
        state["waiting"] = vertcat(self.V, *errors)
        return state

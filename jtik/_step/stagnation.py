"""Damping of steps without a time whose error has stopped falling: the arm comes to rest at a target out of reach.

Derivation: formulations/motion.md, (Q8).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jtik.strategy import Evaluation
from jtik.symbolic import Expression, if_else, logic_and, logic_or
from jtik.types import Array

PATIENCE = 10
"""Calls without progress before damping begins."""

FALL = 0.8
"""An error below this share of the smallest so far is progress."""

MOVED = 1.1
"""A target has moved where the error exceeds that which the last step left by this factor."""

UNKNOWN = 1e300
"""Smallest error before the first call: larger than any error."""


def initial_stagnation() -> dict[str, Array]:
    """The state before the first step.

    "remaining" is the error that the last step left, "smallest" the smallest error so far, "unimproved" the number of
    calls in a row that have not lowered it.
    """
    return {"remaining": np.full(1, UNKNOWN), "smallest": np.full(1, UNKNOWN), "unimproved": np.zeros(1)}


@dataclass(frozen=True)
class Stagnation:
    """Whether the error to a target that stays has stopped falling.

    Attributes:
        here: the task at q.
        smallest: the smallest error to this target so far.
        unimproved: number of calls in a row that have not lowered it by much.
    """

    here: Evaluation
    smallest: Expression
    unimproved: Expression

    @classmethod
    def of(cls, state: Mapping[str, Expression], here: Evaluation) -> Stagnation:
        """That of a step which starts ``here``."""
        length = here.length
        moved = length > MOVED * state["remaining"]
        falls = logic_or(moved, length < FALL * state["smallest"])
        return cls(here, if_else(falls, length, state["smallest"]), if_else(falls, 0, state["unimproved"] + 1))

    def damping(self, curvature: Expression, rests: Expression) -> Expression:
        """``curvature``, the size of what J' J leaves out of the Hessian of V, once the error of a step that ``rests``
        has stopped falling."""
        return if_else(logic_and(rests, self.unimproved >= PATIENCE), curvature, 0)

    def after(self, end: Evaluation, accepted: Expression) -> dict[str, Expression]:
        """The state after a step to ``end``."""
        return {
            "remaining": if_else(accepted, end.length, self.here.length),
            "smallest": self.smallest,
            "unimproved": self.unimproved,
        }

"""The hybrid as a switch between the two methods, compared with the dogleg of jtik.

The paper suggests "a hybrid method combining Newton's method and the Jacobian transpose method" and gives no details.
The simplest interpretation is a switch: Newton's step if it is within the limit of Q, otherwise the limited transpose
step. It is written here with jtik's public interface, and compared with the dogleg on the reachable families.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from claim import MEDIAN, SHARE, Row, Script, Within, by_key, median, percent
from five_families import ARM, REACHABLE, problems, raised

import jtik
from jtik.strategy import (
    Acceptance,
    Composition,
    LocalModel,
    Outcome,
    SecondaryTerm,
    Shape,
    State,
    TaskDisplacement,
    TaskStep,
)
from jtik.symbolic import if_else
from jtik_formulations import Hybrid, Newton, ProjectedGradient, Transpose
from jtik_formulations.strategies._parts.transpose_step import cauchy_step

LIMIT = 0.5
"""Limit of Q [rad]."""


@dataclass(frozen=True, kw_only=True)
class SwitchStep(TaskStep):
    """Newton's step if it is within the limit, otherwise the transpose step, shortened to the limit."""

    q_limit: float

    def initial_state(self, shape: Shape) -> Mapping[str, np.ndarray]:
        """No state."""
        return {}

    def propose(self, model: LocalModel, state: State) -> TaskDisplacement:
        """Newton's step or the transpose step."""
        newton = model.row_space_free.least_squares(-model.here.residual)
        transpose = cauchy_step(model, self.q_limit)
        within = model.rotation_norm(newton.vector) <= self.q_limit
        dq = if_else(within, newton.vector, -transpose.gain * transpose.direction)
        image = if_else(within, newton.image, -transpose.gain * transpose.image)
        return TaskDisplacement(dq, image, alpha=transpose.alpha)

    def adapt(self, model: LocalModel, state: State, task: TaskDisplacement, outcome: Outcome) -> State:
        """The state does not change."""
        return {}


@dataclass(frozen=True, kw_only=True)
class Switch(Composition):
    """The paper's hybrid as a switch."""

    q_limit: float = LIMIT
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    def task_step(self) -> TaskStep:
        """Newton or transpose."""
        return SwitchStep(q_limit=self.q_limit)

    def secondary_term(self) -> SecondaryTerm:
        """-beta (I - J+ J) grad H."""
        return self.secondary

    def acceptance(self) -> Acceptance:
        """Every step is accepted."""
        return "always"


STRATEGIES = {
    "transpose": Transpose(backtracking=False),
    "newton": Newton(backtracking=False),
    "switch": Switch(),
    "dogleg": Hybrid(explore=False),
}
"""The first three have no backtracking, so that the switch chooses between the first two."""


def solved(family: str, strategy: str, ik: jtik.InverseKinematics, count: int) -> Row:
    """One strategy on one family.

    Columns:
        reached: targets reached to 1e-6 m within 1000 iterations [%].
        iterations: median iterations.
        rises: solves in which V rose [%].
        mean: mean iterations of the targets reached.
    """
    spent, rose = [], []
    for q0, target in problems(family, count):
        solution = ik.solve(target, q0=q0, trace=True)
        assert solution.trace is not None
        spent.append(solution.iterations if solution.position_error <= 1e-6 else math.inf)
        rose.append(raised(solution.trace))
    successful = [each for each in spent if math.isfinite(each)]
    row: Row = {"family": family, "strategy": strategy, "reached": percent(map(math.isfinite, spent))}
    row |= {"iterations": median(spent), "rises": percent(rose)}
    return row | ({"mean": float(np.mean(successful))} if successful else {})


def compute(quick: bool) -> list[Row]:
    """Every strategy on every reachable family."""
    count = 10 if quick else 200
    solvers = {
        name: jtik.InverseKinematics(ARM, jtik.FrameTask("tip"), strategy=strategy)
        for name, strategy in STRATEGIES.items()
    }
    return [solved(family, name, ik, count) for family in REACHABLE for name, ik in solvers.items()]


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """Statements about these rows, and whether they hold."""
    at = by_key(rows, ["family", "strategy"])

    def of(family: str, strategy: str, column: str) -> float:
        return float(at[f"{family} | {strategy}"][column])

    straight = ("near-straight 1e-3", "near-straight 1e-6")
    return {
        "the switch reaches every target except at the boundary": all(
            of(family, "switch", "reached") == 100 for family in REACHABLE if family != "boundary 9.999"
        ),
        "the dogleg reaches every target": all(of(family, "dogleg", "reached") == 100 for family in REACHABLE),
        "near the straight arm the switch takes more than twice as many iterations as the dogleg": all(
            of(family, "switch", "iterations") > 2 * of(family, "dogleg", "iterations") for family in straight
        ),
        "at the boundary the switch takes more than five times as many": of("boundary 9.999", "switch", "iterations")
        > 5 * of("boundary 9.999", "dogleg", "iterations"),
        "the switch takes fewer iterations than the transpose": all(
            of(family, "switch", "iterations") <= of(family, "transpose", "iterations") for family in REACHABLE
        ),
        "the dogleg never raises V": all(of(family, "dogleg", "rises") == 0 for family in REACHABLE),
        "the dogleg takes at most one iteration more than limited Newton, except at the boundary": all(
            of(family, "dogleg", "iterations") <= of(family, "newton", "iterations") + 1
            for family in REACHABLE
            if family != "boundary 9.999"
        ),
    }


SCRIPT = Script(
    name="hybrid_switch",
    keys=("family", "strategy"),
    tolerances={"reached": SHARE, "iterations": MEDIAN, "rises": SHARE, "mean": Within(absolute=3.0, relative=0.25)},
    compute=compute,
    statements=statements,
)

if __name__ == "__main__":
    sys.exit(SCRIPT.main(__doc__))

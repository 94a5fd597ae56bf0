"""The hybrid: a switch between the two methods, and the dogleg that jtik makes of it.

The paper suggests "a hybrid method combining Newton's method and the Jacobian transpose method" and does not say how.
The plain reading is a switch: Newton's step where it is within the limit of Q, the transpose step, limited, where it is
not. It is written here with what jtik gives to any user, and runs beside the dogleg on the reachable families.
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
from jtik.strategy import Acceptance, Composition, LocalModel, Outcome, SecondaryTerm, Shape, State, TaskMove, TaskStep
from jtik.symbolic import if_else, norm
from jtik_formulations import Hybrid, Newton, ProjectedGradient, Transpose
from jtik_formulations.strategies.newton import newton_step
from jtik_formulations.strategies.transpose import cauchy_step

LIMIT = 0.5
"""Of Q [rad]."""


@dataclass(frozen=True, kw_only=True)
class SwitchStep(TaskStep):
    """Newton's step if it is within the limit, else the transpose step, shortened to the limit."""

    q_limit: float

    def initial_state(self, shape: Shape) -> Mapping[str, np.ndarray]:
        """None."""
        return {}

    def propose(self, model: LocalModel, state: State) -> TaskMove:
        """One or the other."""
        newton, transpose = newton_step(model), cauchy_step(model, self.q_limit)
        within = model.rotation_size(newton.vector) <= self.q_limit
        term = if_else(within, newton.vector, transpose.gain * transpose.direction)
        image = if_else(within, newton.image, transpose.gain * transpose.image)
        return TaskMove(term, image, norm(term), transpose.alpha)

    def adapt(self, model: LocalModel, state: State, move: TaskMove, outcome: Outcome) -> State:
        """Nothing is remembered."""
        return {}


@dataclass(frozen=True, kw_only=True)
class Switch(Composition):
    """The paper's hybrid, read as a switch."""

    q_limit: float = LIMIT
    secondary: SecondaryTerm = field(default_factory=ProjectedGradient)

    def task_step(self) -> TaskStep:
        """Newton or transpose."""
        return SwitchStep(q_limit=self.q_limit)

    def secondary_term(self) -> SecondaryTerm:
        """-beta (I - J+ J) grad H."""
        return self.secondary

    def acceptance(self) -> Acceptance:
        """Every step is taken."""
        return "always"


LAWS = {
    "transpose": Transpose(backtracking=False),
    "newton": Newton(backtracking=False),
    "switch": Switch(),
    "dogleg": Hybrid(),
}
"""The first three without backtracking, so that the switch is between the laws on either side of it."""


def solved(family: str, law: str, ik: jtik.InverseKinematics, count: int) -> Row:
    """reached: targets to 1e-6 m in 1000 iterations [%]. iterations: median; mean: over the targets reached.

    rises: solves in which V rose [%].
    """
    spent, rose = [], []
    for q0, target in problems(family, count):
        solution = ik.solve(target, q0=q0, trace=True)
        assert solution.trace is not None
        spent.append(solution.iterations if solution.position_error <= 1e-6 else math.inf)
        rose.append(raised(solution.trace))
    there = [each for each in spent if math.isfinite(each)]
    row: Row = {"family": family, "law": law, "reached": percent(map(math.isfinite, spent))}
    row |= {"iterations": median(spent), "rises": percent(rose)}
    return row | ({"mean": float(np.mean(there))} if there else {})


def compute(quick: bool) -> list[Row]:
    """Every law on every reachable family."""
    count = 10 if quick else 200
    solvers = {name: jtik.InverseKinematics(ARM, jtik.FrameTask("tip"), strategy=law) for name, law in LAWS.items()}
    return [solved(family, name, ik, count) for family in REACHABLE for name, ik in solvers.items()]


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """What these rows show."""
    at = by_key(rows, ["family", "law"])

    def of(family: str, law: str, column: str) -> float:
        return float(at[f"{family} | {law}"][column])

    straight = ("near-straight 1e-3", "near-straight 1e-6")
    return {
        "the switch reaches every target but at the boundary": all(
            of(family, "switch", "reached") == 100 for family in REACHABLE if family != "boundary 9.999"
        ),
        "the dogleg reaches every target": all(of(family, "dogleg", "reached") == 100 for family in REACHABLE),
        "near the straight arm the switch takes more than twice the dogleg's iterations": all(
            of(family, "switch", "iterations") > 2 * of(family, "dogleg", "iterations") for family in straight
        ),
        "at the boundary the switch takes more than five times the dogleg's": of(
            "boundary 9.999", "switch", "iterations"
        )
        > 5 * of("boundary 9.999", "dogleg", "iterations"),
        "the switch takes fewer iterations than the transpose": all(
            of(family, "switch", "iterations") <= of(family, "transpose", "iterations") for family in REACHABLE
        ),
        "the dogleg never raises V": all(of(family, "dogleg", "rises") == 0 for family in REACHABLE),
        "the dogleg takes at most one iteration more than Newton within the limit, but at the boundary": all(
            of(family, "dogleg", "iterations") <= of(family, "newton", "iterations") + 1
            for family in REACHABLE
            if family != "boundary 9.999"
        ),
    }


SCRIPT = Script(
    name="hybrid_switch",
    keys=("family", "law"),
    tolerances={"reached": SHARE, "iterations": MEDIAN, "rises": SHARE, "mean": Within(absolute=3.0, relative=0.25)},
    compute=compute,
    statements=statements,
)

if __name__ == "__main__":
    sys.exit(SCRIPT.main(__doc__))

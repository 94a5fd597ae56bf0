"""Out of singular positions: do torques for shaping, and forces of obstacles, free a stuck arm?

Section 2.1 says that in practice they do. Ten links lie exactly straight, the target on their line: the task exerts no
torque. jtik leaves such a point by a step along the second derivative, before a criterion could. To see the paper's law
alone, it is iterated here as printed, from jtik's error, Jacobian and gradient; where both can be compared it is
jtik's `Transpose(rule="paper")` with `ProjectedGradient(rule="paper")`. It is stuck for ever where a step is exactly
zero. Arms bent by about 1e-8 rad, without any criterion, are the comparison.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence

import numpy as np
from claim import MEDIAN, SHARE, Row, Script, Within, by_key, median, percent
from five_families import ARM

import jtik
from jtik.criterion.base import Criterion, CriterionSum
from jtik_formulations import Hybrid, JointCentering, ObstacleAvoidance, ProjectedGradient, Transpose

Array = np.ndarray
PAPER = Transpose(rule="paper", q_limit=1.0, backtracking=False, secondary=ProjectedGradient(rule="paper"))
ZIGZAG = 0.3 * (-1.0) ** np.arange(10)
"""Preferred angles that are not zero [rad]."""
OWN = {"transpose": Transpose(), "hybrid": Hybrid()}
RANK = 1e-9
"""Relative size below which a singular value of J counts as zero."""
MOST = 3000
"""Iterations."""

CRITERIA: dict[str, Criterion | CriterionSum | None] = {
    "none": None,
    "zero angles": JointCentering(),
    "zero angles, obstacle on the line": JointCentering() + 0.1 * ObstacleAvoidance(jtik.Point((5.5, 0.0))),
    "obstacle on the line": 0.1 * ObstacleAvoidance(jtik.Point((5.5, 0.0))),
    "obstacle off the line": 0.1 * ObstacleAvoidance(jtik.Point((5.5, 1.0))),
    "zero angles, obstacle off the line": JointCentering() + 0.1 * ObstacleAvoidance(jtik.Point((5.5, 1.0))),
    "zigzag angles": JointCentering(preferred=ZIGZAG),
}
TARGETS = np.linspace(3.0, 9.0, 7)
"""On the arm's line [m]."""


def solver(case: str, strategy: jtik.Strategy) -> jtik.InverseKinematics:
    """Ten links beside one of the criteria."""
    return jtik.InverseKinematics(ARM, jtik.FrameTask("tip"), criteria=CRITERIA[case], strategy=strategy)


def as_printed(ik: jtik.InverseKinematics, target: Sequence[float], q: Array, most: int) -> list[Array]:
    """The configurations (2.8) goes through: alpha and S (B.11) as printed, beta by its ratio.

    It ends on target, or where a step is exactly zero.
    """
    way, energy = [q], math.inf
    for _ in range(most):
        at = ik.solve(target, q0=q, max_iterations=0)
        if at.position_error <= 1e-6:
            break
        J, e, slope = at.jacobian, at.error, at.gradient
        g = J.T @ e
        image = J @ g
        # alpha(S) S = alpha(I): the printed S cancels on an arm of revolute joints
        alpha = g @ g / (image @ image) if g.any() else 0.0
        h = slope - np.linalg.pinv(J, rcond=RANK) @ (J @ slope)
        length = h @ h
        beta = energy / length if length > energy else 1.0
        energy = beta**2 * length
        dq = -alpha * g - beta * h
        if not dq.any():
            break
        q = q + dq
        way.append(q)
    return way


def agreement() -> Row:
    """Largest difference between that and jtik's iterations, over the first ten from bent starts [rad]."""
    differences = []
    for case in CRITERIA:
        ik = solver(case, PAPER)
        q0 = np.linspace(0.3, -0.4, 10)
        trace = ik.solve((6.0, 1.0), q0=q0, trace=True, max_iterations=10).trace
        assert trace is not None
        own = as_printed(ik, (6.0, 1.0), q0, len(trace))
        differences.append(float(np.abs(np.array(own) - trace.q[: len(own)]).max()))
    return {"case": "all, bent start", "law": "difference", "difference": max(differences)}


def alone(case: str) -> Row:
    """The paper's law from the straight arm.

    moves: targets for which it moves the arm [%]. reached: in 3000 iterations [%]. iterations: median.
    """
    ik = solver(case, PAPER)
    ways = [as_printed(ik, (target, 0.0), np.zeros(10), MOST) for target in TARGETS]
    arrived = [
        ik.solve((target, 0.0), q0=way[-1], max_iterations=0).position_error <= 1e-6
        for way, target in zip(ways, TARGETS, strict=True)
    ]
    return {
        "case": case,
        "law": "as printed",
        "moves": percent(len(way) > 1 for way in ways),
        "reached": percent(arrived),
        "iterations": median([len(way) - 1 if ok else math.inf for way, ok in zip(ways, arrived, strict=True)]),
    }


def escaping(case: str, law: str, strategy: jtik.Strategy) -> Row:
    """As `alone`, of jtik's solve; escapes: median number of second-order steps."""
    ik = solver(case, strategy)
    solutions = [ik.solve((target, 0.0), q0=np.zeros(10), until="reached") for target in TARGETS]
    return {
        "case": case,
        "law": law,
        "reached": percent(solution.converged for solution in solutions),
        "iterations": median([s.iterations if s.converged else math.inf for s in solutions]),
        "escapes": median([float(solution.escapes) for solution in solutions]),
    }


def bent(count: int) -> list[Row]:
    """Without a criterion, from starts bent by about 1e-8 rad."""
    ik, hybrid = solver("none", PAPER), solver("none", Hybrid())
    printed: list[float] = []
    own: list[float] = []
    escapes: list[float] = []
    for k in range(count):
        rng = np.random.default_rng([8, k])
        target, q0 = (rng.uniform(3, 9), 0.0), 1e-8 * rng.standard_normal(10)
        way = as_printed(ik, target, q0, MOST)
        there = ik.solve(target, q0=way[-1], max_iterations=0).position_error <= 1e-6
        printed.append(len(way) - 1 if there else math.inf)
        solution = hybrid.solve(target, q0=q0, until="reached")
        own.append(solution.iterations if solution.converged else math.inf)
        escapes.append(float(solution.escapes))
    rows: list[Row] = []
    for law, spent in (("as printed", printed), ("hybrid", own)):
        row: Row = {"case": "none, bent by 1e-8", "law": law, "reached": percent(map(math.isfinite, spent))}
        rows.append(row | {"iterations": median(spent)})
    rows[1]["escapes"] = median(escapes)
    return rows


def compute(quick: bool) -> list[Row]:
    """The paper's law alone, jtik's solves, bent starts."""
    rows = [agreement()] + [alone(case) for case in CRITERIA]
    rows += [escaping(case, law, strategy) for case in CRITERIA for law, strategy in OWN.items()]
    return rows + bent(10 if quick else 100)


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """What these rows show."""
    at = by_key(rows, ["case", "law"])

    def moves(*cases: str) -> set[float]:
        return {float(at[f"{case} | as printed"]["moves"]) for case in cases}

    freeing = ("obstacle off the line", "zero angles, obstacle off the line", "zigzag angles")
    return {
        "the law as printed is jtik's rule paper": float(at["all, bent start | difference"]["difference"]) < 1e-9,
        "without a criterion it never moves the straight arm": moves("none") == {0},
        "nor beside zero angles, the criterion of Figure 2.2": moves("zero angles") == {0},
        "nor beside an obstacle on the arm's line": moves("obstacle on the line", "zero angles, obstacle on the line")
        == {0},
        "obstacles off the line and angles other than zero free it": moves(*freeing) == {100}
        and all(at[f"{case} | as printed"]["reached"] == 100 for case in freeing),
        "a bend of 1e-8 rad frees it without any torque": float(at["none, bent by 1e-8 | as printed"]["reached"]) > 95,
        "jtik's escape and the hybrid bring it to the target in every case": all(
            at[f"{case} | hybrid"]["reached"] == 100 for case in CRITERIA
        ),
        "one escape is enough": all(at[f"{case} | {law}"]["escapes"] == 1 for case in CRITERIA for law in OWN),
    }


SCRIPT = Script(
    name="out_of_singular",
    keys=("case", "law"),
    tolerances={
        "difference": Within(absolute=1e-9),
        "moves": SHARE,
        "reached": SHARE,
        "iterations": MEDIAN,
        "escapes": Within(absolute=0.5),
    },
    compute=compute,
    statements=statements,
)

if __name__ == "__main__":
    sys.exit(SCRIPT.main(__doc__))

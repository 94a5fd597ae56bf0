"""Escape from singular positions by the gradients of criteria.

Section 2.1 says that in practice the criteria for shaping and obstacles move the arm out of singular positions. Here
ten links are exactly straight with the target on their line, so the gradient of the task error vanishes. jtik escapes
from such a saddle point along a direction of negative curvature, before a criterion could have an effect. The paper's
method alone is therefore iterated here as printed, with error, Jacobian and gradient from jtik. Where both can be
compared, it agrees with `Transpose(rule="paper")` and `ProjectedGradient(rule="paper")`. It stops if a step is exactly
zero. Arms bent by about 1e-8 rad, without a criterion, are the comparison.
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
"""Non-zero preferred angles [rad]."""
OWN = {"transpose": Transpose(), "hybrid": Hybrid()}
RANK = 1e-9
"""Relative size below which a singular value of J counts as zero."""
MAX_ITERATIONS = 3000
"""Maximum number of iterations."""

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
"""Target positions on the arm's line [m]."""


def solver(case: str, strategy: jtik.Strategy) -> jtik.InverseKinematics:
    """Ten links with one of the criteria."""
    return jtik.InverseKinematics(ARM, jtik.FrameTask("tip"), criteria=CRITERIA[case], strategy=strategy)


def as_printed(ik: jtik.InverseKinematics, target: Sequence[float], q: Array, most: int) -> list[Array]:
    """The iterates of (2.8), with alpha and S (B.11) as printed and beta by its ratio.

    It ends on target, or if a step is exactly zero.
    """
    iterates, energy = [q], math.inf
    for _ in range(most):
        at = ik.solve(target, q0=q, max_iterations=0)
        if at.position_error <= 1e-6:
            break
        J, e, gradient = at.jacobian, at.error, at.gradient
        g = J.T @ e
        image = J @ g
        # alpha(S) S = alpha(I): the printed S cancels on an arm of revolute joints
        alpha = g @ g / (image @ image) if g.any() else 0.0
        h = gradient - np.linalg.pinv(J, rcond=RANK) @ (J @ gradient)
        length = h @ h
        beta = energy / length if length > energy else 1.0
        energy = beta**2 * length
        dq = -alpha * g - beta * h
        if not dq.any():
            break
        q = q + dq
        iterates.append(q)
    return iterates


def agreement() -> Row:
    """Largest difference between these and jtik's iterates, over the first ten from bent starts [rad]."""
    differences = []
    for case in CRITERIA:
        ik = solver(case, PAPER)
        q0 = np.linspace(0.3, -0.4, 10)
        trace = ik.solve((6.0, 1.0), q0=q0, trace=True, max_iterations=10).trace
        assert trace is not None
        own = as_printed(ik, (6.0, 1.0), q0, len(trace))
        differences.append(float(np.abs(np.array(own) - trace.q[: len(own)]).max()))
    return {"case": "all, bent start", "strategy": "difference", "difference": max(differences)}


def alone(case: str) -> Row:
    """The paper's method from the straight arm.

    Columns:
        moves: targets for which the arm moves [%].
        reached: targets reached within 3000 iterations [%].
        iterations: median iterations.
    """
    ik = solver(case, PAPER)
    paths = [as_printed(ik, (target, 0.0), np.zeros(10), MAX_ITERATIONS) for target in TARGETS]
    reached = [
        ik.solve((target, 0.0), q0=path[-1], max_iterations=0).position_error <= 1e-6
        for path, target in zip(paths, TARGETS, strict=True)
    ]
    return {
        "case": case,
        "strategy": "as printed",
        "moves": percent(len(path) > 1 for path in paths),
        "reached": percent(reached),
        "iterations": median([len(path) - 1 if ok else math.inf for path, ok in zip(paths, reached, strict=True)]),
    }


def escaping(case: str, method: str, strategy: jtik.Strategy) -> Row:
    """As `alone`, for a solve of jtik; ``escapes`` is the median number of saddle escapes."""
    ik = solver(case, strategy)
    solutions = [ik.solve((target, 0.0), q0=np.zeros(10), until="reached") for target in TARGETS]
    return {
        "case": case,
        "strategy": method,
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
        path = as_printed(ik, target, q0, MAX_ITERATIONS)
        success = ik.solve(target, q0=path[-1], max_iterations=0).position_error <= 1e-6
        printed.append(len(path) - 1 if success else math.inf)
        solution = hybrid.solve(target, q0=q0, until="reached")
        own.append(solution.iterations if solution.converged else math.inf)
        escapes.append(float(solution.escapes))
    rows: list[Row] = []
    for method, spent in (("as printed", printed), ("hybrid", own)):
        row: Row = {"case": "none, bent by 1e-8", "strategy": method, "reached": percent(map(math.isfinite, spent))}
        rows.append(row | {"iterations": median(spent)})
    rows[1]["escapes"] = median(escapes)
    return rows


def compute(quick: bool) -> list[Row]:
    """Rows of the paper's method alone, of jtik's solves, and of bent starts."""
    rows = [agreement()] + [alone(case) for case in CRITERIA]
    rows += [escaping(case, method, strategy) for case in CRITERIA for method, strategy in OWN.items()]
    return rows + bent(10 if quick else 100)


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """Statements about these rows, and whether they hold."""
    at = by_key(rows, ["case", "strategy"])

    def moves(*cases: str) -> set[float]:
        return {float(at[f"{case} | as printed"]["moves"]) for case in cases}

    freeing = ("obstacle off the line", "zero angles, obstacle off the line", "zigzag angles")
    return {
        "the method as printed agrees with jtik's rule 'paper'": float(at["all, bent start | difference"]["difference"])
        < 1e-9,
        "without a criterion it never moves the straight arm": moves("none") == {0},
        "nor with zero angles, the criterion of Figure 2.2": moves("zero angles") == {0},
        "nor with an obstacle on the arm's line": moves("obstacle on the line", "zero angles, obstacle on the line")
        == {0},
        "obstacles off the line and non-zero angles move it out": moves(*freeing) == {100}
        and all(at[f"{case} | as printed"]["reached"] == 100 for case in freeing),
        "an offset of 1e-8 rad moves it out without a criterion": float(
            at["none, bent by 1e-8 | as printed"]["reached"]
        )
        > 95,
        "jtik's saddle escape and the hybrid reach the target in every case": all(
            at[f"{case} | hybrid"]["reached"] == 100 for case in CRITERIA
        ),
        "one escape is enough": all(at[f"{case} | {method}"]["escapes"] == 1 for case in CRITERIA for method in OWN),
    }


SCRIPT = Script(
    name="out_of_singular",
    keys=("case", "strategy"),
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

"""The rule for beta as printed, with a square root, and the merit function that replaces it.

Appendix A sets beta_{k+1} = beta_k^2 |h_k|^2 / |h_{k+1}|^2 if that is below 1, so that the first of the terms
V2 = |beta h|^2 / 2 of steps k+1 and k is always smaller than the second. V2 is quadratic in beta, so the ratio does
that, and squares itself from step to step; with its root the terms are equal. The paper's velocity is the whole one;
here, as in jtik, it is h, so that the rule is about the null-space motion alone. Three tests: an arm with constant |h|,
for which the sequence is known; ten links among obstacles, to count how often and how soon the null-space motion stops
before the criterion is stationary; and starts at the optimum of the criterion, where V2 = 0.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence

import numpy as np
from claim import EXACT, MEDIAN, SHARE, Row, Script, Within, by_key, median, percent
from five_families import ARM

import jtik
from jtik_formulations import JointCentering, Newton, ObstacleAvoidance, ProjectedGradient

FIELD = [jtik.Point((5.0, 4.5)), jtik.Point((6.0, -4.5))]
"""Obstacles at the boundary of the region in which the arm moves, so that no step ends close to one."""
BETA_MAX = 0.3
"""Below the inverse of the largest curvature of the criteria on most of the path, so that a fixed beta converges."""
CURVED = 1.0
"""The inverse of the curvature of the criterion of zero angles."""
ITERATIONS = 600
FROZEN = 1e-6
"""|beta h| below which the null-space motion counts as stopped [rad]."""
UNFINISHED = 1e-3
"""|h| above which H is not stationary."""

RULES: dict[str, ProjectedGradient] = {
    "paper": ProjectedGradient(rule="paper", beta_max=BETA_MAX),
    "paper, beta 1": ProjectedGradient(rule="paper", beta_max=CURVED),
    "sqrt, no floor": ProjectedGradient(rule="sqrt", beta_max=BETA_MAX, floor=1e-12),
    "sqrt": ProjectedGradient(rule="sqrt", beta_max=BETA_MAX),
    "merit": ProjectedGradient(rule="merit", beta_max=BETA_MAX),
}


@jtik.criterion
def downhill(q, robot):
    """A criterion with gradient 1 along a joint that does not move the frame of the task."""
    return q[3]


def constant(rule: str) -> Row:
    """beta at the first seven steps, with constant |h| = 1 and an initial beta of 0.9."""
    secondary = ProjectedGradient(rule=rule, beta_max=0.9, step_limit=10.0, floor=1e-12)
    strategy = Newton(secondary=secondary, backtracking=False)
    robot = jtik.Robot.planar(4)
    ik = jtik.InverseKinematics(robot, jtik.FrameTask("link3"), criteria=downhill, strategy=strategy, joints="all")
    q0 = np.array([0.3, 0.4, 0.5, 0.6])
    trace = ik.solve(robot.position(q0, "link3"), q0=q0, max_iterations=7, trace=True).trace
    assert trace is not None
    return {"case": f"|h| = 1, {rule}"} | {f"beta_{k}": float(trace.beta[k]) for k in range(7)}


def solved(rule: str, count: int, at_optimum: bool = False) -> Row:
    """Ten links, Newton's step for the task, zero angles and obstacles as criteria.

    Columns:
        frozen: solves that end with |beta h| below 1e-6 rad and |h| above 1e-3 [%].
        freezes: median step after which this holds.
        h: median of |h| at the end.
        stationary: solves that end on target with H stationary [%].
        V2_rises: accepted steps at which V2 rose [%].
        V_rises: accepted steps at which V rose [%].
    """
    centering = JointCentering(1.0, np.linspace(0.4, -0.2, 10)) if at_optimum else JointCentering()
    criteria = centering if at_optimum else centering + 0.3 * ObstacleAvoidance(FIELD)
    ik = jtik.InverseKinematics(ARM, jtik.FrameTask("tip"), criteria=criteria, strategy=Newton(secondary=RULES[rule]))
    frozen, freezes, residuals, ended, V2_rises, V_rises = [], [], [], [], [], []
    for k in range(count):
        rng = np.random.default_rng([17, k])
        q0 = np.linspace(0.4, -0.2, 10) if at_optimum else rng.uniform(-0.6, 0.6, 10)
        target = ARM.position(rng.uniform(-0.5, 0.5, 10), "tip")
        solution = ik.solve(target, q0=q0, max_iterations=ITERATIONS, trace=True)
        trace = solution.trace
        assert trace is not None
        length = np.sqrt(2 * trace.V2)
        h = solution.null_space_residual
        stopped = length[-1] < FROZEN and h > UNFINISHED
        frozen.append(stopped)
        if stopped:
            moving = np.flatnonzero(length >= FROZEN)
            freezes.append(int(moving[-1]) + 1 if len(moving) else 0)
        residuals.append(h)
        ended.append(solution.status is jtik.Status.CONVERGED)
        V2, V = trace.V2[trace.accepted == 1], trace.V[trace.accepted == 1]
        V2_rises += list(np.diff(V2) > 1e-9 * V2[:-1] + 1e-24)
        V_rises += list(np.diff(V) > 1e-9 * V[:-1] + 1e-12)
    row: Row = {
        "case": f"{'start at the optimum' if at_optimum else 'ten links'}, {rule}",
        "frozen": percent(frozen),
        "h": median(residuals),
        "stationary": percent(ended),
        "V2_rises": percent(V2_rises),
        "V_rises": percent(V_rises),
    }
    return row | ({"freezes": median(freezes)} if freezes else {})


def compute(quick: bool) -> list[Row]:
    """The rows of all three tests."""
    few = 6 if quick else 60
    rows = [constant(rule) for rule in ("paper", "sqrt")]
    rows += [solved(rule, few) for rule in RULES]
    return rows + [solved(rule, few, at_optimum=True) for rule in RULES if rule != "paper, beta 1"]


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """Statements about these rows, and whether they hold."""
    at = by_key(rows, ["case"])
    printed, root = at["|h| = 1, paper"], at["|h| = 1, sqrt"]

    def of(case: str, column: str) -> float:
        return float(at[case][column])

    return {
        "as printed, beta squares itself: 0.9^(2^k)": all(
            math.isclose(float(printed[f"beta_{k}"]), 0.9**2**k, rel_tol=1e-9) for k in range(7)
        ),
        "as printed the first beta term is smaller than the second, with the root equal to it": all(
            float(printed[f"beta_{k + 1}"]) < float(printed[f"beta_{k}"])
            and math.isclose(float(root[f"beta_{k + 1}"]), float(root[f"beta_{k}"]), rel_tol=1e-9)
            for k in range(6)
        ),
        "with the root, beta is constant if |h| is": all(
            math.isclose(float(root[f"beta_{k}"]), 0.9, rel_tol=1e-9) for k in range(7)
        ),
        "as printed, the null-space motion of most solves stops before H is stationary": of(
            "ten links, paper", "frozen"
        )
        > 80,
        "with a first beta of 1, the inverse of the curvature of H, fewer solves stop": 0
        < of("ten links, paper, beta 1", "frozen")
        < of("ten links, paper", "frozen"),
        "with the root or by merit it stops in none": all(
            of(f"ten links, {rule}", "frozen") == 0 for rule in ("sqrt", "merit")
        ),
        "by merit every solve ends with H stationary": of("ten links, merit", "stationary") == 100,
        "with the root more solves end with H stationary than as printed": of("ten links, sqrt", "stationary")
        > of("ten links, paper", "stationary"),
        "V2 never rises as printed, or with the root and no floor": all(
            of(f"{start}, {rule}", "V2_rises") == 0
            for start in ("ten links", "start at the optimum")
            for rule in ("paper", "sqrt, no floor")
        ),
        "V2 rises by merit, which limits beta differently": of("ten links, merit", "V2_rises") > 0,
        "from a start at the optimum of H the printed rule never moves in the null space": of(
            "start at the optimum, paper", "frozen"
        )
        == 100
        and of("start at the optimum, paper", "freezes") <= 1,
        "the root without a floor does not move either": of("start at the optimum, sqrt, no floor", "frozen") == 100,
        "the floor and the merit function do": all(
            of(f"start at the optimum, {rule}", "frozen") == 0 for rule in ("sqrt", "merit")
        ),
    }


SCRIPT = Script(
    name="beta_rule",
    keys=("case",),
    tolerances={f"beta_{k}": EXACT for k in range(7)}
    | {
        "frozen": SHARE,
        "freezes": MEDIAN,
        "h": Within(absolute=1e-3, relative=0.1),
        "stationary": SHARE,
        "V2_rises": Within(absolute=2.0),
        "V_rises": Within(absolute=2.0),
    },
    compute=compute,
    statements=statements,
)

if __name__ == "__main__":
    sys.exit(SCRIPT.main(__doc__))

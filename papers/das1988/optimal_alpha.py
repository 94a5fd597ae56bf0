"""alpha = N/2D as the minimiser of C, compared with a scan, with SciPy, and with the best alpha for V itself.

Appendix A sets alpha = N/2D because it minimises C = -alpha N + alpha^2 D. For random configurations of planar arms, of
a Panda, of a vehicle with an arm, and with a stiffness Kp that is not the identity, the alpha of jtik's first step is
compared with the minimiser of C from a scan and from SciPy. C is not the exact change of V, so a scan also finds the
best alpha for V itself.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence

import numpy as np
from claim import EXACT, ROUNDING, Row, Script, Within, by_key
from scipy.optimize import minimize_scalar

import jtik
from jtik_formulations import Transpose

BARE = Transpose(q_limit=math.inf, backtracking=False)
SCAN = np.linspace(0.0, 2.0, 2001)
"""Multiples of alpha at which C is evaluated."""
LONG = np.linspace(0.02, 6.0, 300)
"""Multiples of alpha at which V is evaluated."""

CASES: dict[str, tuple[jtik.Robot, jtik.FrameTask, tuple[float, ...]]] = {
    "planar 2": (jtik.Robot.planar(2), jtik.FrameTask("tip"), (1, 1)),
    "planar 10": (jtik.Robot.planar(10), jtik.FrameTask("tip"), (1, 1)),
    "planar 10, Kp = diag(4, 1/4)": (
        jtik.Robot.planar(10),
        jtik.FrameTask("tip", stiffness=np.diag([4.0, 0.25])),
        (4, 0.25),
    ),
    "panda, pose": (jtik.Robot.builtin("panda"), jtik.FrameTask("tip", "pose"), (1,) * 6),
    "vehicle with 3 links": (jtik.Robot.vehicle(3), jtik.FrameTask("tip"), (1, 1)),
}


def worked() -> Row:
    """Two unit links at (0, pi/2), target (0, 1.5): alpha = 13/34 by hand."""
    ik = jtik.InverseKinematics(jtik.Robot.planar(2), jtik.FrameTask("tip"), strategy=BARE)
    q0 = np.array([0.0, math.pi / 2])
    solution = ik.solve((0.0, 1.5), q0=q0, max_iterations=1, trace=True)
    trace = solution.trace
    assert trace is not None
    return {
        "case": "worked step",
        "alpha": float(trace.alpha[0]),
        "dq1": float(solution.q[0] - q0[0]),
        "dq2": float(solution.q[1] - q0[1]),
        "V_before": float(trace.V[0]),
        "V_predicted": float(trace.V[0] - trace.predicted_decrease[0]),
        "V_after": float(trace.error[1] ** 2 / 2),
    }


def compared(case: str, count: int) -> Row:
    """One case.

    Columns:
        scipy: largest relative difference between alpha and SciPy's minimiser of C.
        scan: largest relative difference between alpha and the minimiser of the scan, which has steps of 0.001.
        sign: whether C is negative just inside (0, N/D) and positive just outside.
        true_10: tenth percentile of the best alpha for V, relative to alpha.
        true_50: median of this ratio.
        true_90: ninetieth percentile of this ratio.
        rises: share of problems in which V is larger after the step [%].
    """
    robot, task, stiffness = CASES[case]
    Kp = np.diag(np.array(stiffness, dtype=float))
    ik = jtik.InverseKinematics(robot, task, strategy=BARE, limits=False)
    rng = np.random.default_rng(88)
    by_scipy, by_scan, signs, true, rises = [], [], [], [], []
    for _ in range(count):
        q, goal = (robot.neutral + rng.uniform(-1, 1, robot.n) for _ in range(2))
        target = robot.pose(goal, "tip") if len(Kp) == 6 else robot.position(goal, "tip")
        at = ik.solve(target, q0=q, max_iterations=0)
        trace = ik.solve(target, q0=q, max_iterations=1, trace=True).trace
        assert trace is not None
        alpha, u = float(trace.alpha[0]), Kp @ at.error
        M = at.jacobian @ at.jacobian.T
        N, D = u @ M @ u, u @ M @ Kp @ M @ u / 2

        def C(a: float, N: float = N, D: float = D) -> float:
            return -a * N + a**2 * D

        by_scipy.append(abs(minimize_scalar(C).x / alpha - 1))
        by_scan.append(abs(SCAN[np.argmin(C(SCAN * alpha))] - 1))
        signs.append(C(0.001 * alpha) < 0 and C(1.999 * alpha) < 0 < C(2.001 * alpha))
        step = -alpha * at.jacobian.T @ u

        def V(a: float, q=q, target=target, step=step) -> float:
            e = ik.solve(target, q0=q + a * step, max_iterations=0).error
            return float(e @ Kp @ e) / 2

        true.append(LONG[np.argmin([V(a) for a in LONG])])
        rises.append(V(1.0) > V(0.0))
    low, middle, high = np.percentile(true, [10, 50, 90])
    return {
        "case": case,
        "scipy": max(by_scipy),
        "scan": max(by_scan),
        "sign": float(all(signs)),
        "true_10": float(low),
        "true_50": float(middle),
        "true_90": float(high),
        "rises": 100 * float(np.mean(rises)),
    }


def compute(quick: bool) -> list[Row]:
    """The worked step and every case."""
    return [worked(), *(compared(case, 2 if quick else 50) for case in CASES)]


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """Statements about these rows, and whether they hold."""
    at = by_key(rows, ["case"])
    cases = [at[case] for case in CASES]
    step = at["worked step"]
    hand = {"alpha": 13 / 34, "dq1": 1.5 * 13 / 34, "dq2": 13 / 34, "V_before": 0.625, "V_predicted": 0.003676470588}
    return {
        "alpha is SciPy's minimiser of C": all(float(row["scipy"]) < 1e-6 for row in cases),
        "alpha is the scan's minimiser of C": all(float(row["scan"]) <= 1e-3 for row in cases),
        "C is negative on (0, N/D) and positive beyond": all(row["sign"] == 1 for row in cases),
        "the worked step agrees with the calculation by hand": all(
            abs(float(step[name]) - value) < 1e-9 for name, value in hand.items()
        ),
        "the best alpha for V itself is different": all(
            float(row["true_90"]) - float(row["true_10"]) > 0.01 for row in cases
        ),
    }


SCRIPT = Script(
    name="optimal_alpha",
    keys=("case",),
    tolerances={
        "alpha": EXACT,
        "dq1": EXACT,
        "dq2": EXACT,
        "V_before": EXACT,
        "V_predicted": EXACT,
        "V_after": EXACT,
        "scipy": Within(absolute=1e-6),
        "scan": ROUNDING,
        "sign": EXACT,
        "true_10": Within(absolute=0.03),
        "true_50": Within(absolute=0.03),
        "true_90": Within(absolute=0.03),
        "rises": Within(absolute=2.0),
    },
    compute=compute,
    statements=statements,
)

if __name__ == "__main__":
    sys.exit(SCRIPT.main(__doc__))

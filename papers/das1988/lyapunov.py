"""The decrease of V in continuous time, and in discrete steps under the conditions of Appendix A.

Section 2.1 shows that dV/dt = -alpha e' Kp J S J' Kp e (2.7); Appendix A that V changes by -alpha N + alpha^2 D (A.12)
and falls for alpha = N/2D. The first is integrated here with SciPy from jtik's Jacobian, with and without a criterion.
The second is a statement about a linear model. The script counts how often V itself rises in solves of a ten-link arm,
with decreasing step limits, and compares this with backtracking on V and with an arm of prismatic joints, which is
linear.
"""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Sequence

import numpy as np
from claim import EXACT, MEDIAN, ROUNDING, SHARE, Row, Script, Within, by_key, median, percent
from five_families import ARM, problems
from scipy.integrate import solve_ivp

import jtik
from jtik.symbolic import function, jacobian, symbol
from jtik.symbolic.compile import CompiledFunction
from jtik_formulations import Transpose

Array = np.ndarray
RISE = 1e-12
"""Relative rise of V that is rounding of its evaluation."""
DURATION = 5.0
"""Duration of the continuous motion with alpha = 1 [s]."""
HALF_STEP = 1e-5
"""Half of the step of central differences [s]; the motion is stiff, because |J J'| is in the hundreds."""
LIMITS = (math.inf, 1.0, 0.5, 0.25, 0.1)
"""Limits of the step length Q [rad]."""


def model() -> CompiledFunction:
    """q -> tip position (2, 1) and its Jacobian (2, 10)."""
    q = symbol("q", ARM.n)
    position = ARM.at(q).position("tip")
    return CompiledFunction(function("model", [q], [position, jacobian(position, q)]))


AT = model()


def evaluated(q: Array, target: Array) -> tuple[Array, Array, Array]:
    """Error e, Jacobian J, and h = (I - J+ J) grad H of H = |q|^2/2."""
    position, J = AT(q)
    return position[:, 0] - target, J, q - J.T @ np.linalg.solve(J @ J.T, J @ q)


def flow(q: Array, target: Array, beta: float) -> Array:
    """The update law (2.1) with alpha = 1, S = Kp = I and H = |q|^2/2."""
    e, J, h = evaluated(q, target)
    return -J.T @ e - beta * h


def continuous(beta: float, count: int) -> Row:
    """Integrate, and compare dV/dt with (2.7).

    Columns:
        rises: solves in which V = |e|^2/2 rose between two samples [%].
        energy_rises: the same for V2 = |beta h|^2/2 at this constant beta [%].
        derivative_error: largest relative difference between dV/dt from differences and (2.7).
    """
    rose, energy_rose, derivative_errors = [], [], []
    for q0, target in problems("generic", count):

        def velocity(_: float, q: Array, target: Array = target) -> Array:
            return flow(q, target, beta)

        motion = solve_ivp(velocity, (0, DURATION), q0, rtol=1e-8, atol=1e-10, dense_output=True).sol

        def V(t: float, motion=motion, target: Array = target) -> float:
            return float(np.sum(evaluated(motion(t), target)[0] ** 2)) / 2

        times = np.linspace(0, DURATION, 101)
        values = np.array([V(t) for t in times])
        rose.append(bool((np.diff(values) > 1e-14).any()))
        energies = [np.linalg.norm(evaluated(motion(t), target)[2]) for t in times]
        energy_rose.append(bool((np.diff(energies) > 1e-6).any()))
        for t in (0.01, 0.1, 1.0):
            e, J, _ = evaluated(motion(t), target)
            derivative = -float(np.sum((J.T @ e) ** 2))
            if derivative < -1e-3:  # later V hardly changes
                derivative_errors.append(abs((V(t + HALF_STEP) - V(t - HALF_STEP)) / (2 * HALF_STEP) / derivative - 1))
    row: Row = {
        "case": f"continuous, beta = {beta:g}",
        "rises": percent(rose),
        "derivative_error": max(derivative_errors),
    }
    return row | ({"energy_rises": percent(energy_rose)} if beta else {})


def discrete(family: str, strategy: Transpose, case: str, count: int) -> Row:
    """Solve, and count rises of V.

    Columns:
        rises: solves with an accepted step that raised V [%].
        step_rises: accepted steps that raised V [%].
        iterations: median iterations.
        off: median of |actual - predicted| / predicted decrease over first steps.
        model: largest relative difference between the predicted decrease of jtik and alpha N - alpha^2 D, over first
            steps.
    """
    ik = jtik.InverseKinematics(ARM, jtik.FrameTask("tip"), strategy=strategy)
    rose, steps, iterations, off, predictions = [], [], [], [], []
    for q0, target in problems(family, count):
        solution = ik.solve(target, q0=q0, trace=True)
        trace = solution.trace
        assert trace is not None
        up = (trace.accepted == 1) & (trace.actual_decrease < -RISE * trace.V)
        rose.append(bool(up.any()))
        steps += list(up[trace.accepted == 1])
        iterations.append(solution.iterations if solution.position_error <= 1e-6 else math.inf)
        predicted = float(trace.predicted_decrease[0])
        off.append(abs(trace.actual_decrease[0] - predicted) / predicted)
        e, J, _ = evaluated(q0, target)
        M = J @ J.T
        N, D = e @ M @ e, e @ M @ M @ e / 2
        alpha = min(N / (2 * D), strategy.q_limit / np.linalg.norm(J.T @ e))
        predictions.append(abs((alpha * N - alpha**2 * D) / predicted - 1))
    return {
        "case": case,
        "rises": percent(rose),
        "step_rises": percent(steps),
        "iterations": median(iterations),
        "off": median(off),
        "model": max(predictions),
    }


def prismatic_arm() -> jtik.Robot:
    """Three prismatic joints with axes 40 degrees apart: J is constant, and (A.12) is exact."""
    joints = []
    for k in range(3):
        axis = np.array([math.cos(0.7 * k), math.sin(0.7 * k), 0.0])
        parent = "base" if k == 0 else f"carriage{k}"
        joints.append(jtik.Joint(f"joint{k + 1}", jtik.JointType.PRISMATIC, parent, f"carriage{k + 1}", axis=axis))
    return jtik.Robot(joints, name="prismatic", planar=True)


def prismatic(count: int) -> Row:
    """As `discrete`, for the arm of prismatic joints; ``off`` is the largest of all steps, relative to the first V."""
    strategy = Transpose(backtracking=False)
    ik = jtik.InverseKinematics(prismatic_arm(), jtik.FrameTask("carriage3"), strategy=strategy)
    rng = np.random.default_rng(7)
    rose, off = [], []
    for _ in range(count):
        q0, goal = rng.uniform(-1, 1, 3), rng.uniform(-1, 1, 3)
        target = prismatic_arm().position(goal, "carriage3")
        trace = ik.solve(target, q0=q0, trace=True).trace
        assert trace is not None
        rose.append(bool((trace.actual_decrease < -RISE * trace.V).any()))
        off.append(float(np.max(np.abs(trace.actual_decrease - trace.predicted_decrease)) / trace.V[0]))
    return {"case": "prismatic joints only", "rises": percent(rose), "off": max(off)}


def compute(quick: bool) -> list[Row]:
    """Continuous time, then discrete steps with limits and with backtracking."""
    few, many = (2, 20) if quick else (20, 200)
    rows = [continuous(beta, few) for beta in (0.0, 1.0)]
    for family in ("far", "generic"):
        for limit in LIMITS:
            strategy = Transpose(q_limit=limit, backtracking=False)
            rows.append(discrete(family, strategy, f"{family}, Q limit {limit:g}", many))
        rows.append(discrete(family, Transpose(), f"{family}, backtracking", many))
    return [*rows, prismatic(many)]


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """Statements about these rows, and whether they hold."""
    at = by_key(rows, ["case"])
    families = ("far", "generic")

    def ordered(column: str, family: str) -> bool:
        values = [float(at[f"{family}, Q limit {limit:g}"][column]) for limit in LIMITS]
        return all(a >= b for a, b in itertools.pairwise(values))

    return {
        "in continuous time V falls, with and without a criterion": all(
            at[f"continuous, beta = {beta}"]["rises"] == 0 for beta in (0, 1)
        ),
        "the derivative of V is that of (2.7)": all(
            float(at[f"continuous, beta = {beta}"]["derivative_error"]) < 1e-3 for beta in (0, 1)
        ),
        "V2 does not always fall at a constant beta": float(at["continuous, beta = 1"]["energy_rises"]) > 0,
        "the decrease of the model is alpha N - alpha^2 D": all(
            float(row["model"]) < 1e-9 for row in rows if "model" in row
        ),
        "with alpha = N/2D alone V rises in some solves": all(
            float(at[f"{family}, Q limit inf"]["rises"]) > 0 for family in families
        ),
        "with shorter steps V is closer to its model": all(ordered("off", family) for family in families),
        "with steps of at most 0.1 rad V does not rise": all(
            at[f"{family}, Q limit 0.1"]["rises"] == 0 for family in families
        ),
        "with backtracking V does not rise": all(at[f"{family}, backtracking"]["rises"] == 0 for family in families),
        "for an arm of prismatic joints the model is exact, and V falls": at["prismatic joints only"]["rises"] == 0
        and float(at["prismatic joints only"]["off"]) < 1e-12,
    }


SCRIPT = Script(
    name="lyapunov",
    keys=("case",),
    tolerances={
        "rises": SHARE,
        "step_rises": Within(absolute=0.5),
        "energy_rises": SHARE,
        "derivative_error": Within(absolute=1e-4),
        "iterations": MEDIAN,
        "off": Within(absolute=ROUNDING.absolute, relative=EXACT.relative),  # rounding, if J is constant
        "model": ROUNDING,
    },
    compute=compute,
    statements=statements,
)

if __name__ == "__main__":
    sys.exit(SCRIPT.main(__doc__))

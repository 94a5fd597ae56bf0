"""The transpose method and Newton's method near singular poses.

The problems are ten links bent by 1e-3 and by 1e-6 rad, targets one millimetre inside the reach, and an upright KUKA
iiwa. Bent by 1e-3 to 1e-7 rad, the arms are also turned off the coordinate axes, with their targets: along an axis one
row of J is short, elsewhere both are long and nearly parallel, which is harder for a factorisation by rows. The script
computes the longest step, the share of solves in which V rises, the share of targets reached, and the error of the
predicted decrease of V. Then it computes single steps with sigma_2 of J at 1e-4, with the error along the weak
direction and at 45 degrees to it, to show the effect of a variable alpha alone.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence

import numpy as np
from claim import MEDIAN, SHARE, Row, Script, Within, by_key, median, percent
from five_families import ARM, METHODS, problems, raised
from scipy.optimize import brentq

import jtik

Array = np.ndarray
STRATEGIES = ("transpose, alpha only", "transpose", "newton, undamped", "newton, Q limit", "hybrid")
FAMILIES = ("near-straight 1e-3", "near-straight 1e-6", "boundary 9.999")
TURNED = {"1e-3": 1e-3, "1e-6": 1e-6, "1e-7": 1e-7}
"""Standard deviations of the joint angles of the arms off the axes [rad]."""
PREDICTED = 1e-6
"""Relative error of a predicted decrease that is rounding, with a Jacobian of condition 1e8."""
LIMIT = 0.5
"""Limit of Q, for strategies that have one [rad]."""
WEAK = 1e-4
"""The smallest singular value of J in the single steps [m/rad]."""

Given = list[tuple[Array, Array]]


def solved(family: str, strategy: str, ik: jtik.InverseKinematics, given: Given) -> Row:
    """One strategy on one family.

    Columns:
        longest: median over solves of the longest step [rad].
        longest_of_all: longest step of all solves [rad].
        rises: solves in which V rose [%].
        reached: targets reached to 1e-6 m within 1000 iterations [%].
        iterations: median iterations.
        predicted: largest relative difference between the predicted decrease of V at the first step dq, if it is
            accepted, and the decrease of |e + J dq|^2/2.
    """
    longest, rose, spent, differences = [], [], [], []
    for q0, target in given:
        solution = ik.solve(target, q0=q0, trace=True)
        assert solution.trace is not None
        first = ik.solve(target, q0=q0, max_iterations=0)
        motion = first.jacobian @ (solution.trace.q[1] - solution.trace.q[0])
        if solution.trace.accepted[0]:
            decrease = -motion @ (first.error + motion / 2)
            differences.append(abs(float(solution.trace.predicted_decrease[0]) / decrease - 1))
        moving = solution.trace.escaped == 0
        longest.append(float(solution.trace.step_length[moving].max()))
        rose.append(raised(solution.trace))
        spent.append(solution.iterations if solution.position_error <= 1e-6 else math.inf)
    return {
        "case": family,
        "strategy": strategy,
        "longest": median(longest),
        "longest_of_all": max(longest),
        "rises": percent(rose),
        "reached": percent(math.isfinite(each) for each in spent),
        "iterations": median(spent),
        "predicted": max(differences),
    }


def turned(deviation: float, count: int) -> Given:
    """The problems of the nearly straight families, each turned about the base by an angle drawn at random."""
    found = []
    for k, (q0, target) in enumerate(problems("near-straight 1e-3", count)):
        angle = np.random.default_rng([15, k]).uniform(-np.pi, np.pi)
        q = q0 * (deviation / 1e-3)
        q[0] += angle
        found.append((q, target[0] * np.array([math.cos(angle), math.sin(angle)])))
    return found


def upright(count: int) -> tuple[jtik.Robot, Given]:
    """An iiwa about 1e-3 rad from its stretched pose, where the position Jacobian loses rank; targets below the tip."""
    robot = jtik.Robot.builtin("iiwa14")
    rng = np.random.default_rng(14)
    top = robot.position(np.zeros(robot.n))
    return robot, [(1e-3 * rng.standard_normal(robot.n), top - (0.0, 0.0, rng.uniform(0.2, 0.7))) for _ in range(count)]


def weak_pose() -> Array:
    """Ten links on a flat arc with a smallest singular value of J of 1e-4."""

    def sigma(angle: float) -> float:
        return float(np.linalg.svd(ARM.jacobian(np.full(10, angle), "tip")[:2], compute_uv=False)[1]) - WEAK

    return np.full(10, brentq(sigma, 1e-9, 1e-2, xtol=1e-16))


def along(case: str, share: float) -> list[Row]:
    """One step of each strategy, with an error of 1 m at an angle ``share`` to the weak direction [rad]."""
    q = weak_pose()
    U = np.linalg.svd(ARM.jacobian(q, "tip")[:2])[0]
    e = math.cos(share) * U[:, 1] + math.sin(share) * U[:, 0]
    rows: list[Row] = []
    for strategy in STRATEGIES:
        ik = jtik.InverseKinematics(ARM, jtik.FrameTask("tip"), strategy=METHODS[strategy])
        trace = ik.solve(ARM.position(q, "tip") - e, q0=q, max_iterations=1, trace=True).trace
        assert trace is not None
        rows.append({"case": case, "strategy": strategy, "longest": float(trace.step_length[0])})
    return rows


def compute(quick: bool) -> list[Row]:
    """Rows of the families, the iiwa, and single steps."""
    count = 10 if quick else 200
    rows = []
    for strategy in STRATEGIES:
        ik = jtik.InverseKinematics(ARM, jtik.FrameTask("tip"), strategy=METHODS[strategy])
        rows += [solved(family, strategy, ik, list(problems(family, count))) for family in FAMILIES]
        for name, deviation in TURNED.items():
            rows.append(solved(f"off the axes {name}", strategy, ik, turned(deviation, count)))
    robot, given = upright(count // 2)
    for strategy in STRATEGIES:
        ik = jtik.InverseKinematics(robot, jtik.FrameTask("tip"), strategy=METHODS[strategy], limits=False)
        rows.append(solved("iiwa14, upright", strategy, ik, given))
    return rows + along("error along the weak direction", 0.0) + along("error at 45 degrees", math.pi / 4)


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """Statements about these rows, and whether they hold."""
    at = by_key(rows, ["case", "strategy"])
    off_axes = [f"off the axes {name}" for name in TURNED]
    near = (*FAMILIES[:2], *off_axes, "iiwa14, upright")

    def of(case: str, strategy: str, column: str) -> float:
        return float(at[f"{case} | {strategy}"][column])

    weak, across = "error along the weak direction", "error at 45 degrees"
    return {
        "with S after alpha every step of the transpose is at most 0.5 rad": all(
            of(family, "transpose", "longest_of_all") <= LIMIT * (1 + 1e-9) for family in (*near, FAMILIES[2])
        ),
        "with backtracking V never rises": all(
            of(family, "transpose", "rises") == 0 for family in (*near, FAMILIES[2])
        ),
        "undamped Newton steps exceed 2 rad there and raise V in most solves": all(
            of(family, "newton, undamped", "longest") > 2 and of(family, "newton, undamped", "rises") > 50
            for family in (*FAMILIES[:2], *off_axes)
        ),
        "Newton with the same limit raises V in none of the nearly straight families, and is faster": all(
            of(family, "newton, Q limit", "rises") == 0
            and of(family, "newton, Q limit", "iterations") < of(family, "transpose", "iterations")
            for family in (*FAMILIES[:2], *off_axes)
        ),
        "off the axes, limited Newton and the hybrid reach every target in no more iterations than along them": all(
            of(family, strategy, "reached") == 100
            and of(family, strategy, "iterations") <= of("near-straight 1e-3", strategy, "iterations")
            for family in off_axes
            for strategy in ("newton, Q limit", "hybrid")
        ),
        "and the decrease of V that they predict is that of the linear model": all(
            of(family, strategy, "predicted") < PREDICTED
            for family in off_axes
            for strategy in ("newton, undamped", "newton, Q limit", "hybrid")
        ),
        "at the boundary the transpose reaches no target": of("boundary 9.999", "transpose", "reached") == 0,
        "at the boundary Newton and the hybrid reach every target": all(
            of("boundary 9.999", strategy, "reached") == 100
            for strategy in ("newton, undamped", "newton, Q limit", "hybrid")
        ),
        "only the hybrid does so without raising V": of("boundary 9.999", "hybrid", "rises") == 0
        and of("boundary 9.999", "newton, Q limit", "rises") > 0,
        "alpha alone: along the weak direction the step is Newton's, thousands of radians": math.isclose(
            of(weak, "transpose, alpha only", "longest"), of(weak, "newton, undamped", "longest"), rel_tol=1e-6
        )
        and of(weak, "transpose, alpha only", "longest") > 1000,
        "alpha alone: at 45 degrees it is below a tenth of a radian": of(across, "transpose, alpha only", "longest")
        < 0.1,
        "the limit bounds both": all(
            of(case, strategy, "longest") <= LIMIT * (1 + 1e-9)
            for case in (weak, across)
            for strategy in ("transpose", "newton, Q limit", "hybrid")
        ),
    }


SCRIPT = Script(
    name="near_singular",
    keys=("case", "strategy"),
    tolerances={
        "longest": Within(relative=0.05),
        "longest_of_all": Within(relative=0.5),
        "rises": SHARE,
        "reached": SHARE,
        "iterations": MEDIAN,
        "predicted": Within(absolute=PREDICTED),
    },
    compute=compute,
    statements=statements,
)

if __name__ == "__main__":
    sys.exit(SCRIPT.main(__doc__))

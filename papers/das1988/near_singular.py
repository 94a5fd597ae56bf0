"""Near singular poses: is the transpose method tractable there, and Newton's unsuitable?

Ten links bent by 1e-3 and by 1e-6 rad, targets a millimetre inside the reach, and an upright KUKA iiwa: longest step,
share of solves in which V rises, share of targets reached. Then single steps where sigma_2 of J is 1e-4, with the
error along the weak direction and at 45 degrees to it: what a variable alpha alone is worth.
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
LAWS = ("transpose, alpha only", "transpose", "newton, undamped", "newton, Q limit", "hybrid")
FAMILIES = ("near-straight 1e-3", "near-straight 1e-6", "boundary 9.999")
LIMIT = 0.5
"""Of Q, where a law has one [rad]."""
WEAK = 1e-4
"""The least singular value of J in the second half [m/rad]."""

Given = list[tuple[Array, Array]]


def solved(family: str, law: str, ik: jtik.InverseKinematics, given: Given) -> Row:
    """longest: median over solves of the longest step [rad]; longest_of_all. rises: solves in which V rose [%].

    reached: targets reached to 1e-6 m in 1000 iterations [%]. iterations: median.
    """
    longest, rose, spent = [], [], []
    for q0, target in given:
        solution = ik.solve(target, q0=q0, trace=True)
        assert solution.trace is not None
        moving = solution.trace.escaped == 0
        longest.append(float(solution.trace.step_length[moving].max()))
        rose.append(raised(solution.trace))
        spent.append(solution.iterations if solution.position_error <= 1e-6 else math.inf)
    return {
        "case": family,
        "law": law,
        "longest": median(longest),
        "longest_of_all": max(longest),
        "rises": percent(rose),
        "reached": percent(math.isfinite(each) for each in spent),
        "iterations": median(spent),
    }


def upright(count: int) -> tuple[jtik.Robot, Given]:
    """An iiwa about 1e-3 rad from its stretched pose, where J of its position loses rank; targets straight below."""
    robot = jtik.Robot.builtin("iiwa14")
    rng = np.random.default_rng(14)
    top = robot.position(np.zeros(robot.n))
    return robot, [(1e-3 * rng.standard_normal(robot.n), top - (0.0, 0.0, rng.uniform(0.2, 0.7))) for _ in range(count)]


def weak_pose() -> Array:
    """Ten links on an arc so flat that the least singular value of J is 1e-4."""

    def sigma(bend: float) -> float:
        return float(np.linalg.svd(ARM.jacobian(np.full(10, bend), "tip")[:2], compute_uv=False)[1]) - WEAK

    return np.full(10, brentq(sigma, 1e-9, 1e-2, xtol=1e-16))


def along(case: str, share: float) -> list[Row]:
    """One step of each method, the error of 1 m at that angle to the weak direction [rad]."""
    q = weak_pose()
    U = np.linalg.svd(ARM.jacobian(q, "tip")[:2])[0]
    e = math.cos(share) * U[:, 1] + math.sin(share) * U[:, 0]
    rows: list[Row] = []
    for law in LAWS:
        ik = jtik.InverseKinematics(ARM, jtik.FrameTask("tip"), strategy=METHODS[law])
        trace = ik.solve(ARM.position(q, "tip") - e, q0=q, max_iterations=1, trace=True).trace
        assert trace is not None
        rows.append({"case": case, "law": law, "longest": float(trace.step_length[0])})
    return rows


def compute(quick: bool) -> list[Row]:
    """Families, the iiwa, single steps."""
    count = 10 if quick else 200
    rows = []
    for law in LAWS:
        ik = jtik.InverseKinematics(ARM, jtik.FrameTask("tip"), strategy=METHODS[law])
        rows += [solved(family, law, ik, list(problems(family, count))) for family in FAMILIES]
    robot, given = upright(count // 2)
    for law in LAWS:
        ik = jtik.InverseKinematics(robot, jtik.FrameTask("tip"), strategy=METHODS[law], limits=False)
        rows.append(solved("iiwa14, upright", law, ik, given))
    return rows + along("error along the weak direction", 0.0) + along("error at 45 degrees", math.pi / 4)


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """What these rows show."""
    at = by_key(rows, ["case", "law"])
    near = (*FAMILIES[:2], "iiwa14, upright")

    def of(case: str, law: str, column: str) -> float:
        return float(at[f"{case} | {law}"][column])

    weak, across = "error along the weak direction", "error at 45 degrees"
    return {
        "with S after alpha every step of the transpose is at most 0.5 rad": all(
            of(family, "transpose", "longest_of_all") <= LIMIT * (1 + 1e-9) for family in (*FAMILIES, near[2])
        ),
        "with backtracking V never rises": all(
            of(family, "transpose", "rises") == 0 for family in (*FAMILIES, near[2])
        ),
        "undamped Newton steps are longer than 2 rad there and raise V in most solves": all(
            of(family, "newton, undamped", "longest") > 2 and of(family, "newton, undamped", "rises") > 50
            for family in FAMILIES[:2]
        ),
        "Newton with the same limit raises V in none of the nearly straight families, and is faster": all(
            of(family, "newton, Q limit", "rises") == 0
            and of(family, "newton, Q limit", "iterations") < of(family, "transpose", "iterations")
            for family in FAMILIES[:2]
        ),
        "at the boundary the transpose arrives nowhere": of("boundary 9.999", "transpose", "reached") == 0,
        "at the boundary Newton and the hybrid arrive everywhere": all(
            of("boundary 9.999", law, "reached") == 100 for law in ("newton, undamped", "newton, Q limit", "hybrid")
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
            of(case, law, "longest") <= LIMIT * (1 + 1e-9)
            for case in (weak, across)
            for law in ("transpose", "newton, Q limit", "hybrid")
        ),
    }


SCRIPT = Script(
    name="near_singular",
    keys=("case", "law"),
    tolerances={
        "longest": Within(relative=0.05),
        "longest_of_all": Within(relative=0.5),
        "rises": SHARE,
        "reached": SHARE,
        "iterations": MEDIAN,
    },
    compute=compute,
    statements=statements,
)

if __name__ == "__main__":
    sys.exit(SCRIPT.main(__doc__))

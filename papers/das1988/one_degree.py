"""Equality of the transpose step and Newton's step for one degree of freedom, and their local agreement.

For one joint the transpose step with the optimal alpha is Newton's step. This also holds for any number of joints if
the task has one row, or if the error is an eigenvector of J J'. It does not hold for two rows in general. "Locally"
both methods produce the same result: from an error of size eps they end at postures that differ by order eps^2. The
transpose method converges linearly, with a factor of at most (kappa - 1)/(kappa + 1) for each step, kappa = cond(J)^2,
and Newton's method quadratically.
"""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Callable, Sequence

import numpy as np
from claim import AS_IT_TURNS, Row, Script, Within, by_key, median, percent
from five_families import ARM

import jtik
from jtik_formulations import Newton, Transpose

Array = np.ndarray
STRATEGIES = {
    "transpose": Transpose(q_limit=math.inf, backtracking=False),
    "newton": Newton(q_limit=math.inf, backtracking=False),
}
SIZES = (0.1, 0.01, 0.001)
"""Initial errors [m]."""


ONE_STEP = {"max_iterations": 1, "trace": True, "position_tolerance": 1e-12, "jump_limit": AS_IT_TURNS}
"""Options of a solve of which only the first step counts."""


def steps(robot: jtik.Robot, task: jtik.FrameTask, draw: Callable[[np.random.Generator], tuple], count: int) -> Row:
    """Compare first steps on random problems.

    Columns:
        difference: largest |dq_T - dq_N| / |dq_N|.
        typical: its median.
    """
    solvers = {
        name: jtik.InverseKinematics(robot, task, strategy=strategy, limits=False)
        for name, strategy in STRATEGIES.items()
    }
    rng = np.random.default_rng(1)
    differences = []
    for _ in range(count):
        q0, target = draw(rng)
        both = []
        for ik in solvers.values():
            trace = ik.solve(target, q0=q0, **ONE_STEP).trace
            assert trace is not None
            both.append(trace.q[1] - trace.q[0])
        differences.append(float(np.linalg.norm(both[0] - both[1]) / np.linalg.norm(both[1])))
    return {"difference": max(differences), "typical": median(differences)}


def equality(count: int) -> list[Row]:
    """Rows for one joint, one task row, an eigenvector, and two task rows."""

    def within(robot: jtik.Robot) -> Callable[[np.random.Generator], tuple]:
        return lambda rng: (rng.uniform(-1, 1, robot.n), robot.pose(rng.uniform(-1, 1, robot.n), "tip"))

    def eigenvector(rng: np.random.Generator) -> tuple:
        q = rng.uniform(-1, 1, 10)
        U = np.linalg.svd(ARM.jacobian(q, "tip")[:2])[0]
        return q, ARM.position(q, "tip") - rng.uniform(0.1, 2) * U[:, rng.integers(2)]

    one, panda = jtik.Robot.planar([0.7]), jtik.Robot.builtin("panda")
    x, position = jtik.FrameTask("tip", axes="x"), jtik.FrameTask("tip")
    return [
        {"case": "one joint, one row"} | steps(one, x, within(one), count),
        {"case": "10 joints, one row"} | steps(ARM, x, within(ARM), count),
        {"case": "panda, one row"} | steps(panda, jtik.FrameTask("tip", axes="z"), within(panda), count),
        {"case": "10 joints, error an eigenvector"} | steps(ARM, position, eigenvector, count),
        {"case": "10 joints, two rows"} | steps(ARM, position, within(ARM), count),
    ]


def local(size: float, count: int) -> Row:
    """Solves with targets at distance ``size`` from the tip.

    Columns:
        apart: median of |q_T - q_N| / |q_N - q_0| of the final postures.
        slower: median factor of |e| for each step of the transpose.
        bound_kept: solves in which every factor is below the bound at the end, plus a tenth of its distance to one [%].
        quadratic: median of |e_1| / |e_0|^2 of Newton's first step [1/m].
    """
    solvers = {
        name: jtik.InverseKinematics(ARM, jtik.FrameTask("tip"), strategy=strategy)
        for name, strategy in STRATEGIES.items()
    }
    apart, factors, kept, quadratic = [], [], [], []
    for k in range(count):
        rng = np.random.default_rng([31, k])
        q0 = rng.uniform(-1, 1, 10)
        angle = rng.uniform(-np.pi, np.pi)
        target = ARM.position(q0, "tip") + size * np.array([math.cos(angle), math.sin(angle)])
        ends = {}
        for name, ik in solvers.items():
            solution = ik.solve(target, q0=q0, position_tolerance=1e-10, max_iterations=3000, trace=True)
            assert solution.trace is not None
            ends[name], error = solution.q, solution.trace.error
            if name == "newton":
                quadratic.append(float(error[1] / error[0] ** 2))
                continue
            each = error[1:] / error[:-1]
            sigma = np.linalg.svd(ARM.jacobian(solution.q, "tip")[:2], compute_uv=False)
            kappa = (sigma[0] / sigma[1]) ** 2
            slowest = (kappa - 1) / (kappa + 1)
            factors.append(float(np.exp(np.mean(np.log(each)))))
            kept.append(bool((each <= slowest + 0.1 * (1 - slowest)).all()))
        length = np.linalg.norm(ends["newton"] - q0)
        apart.append(float(np.linalg.norm(ends["transpose"] - ends["newton"]) / length))
    return {
        "case": f"error of {size:g} m",
        "apart": median(apart),
        "slower": median(factors),
        "bound_kept": percent(kept),
        "quadratic": median(quadratic),
    }


def compute(quick: bool) -> list[Row]:
    """Rows of both tests."""
    return equality(10 if quick else 200) + [local(size, 10 if quick else 200) for size in SIZES]


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """Statements about these rows, and whether they hold."""
    at = by_key(rows, ["case"])
    equal = ("one joint, one row", "10 joints, one row", "panda, one row", "10 joints, error an eigenvector")
    near = [at[f"error of {size:g} m"] for size in SIZES]
    return {
        "with one joint the transpose step is Newton's": float(at[equal[0]]["difference"]) < 1e-9,
        "with one task row they are equal for any number of joints": all(
            float(at[case]["difference"]) < 1e-9 for case in equal[1:3]
        ),
        "with an error along an eigenvector of J J' they are equal": float(at[equal[3]]["difference"]) < 1e-9,
        "with two rows they differ": float(at["10 joints, two rows"]["typical"]) > 0.1,
        "locally both end at the same posture: the relative distance shrinks with the error": all(
            5 < float(a["apart"]) / float(b["apart"]) < 20 for a, b in itertools.pairwise(near)
        ),
        "but at different rates: the error of the transpose falls linearly": all(
            0.1 < float(row["slower"]) < 1 for row in near
        ),
        "and that of Newton quadratically": max(float(row["quadratic"]) for row in near)
        < 2 * min(float(row["quadratic"]) for row in near),
        "the transpose satisfies the bound of steepest descent": near[-1]["bound_kept"] > 95,
    }


SCRIPT = Script(
    name="one_degree",
    keys=("case",),
    tolerances={
        "difference": Within(absolute=1e-9, relative=0.05),
        "typical": Within(absolute=1e-9, relative=1e-6),
        "apart": Within(relative=0.02),
        "slower": Within(absolute=0.02),
        "bound_kept": Within(absolute=3.0),
        "quadratic": Within(relative=0.02),
    },
    compute=compute,
    statements=statements,
)

if __name__ == "__main__":
    sys.exit(SCRIPT.main(__doc__))

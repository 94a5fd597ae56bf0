"""The matrix S on revolute, prismatic and mixed arms, and the claim that "the vehicle approaches first".

Appendix B sets S = diag(1 for prismatic joints, 1/Q for revolute joints) if Q, the length of a step of all joints,
exceeds a limit, and inserts S into alpha = N/2D. On revolute arms S cancels. On mixed arms the revolute joints exceed
the limit, too. jtik computes alpha0 with S = I, then S from the revolute part of that step, then takes the smaller of
alpha0 and alpha*(S). There is no criterion here, so the task step is the whole step. The second half
computes the share of the distance that the vehicle covers: with the paper's S, with that of jtik, and with the best
alpha for the prismatic joints given the limited rotation, (|g_p|^2 - a'b) / |a|^2, where a = J_p g_p and b is the
motion of the tip by the revolute joints.
"""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Callable, Sequence

import numpy as np
from claim import AS_IT_TURNS, EXACT, MEDIAN, ROUNDING, SHARE, Row, Script, Within, by_key, median, percent

import jtik
from jtik_formulations import Hybrid, Transpose

Array = np.ndarray
LIMIT = 1.0
"""Limit of Q for all rules [rad], for the printed one [rad and m]: the value for which its 1/Q is continuous."""
FAR = 20.0
"""Distance of the vehicle's target [m]."""
MAX_ITERATIONS = 5000
"""Maximum number of iterations."""
STRATEGIES = {
    "no S": Transpose(q_limit=math.inf, backtracking=False),
    "S as printed": Transpose(rule="paper", q_limit=LIMIT, backtracking=False),
    "S after alpha": Transpose(q_limit=LIMIT, backtracking=False),
}


def mixed(links: int) -> jtik.Robot:
    """Two prismatic joints followed by unit links."""
    return jtik.Robot.vehicle(links)


def rail() -> jtik.Robot:
    """Two prismatic joints along x, followed by three links of 0.1 m."""
    x, link = np.array([1.0, 0.0, 0.0]), np.eye(4)
    link[0, 3] = 0.1
    prismatic, revolute = jtik.JointType.PRISMATIC, jtik.JointType.REVOLUTE
    joints = [
        jtik.Joint("coarse", prismatic, "base", "sledge", axis=x),
        jtik.Joint("fine", prismatic, "sledge", "shoulder", axis=x),
        jtik.Joint("joint1", revolute, "shoulder", "link1"),
        jtik.Joint("joint2", revolute, "link1", "link2", origin=link),
        jtik.Joint("joint3", revolute, "link2", "link3", origin=link),
        jtik.Joint("end", jtik.JointType.FIXED, "link3", "tip", origin=link),
    ]
    return jtik.Robot(joints, name="rail", planar=True)


def steps(robot: jtik.Robot, strategy: str, starts: list[tuple[Array, Array]]) -> list[tuple[Array, float, float]]:
    """First steps dq, their predicted decrease, and V before them."""
    ik = jtik.InverseKinematics(robot, jtik.FrameTask(robot.frame(None)), strategy=STRATEGIES[strategy])
    found = []
    for q0, target in starts:
        trace = ik.solve(target, q0=q0, max_iterations=1, trace=True, jump_limit=AS_IT_TURNS).trace
        assert trace is not None
        found.append((trace.q[1] - trace.q[0], float(trace.predicted_decrease[0]), float(trace.V[0])))
    return found


def prismatic_arm() -> jtik.Robot:
    """Three prismatic joints in the plane."""
    axes = [np.array([math.cos(0.7 * k), math.sin(0.7 * k), 0.0]) for k in range(3)]
    frames = ["base", "carriage1", "carriage2", "tip"]
    joints = [
        jtik.Joint(f"joint{k + 1}", jtik.JointType.PRISMATIC, frames[k], frames[k + 1], axis=axis)
        for k, axis in enumerate(axes)
    ]
    return jtik.Robot(joints, name="prismatic", planar=True)


def kind(name: str, robot: jtik.Robot, count: int) -> Row:
    """One kind of arm with random starts and targets.

    Columns:
        limited: problems in which the revolute part of the step without S exceeds the limit [%].
        printed_limited: problems in which that step exceeds it, of all joints: the printed S is not I [%].
        printed_changes: largest relative difference between the steps with and without the printed S.
        printed_exceeds: of these problems, those in which the revolute part exceeds the limit with the printed S [%].
        printed_longest: largest revolute part with the printed S [rad].
        after_exceeds: limited problems in which the revolute part exceeds the limit with S after alpha [%].
        alone_rises: limited problems in which alpha0 with S, without the minimum, is predicted to raise V [%].
        alone_worst: largest predicted ratio of V after and before such a step.
        after_rises: limited problems in which S after alpha, with the minimum, is predicted to raise V [%].
    """
    rng = np.random.default_rng(19)
    starts = []
    for _ in range(count):
        q0, goal = rng.uniform(-1, 1, robot.n), rng.uniform(-1, 1, robot.n)
        target = robot.position(goal)
        if not robot.rotational.all():
            target = target + rng.uniform(-FAR, FAR, 2)
        starts.append((q0, target))
    revolute = robot.rotational
    unlimited, printed, after = (steps(robot, strategy, starts) for strategy in STRATEGIES)
    ik = jtik.InverseKinematics(robot, jtik.FrameTask(robot.frame(None)), strategy=Hybrid())
    differences, limited, printed_limited, longest, after_longest, alone = [], [], [], [], [], []
    for (dq, _, V), (dq_printed, _, _), (dq_after, _, _), (q0, target) in zip(
        unlimited, printed, after, starts, strict=True
    ):
        differences.append(np.linalg.norm(dq_printed - dq) / np.linalg.norm(dq))
        printed_limited.append(np.linalg.norm(dq) > LIMIT)
        if printed_limited[-1]:
            longest.append(np.linalg.norm(dq_printed[revolute]))
        Q = np.linalg.norm(dq[revolute])
        limited.append(Q > LIMIT)
        if Q <= LIMIT:
            continue
        after_longest.append(np.linalg.norm(dq_after[revolute]))
        at = ik.solve(target, q0=q0, max_iterations=0)
        scaled = np.where(revolute, dq * LIMIT / Q, dq)
        alone.append(float(np.sum((at.error + at.jacobian @ scaled) ** 2)) / 2 / V)
    row: Row = {"case": name, "limited": percent(limited), "printed_limited": percent(printed_limited)}
    row["printed_changes"] = max(differences)
    if any(limited):
        row |= {
            "printed_exceeds": percent(Q > LIMIT * (1 + 1e-9) for Q in longest),
            "printed_longest": max(longest),
            "after_exceeds": percent(Q > LIMIT * (1 + 1e-9) for Q in after_longest),
            "alone_rises": percent(ratio > 1 for ratio in alone),
            "alone_worst": max(alone),
            "after_rises": percent(decrease < 0 for _, decrease, _ in after),
        }
    return row


def best_step(robot: jtik.Robot, q: Array, e: Array, J: Array) -> Array:
    """The step with the rotation limited as in jtik, and the best motion of the prismatic joints for V given it."""
    revolute = robot.rotational
    g = J.T @ e
    alpha = (g @ g) / np.sum((J @ g) ** 2)
    theta = alpha * np.where(revolute, g, 0.0)
    Q = np.linalg.norm(theta)
    if Q <= LIMIT:
        return -alpha * g
    theta *= LIMIT / Q
    g_p = np.where(revolute, 0.0, g)
    a, b = J @ g_p, J @ theta
    return -theta - (g_p @ g_p - a @ b) / (a @ a) * g_p


def approach(links: int, count: int) -> Row:
    """A vehicle with an arm of that many links, 20 m from its target.

    Columns:
        alpha0: median gain of the first step.
        share_printed: median share of the distance that the vehicle covers in the first step, S as printed [%].
        share: the same with S after alpha [%].
        share_exact: the same with the best alpha for the prismatic joints [%].
        iterations_printed: median iterations to 1e-6 m, S as printed.
        iterations: the same with S after alpha.
        iterations_exact: the same with the best alpha for the prismatic joints.
        iterations_hybrid: the same with the dogleg.
        turned: median joint-space distance of the arm from its start when the tip is within 1 m, S after alpha [rad].
        turned_exact: the same with the best alpha for the prismatic joints [rad].
    """
    robot = mixed(links)
    revolute = robot.rotational
    task = jtik.FrameTask("tip")
    solvers = {name: jtik.InverseKinematics(robot, task, strategy=strategy) for name, strategy in STRATEGIES.items()}
    solvers["hybrid"] = jtik.InverseKinematics(robot, task, strategy=Hybrid(explore=False))
    evaluator = solvers["hybrid"]
    shares: dict[str, list[float]] = {"S as printed": [], "S after alpha": [], "exact": []}
    spent: dict[str, list[float]] = {"S as printed": [], "S after alpha": [], "exact": [], "hybrid": []}
    turned: dict[str, list[float]] = {"S after alpha": [], "exact": []}
    alphas = []

    def share(dq: Array, e: Array) -> float:
        """Share of the distance |e| that the prismatic joints move the tip towards the target [%]."""
        return -100 * float(dq[:2] @ e) / float(e @ e)

    for k in range(count):
        rng = np.random.default_rng([23, links, k])
        q0 = np.concatenate([np.zeros(2), rng.uniform(-1, 1, links)])
        direction = rng.uniform(-np.pi, np.pi)
        target = robot.position(q0) + FAR * np.array([math.cos(direction), math.sin(direction)])
        for name in ("S as printed", "S after alpha", "hybrid"):
            solution = solvers[name].solve(target, q0=q0, max_iterations=MAX_ITERATIONS, trace=name != "hybrid")
            spent[name].append(solution.iterations if solution.position_error <= 1e-6 else math.inf)
            if solution.trace is None:
                continue
            q = solution.trace.q
            shares[name].append(share(q[1] - q[0], solution.trace.error[0] * _unit(robot, q0, target)))
            if name == "S after alpha":
                alphas.append(float(solution.trace.alpha[0]))
                close = int(np.argmax(solution.trace.error < 1.0))
                turned[name].append(float(np.linalg.norm((q[close] - q0)[revolute])))
        q = q0.copy()
        close_q = None
        for step in range(MAX_ITERATIONS):
            at = evaluator.solve(target, q0=q, max_iterations=0)
            if at.position_error <= 1e-6:
                break
            if close_q is None and at.position_error < 1.0:
                close_q = q
            dq = best_step(robot, q, at.error, at.jacobian)
            if step == 0:
                shares["exact"].append(share(dq, at.error))
            q = q + dq
        spent["exact"].append(step if at.position_error <= 1e-6 else math.inf)
        turned["exact"].append(float(np.linalg.norm(((q if close_q is None else close_q) - q0)[revolute])))
    return {
        "case": f"vehicle, {links} link{'s' if links > 1 else ''}",
        "alpha0": median(alphas),
        "share_printed": median(shares["S as printed"]),
        "share": median(shares["S after alpha"]),
        "share_exact": median(shares["exact"]),
        "iterations_printed": median(spent["S as printed"]),
        "iterations": median(spent["S after alpha"]),
        "iterations_exact": median(spent["exact"]),
        "iterations_hybrid": median(spent["hybrid"]),
        "turned": median(turned["S after alpha"]),
        "turned_exact": median(turned["exact"]),
    }


def _unit(robot: jtik.Robot, q: Array, target: Array) -> Array:
    e = robot.position(q) - target
    return e / np.linalg.norm(e)


def compute(quick: bool) -> list[Row]:
    """Kinds of arms, and vehicles with arms of increasing length."""
    many, few = (40, 3) if quick else (400, 40)
    robots: dict[str, Callable[[], jtik.Robot]] = {
        "revolute, 10 links": lambda: jtik.Robot.planar(10),
        "prismatic joints only": prismatic_arm,
        "two prismatic joints, 3 unit links": lambda: mixed(3),
        "prismatic joints in line, 3 short links": rail,
    }
    rows = [kind(name, build(), many) for name, build in robots.items()]
    return rows + [approach(links, few) for links in ((1, 2, 3, 5) if quick else (1, 2, 3, 5, 10))]


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """Statements about these rows, and whether they hold."""
    at = by_key(rows, ["case"])
    revolute, prismatic = at["revolute, 10 links"], at["prismatic joints only"]
    both = [at["two prismatic joints, 3 unit links"], at["prismatic joints in line, 3 short links"]]
    vehicles = [row for name, row in at.items() if name.startswith("vehicle")]
    return {
        "on a revolute arm the printed S changes nothing": float(revolute["printed_changes"]) < 1e-12
        and float(revolute["printed_limited"]) > 0,
        "so the limit is never kept there": revolute["printed_exceeds"] == 100,
        "on an arm of prismatic joints S is the identity": prismatic["limited"] == 0
        and float(prismatic["printed_limited"]) > 0
        and prismatic["printed_changes"] == 0,
        "on a mixed arm the printed S changes the step": all(float(row["printed_changes"]) > 0.1 for row in both),
        "but its revolute joints exceed the limit in most of these steps, if the links are long": float(
            both[0]["printed_exceeds"]
        )
        > 50,
        "S after alpha keeps the limit on every arm": all(row["after_exceeds"] == 0 for row in (revolute, *both)),
        "on a mixed arm alpha0 with S can be predicted to raise V": float(both[1]["alone_rises"]) > 0,
        "the smaller of alpha0 and alpha*(S) never is": all(row["after_rises"] == 0 for row in both),
        "the longer the arm, the smaller the share of the distance that the vehicle covers": all(
            float(a["share"]) > float(b["share"]) for a, b in itertools.pairwise(vehicles)
        ),
        "with the best alpha for the prismatic joints the share is larger": all(
            float(row["share_exact"]) > float(row["share"]) for row in vehicles
        ),
        "and the number of iterations is no larger": all(
            float(row["iterations_exact"]) <= float(row["iterations"]) for row in vehicles
        ),
    }


SCRIPT = Script(
    name="matrix_s",
    keys=("case",),
    tolerances={
        "limited": EXACT,
        "printed_limited": EXACT,
        "printed_changes": Within(absolute=1e-9, relative=1e-6),
        "printed_exceeds": EXACT,
        "printed_longest": EXACT,
        "after_exceeds": EXACT,
        "alone_rises": SHARE,
        "alone_worst": EXACT,
        "after_rises": ROUNDING,
        "alpha0": EXACT,
        "share_printed": EXACT,
        "share": EXACT,
        "share_exact": EXACT,
        "iterations_printed": MEDIAN,
        "iterations": MEDIAN,
        "iterations_exact": MEDIAN,
        "iterations_hybrid": MEDIAN,
        "turned": Within(relative=0.05),
        "turned_exact": Within(relative=0.05),
    },
    compute=compute,
    statements=statements,
)

if __name__ == "__main__":
    sys.exit(SCRIPT.main(__doc__))

"""The matrix S on arms of revolute joints, of slides, and of both; and whether "the vehicle approaches first".

Appendix B sets S = diag(1 for slides, 1/Q for revolute joints) where Q, the length of the revolute part of a step,
exceeds a limit, and puts S into alpha = N/2D. On revolute arms that cancels. On mixed arms it does not hold the limit
either. jtik takes alpha0 from S = I, then S, then the smaller of alpha0 and alpha*(S). The second half asks how much of
the way the vehicle covers: with the paper's S, with jtik's, and if alpha were the best for the slides beside the
limited rotation, (|g_p|^2 - a'b) / |a|^2 with a = J_p g_p and b the tip's motion by the revolute joints.
"""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Callable, Sequence

import numpy as np
from claim import EXACT, MEDIAN, ROUNDING, SHARE, Row, Script, Within, by_key, median, percent

import jtik
from jtik_formulations import Hybrid, Transpose

Array = np.ndarray
LIMIT = 1.0
"""Of Q [rad], for all rules: the one for which the printed 1/Q is continuous."""
FAR = 20.0
"""Distance of the vehicle's target [m]."""
MOST = 5000
"""Iterations."""
LAWS = {
    "no S": Transpose(q_limit=math.inf, backtracking=False),
    "S as printed": Transpose(rule="paper", q_limit=LIMIT, backtracking=False),
    "S after alpha": Transpose(q_limit=LIMIT, backtracking=False),
}


def mixed(links: int) -> jtik.Robot:
    """Two slides under that many unit links."""
    return jtik.Robot.vehicle(links)


def rail() -> jtik.Robot:
    """A coarse and a fine slide, both along x, under three links of 0.1 m."""
    x, link = np.array([1.0, 0.0, 0.0]), np.eye(4)
    link[0, 3] = 0.1
    slide, hinge = jtik.JointType.PRISMATIC, jtik.JointType.REVOLUTE
    joints = [
        jtik.Joint("coarse", slide, "base", "sledge", axis=x),
        jtik.Joint("fine", slide, "sledge", "shoulder", axis=x),
        jtik.Joint("joint1", hinge, "shoulder", "link1"),
        jtik.Joint("joint2", hinge, "link1", "link2", origin=link),
        jtik.Joint("joint3", hinge, "link2", "link3", origin=link),
        jtik.Joint("end", jtik.JointType.FIXED, "link3", "tip", origin=link),
    ]
    return jtik.Robot(joints, name="rail", planar=True)


def steps(robot: jtik.Robot, law: str, starts: list[tuple[Array, Array]]) -> list[tuple[Array, float, float]]:
    """First steps dq, and the predicted decrease and V before them."""
    ik = jtik.InverseKinematics(robot, jtik.FrameTask(robot.frame(None)), strategy=LAWS[law])
    found = []
    for q0, target in starts:
        trace = ik.solve(target, q0=q0, max_iterations=1, trace=True).trace
        assert trace is not None
        found.append((trace.q[1] - trace.q[0], float(trace.predicted_decrease[0]), float(trace.V[0])))
    return found


def slides() -> jtik.Robot:
    """Three slides in the plane."""
    axes = [np.array([math.cos(0.7 * k), math.sin(0.7 * k), 0.0]) for k in range(3)]
    frames = ["base", "slide1", "slide2", "tip"]
    joints = [
        jtik.Joint(f"joint{k + 1}", jtik.JointType.PRISMATIC, frames[k], frames[k + 1], axis=axis)
        for k, axis in enumerate(axes)
    ]
    return jtik.Robot(joints, name="slides", planar=True)


def kind(name: str, robot: jtik.Robot, count: int) -> Row:
    """One kind of arm, random starts and targets.

    limited: problems where Q of the step without S is over the limit [%]. printed_changes: largest difference between
    the steps with the printed S and without, relative to the step. printed_exceeds: limited problems where the printed
    S leaves Q over the limit [%]; printed_longest: the longest Q it leaves [rad]. after_exceeds: the same share with S
    after alpha. alone_rises: limited problems where alpha0 with S, without the minimum, is predicted to raise V [%];
    alone_worst: the worst predicted V after / before. after_rises: with the minimum [%].
    """
    rng = np.random.default_rng(19)
    starts = []
    for _ in range(count):
        q0, goal = rng.uniform(-1, 1, robot.n), rng.uniform(-1, 1, robot.n)
        target = robot.position(goal)
        if not robot.rotational.all():
            target = target + rng.uniform(-FAR, FAR, 2)
        starts.append((q0, target))
    turning = robot.rotational
    plain, printed, after = (steps(robot, law, starts) for law in LAWS)
    ik = jtik.InverseKinematics(robot, jtik.FrameTask(robot.frame(None)), strategy=Hybrid())
    differences, limited, longest, after_longest, alone = [], [], [], [], []
    for (dq, _, V), (dq_printed, _, _), (dq_after, _, _), (q0, target) in zip(
        plain, printed, after, starts, strict=True
    ):
        differences.append(np.linalg.norm(dq_printed - dq) / np.linalg.norm(dq))
        Q = np.linalg.norm(dq[turning])
        limited.append(Q > LIMIT)
        if Q <= LIMIT:
            continue
        longest.append(np.linalg.norm(dq_printed[turning]))
        after_longest.append(np.linalg.norm(dq_after[turning]))
        at = ik.solve(target, q0=q0, max_iterations=0)
        scaled = np.where(turning, dq * LIMIT / Q, dq)
        alone.append(float(np.sum((at.error + at.jacobian @ scaled) ** 2)) / 2 / V)
    row: Row = {"case": name, "limited": percent(limited), "printed_changes": max(differences)}
    if longest:
        row |= {
            "printed_exceeds": percent(Q > LIMIT * (1 + 1e-9) for Q in longest),
            "printed_longest": max(longest),
            "after_exceeds": percent(Q > LIMIT * (1 + 1e-9) for Q in after_longest),
            "alone_rises": percent(ratio > 1 for ratio in alone),
            "alone_worst": max(alone),
            "after_rises": percent(decrease < 0 for _, decrease, _ in after),
        }
    return row


def exact(robot: jtik.Robot, q: Array, e: Array, J: Array) -> Array:
    """The step whose rotation is limited as in jtik, and whose slides move as is best for V beside it."""
    turning = robot.rotational
    g = J.T @ e
    alpha = (g @ g) / np.sum((J @ g) ** 2)
    theta = alpha * np.where(turning, g, 0.0)
    Q = np.linalg.norm(theta)
    if Q <= LIMIT:
        return -alpha * g
    theta *= LIMIT / Q
    g_p = np.where(turning, 0.0, g)
    a, b = J @ g_p, J @ theta
    return -theta - (g_p @ g_p - a @ b) / (a @ a) * g_p


def approach(links: int, count: int) -> Row:
    """A vehicle with that many links, its target 20 m away, the arm bent.

    alpha0: median of the gain of the first step. share_printed, share, share_exact: median share of the distance that
    the slides cover in the first step [%] with S as printed, after alpha, and with the best alpha for the slides.
    iterations_printed, iterations, iterations_exact: median to 1e-6 m; iterations_hybrid: of the dogleg. turned,
    turned_exact: median of the angles between the arm's first posture and that when the tip has come within 1 m [rad].
    """
    robot = mixed(links)
    turning = robot.rotational
    task = jtik.FrameTask("tip")
    solvers = {name: jtik.InverseKinematics(robot, task, strategy=law) for name, law in LAWS.items()}
    solvers["hybrid"] = jtik.InverseKinematics(robot, task, strategy=Hybrid())
    look = solvers["hybrid"]
    shares: dict[str, list[float]] = {"S as printed": [], "S after alpha": [], "exact": []}
    spent: dict[str, list[float]] = {"S as printed": [], "S after alpha": [], "exact": [], "hybrid": []}
    turned: dict[str, list[float]] = {"S after alpha": [], "exact": []}
    alphas = []

    def share(dq: Array, e: Array) -> float:
        """Of the distance |e| that the slides bring the tip towards the target [%]."""
        return -100 * float(dq[:2] @ e) / float(e @ e)

    for k in range(count):
        rng = np.random.default_rng([23, links, k])
        q0 = np.concatenate([np.zeros(2), rng.uniform(-1, 1, links)])
        direction = rng.uniform(-np.pi, np.pi)
        target = robot.position(q0) + FAR * np.array([math.cos(direction), math.sin(direction)])
        for name in ("S as printed", "S after alpha", "hybrid"):
            solution = solvers[name].solve(target, q0=q0, max_iterations=MOST, trace=name != "hybrid")
            spent[name].append(solution.iterations if solution.position_error <= 1e-6 else math.inf)
            if solution.trace is None:
                continue
            q = solution.trace.q
            shares[name].append(share(q[1] - q[0], solution.trace.error[0] * _unit(robot, q0, target)))
            if name == "S after alpha":
                alphas.append(float(solution.trace.alpha[0]))
                near = int(np.argmax(solution.trace.error < 1.0))
                turned[name].append(float(np.linalg.norm((q[near] - q0)[turning])))
        q = q0.copy()
        near_q = None
        for step in range(MOST):
            at = look.solve(target, q0=q, max_iterations=0)
            if at.position_error <= 1e-6:
                break
            if near_q is None and at.position_error < 1.0:
                near_q = q
            dq = exact(robot, q, at.error, at.jacobian)
            if step == 0:
                shares["exact"].append(share(dq, at.error))
            q = q + dq
        spent["exact"].append(step if at.position_error <= 1e-6 else math.inf)
        turned["exact"].append(float(np.linalg.norm(((q if near_q is None else near_q) - q0)[turning])))
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
    """Three kinds of arm, and vehicles with longer and longer arms."""
    many, few = (40, 3) if quick else (400, 40)
    robots: dict[str, Callable[[], jtik.Robot]] = {
        "revolute, 10 links": lambda: jtik.Robot.planar(10),
        "slides only": slides,
        "two slides, 3 unit links": lambda: mixed(3),
        "slides in line, 3 short links": rail,
    }
    rows = [kind(name, build(), many) for name, build in robots.items()]
    return rows + [approach(links, few) for links in ((1, 2, 3, 5) if quick else (1, 2, 3, 5, 10))]


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """What these rows show."""
    at = by_key(rows, ["case"])
    revolute, prismatic = at["revolute, 10 links"], at["slides only"]
    both = [at["two slides, 3 unit links"], at["slides in line, 3 short links"]]
    vehicles = [row for name, row in at.items() if name.startswith("vehicle")]
    return {
        "on a revolute arm the printed S changes nothing": float(revolute["printed_changes"]) < 1e-12
        and float(revolute["limited"]) > 0,
        "so that it never holds the limit there": revolute["printed_exceeds"] == 100,
        "on an arm of slides S is the identity": prismatic["limited"] == 0 and prismatic["printed_changes"] == 0,
        "on a mixed arm the printed S changes the step": all(float(row["printed_changes"]) > 0.1 for row in both),
        "but it does not hold the limit there either": all(float(row["printed_exceeds"]) > 0 for row in both),
        "S after alpha holds the limit on every arm": all(row["after_exceeds"] == 0 for row in (revolute, *both)),
        "on a mixed arm alpha0 with S can be predicted to raise V": float(both[1]["alone_rises"]) > 0,
        "the smaller of alpha0 and alpha*(S) never is": all(row["after_rises"] == 0 for row in both),
        "the vehicle covers a smaller share of the way, the longer the arm": all(
            float(a["share"]) > float(b["share"]) for a, b in itertools.pairwise(vehicles)
        ),
        "with the best alpha for the slides it covers more of it": all(
            float(row["share_exact"]) > float(row["share"]) for row in vehicles
        ),
        "and takes no more iterations": all(
            float(row["iterations_exact"]) <= float(row["iterations"]) for row in vehicles
        ),
    }


SCRIPT = Script(
    name="matrix_s",
    keys=("case",),
    tolerances={
        "limited": EXACT,
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

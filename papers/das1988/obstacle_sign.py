"""The sign of the obstacle term, which as printed attracts.

(2.2) subtracts K_obs sum J_j' x_ij / |x_ij|^2 with x_ij "the vector from obstacle i to joint j", so every joint is
attracted by every obstacle. Ten links move through the field of Figure 2.2, with its discs reduced to points. The
script computes the smallest distance of a joint, and of a link, from a point: with zero angles alone, with the printed
sign, and with the repelling sign.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

import casadi
import numpy as np
from claim import EXACT, SHARE, Row, Script, Within, by_key, percent

import jtik
from jtik.demo.measure import clearances
from jtik.demo.scene import Scene
from jtik.plotting.planar import Skeleton
from jtik_formulations import JointCentering, ObstacleAvoidance

SCENE = Scene()
POINTS = [jtik.Point(disc.center) for disc in SCENE.obstacles]
FLOOR = 1e-3
"""Distance below which the attraction stops growing [m], so that H has a lower bound."""
TARGETS = 31
ITERATIONS = 300
"""Maximum iterations at each target."""
GRADIENTS = 200
"""Number of random configurations at which the gradient is evaluated."""


@jtik.criterion
def attraction(q, robot):
    """H whose gradient is the printed term: the sum of ln |x_ij| over joints and obstacles."""
    total = 0
    for frame in robot.moving_frames:
        for point in POINTS:
            away = robot.position(q, frame) - point.center
            total = total + casadi.log(casadi.sumsqr(away) + FLOOR**2) / 2
    return total


CRITERIA = {
    "zero angles": JointCentering(),
    "sign as printed": JointCentering() + 1.0 * attraction,
    "sign that repels": JointCentering() + 1.0 * ObstacleAvoidance(POINTS),
}


def follow(case: str) -> Row:
    """Smallest distance of a joint or the tip, and of a link, from a point along the path [m]; targets reached [%]."""
    ik = jtik.InverseKinematics(SCENE.robot, jtik.FrameTask("tip"), criteria=CRITERIA[case])
    q, path, reached = np.array(SCENE.start), [], []
    for target in SCENE.path(TARGETS):
        solution = ik.solve(target, q0=q, max_iterations=ITERATIONS)
        q = solution.q
        path.append(q)
        reached.append(solution.position_error <= 1e-6)
    joints, links = clearances(Skeleton(SCENE.robot).links(np.array(path)), POINTS)
    return {"case": case, "joints": joints.min(), "links": links.min(), "reached": percent(reached)}


def approaching(case: str) -> float:
    """Share of configurations in which a step along -grad H moves the joint closest to an obstacle towards it [%]."""
    criterion = attraction if case == "sign as printed" else ObstacleAvoidance(POINTS)
    ik = jtik.InverseKinematics(SCENE.robot, jtik.FrameTask("tip"), criteria=criterion)
    skeleton, rng, approaches = Skeleton(SCENE.robot), np.random.default_rng(2), []
    for _ in range(GRADIENTS):
        q = rng.uniform(-1, 1, 10)
        gradient = ik.solve((5.0, 0.0), q0=q, max_iterations=0).gradient
        before, after = (
            clearances(skeleton.links(at), POINTS)[0] for at in (q, q - 1e-6 * gradient / np.linalg.norm(gradient))
        )
        closest = np.unravel_index(np.argmin(before), before.shape)
        approaches.append(after[closest] < before[closest])
    return percent(approaches)


def compute(quick: bool) -> list[Row]:
    """The path through the field for every criterion, and the directions of the gradients."""
    rows = [follow(case) for case in CRITERIA]
    for row in rows[1:3]:
        row["nearer"] = approaching(str(row["case"]))
    return rows


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """Statements about these rows, and whether they hold."""
    at = by_key(rows, ["case"])
    none, printed, repels = (at[case] for case in CRITERIA)
    return {
        "the printed sign moves the closest joint towards its obstacle in most configurations": float(printed["nearer"])
        > 80,
        "the other sign moves it away in most": float(repels["nearer"]) < 20,
        "along the path joints come closer with the printed sign than without avoidance": float(printed["joints"])
        < float(none["joints"]),
        "with the repelling sign joints stay farther away than without avoidance": float(repels["joints"])
        > 2 * float(none["joints"]),
    }


SCRIPT = Script(
    name="obstacle_sign",
    keys=("case",),
    tolerances={
        "joints": Within(absolute=2e-3),
        "links": Within(absolute=2e-3),
        "reached": SHARE,
        "nearer": EXACT,
    },
    compute=compute,
    statements=statements,
    quick_differs=False,
)

if __name__ == "__main__":
    sys.exit(SCRIPT.main(__doc__))

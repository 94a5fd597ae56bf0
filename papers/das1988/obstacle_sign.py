"""The sign of the obstacle term: as printed it attracts.

(2.2) subtracts K_obs sum J_j' x_ij / |x_ij|^2 with x_ij "the vector from obstacle i to joint j": every joint is drawn
to every obstacle. Ten links are led through the field of Figure 2.2, its discs shrunk to points, with zero angles
alone, with the printed sign and with the sign that repels: least distance of a joint, and of a link, from a point.
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
"""Distance at which the attraction stops to grow [m], so that H has a lower bound."""
TARGETS = 31
ITERATIONS = 300
"""At each target."""
FORCES = 200
"""Random configurations at which the force on the joints is looked at."""


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


def led(case: str) -> Row:
    """Along the path: least distance of a joint or the tip, and of a link, from a point [m]; targets reached [%]."""
    ik = jtik.InverseKinematics(SCENE.robot, jtik.FrameTask("tip"), criteria=CRITERIA[case])
    q, way, reached = np.array(SCENE.start), [], []
    for target in SCENE.path(TARGETS):
        solution = ik.solve(target, q0=q, max_iterations=ITERATIONS)
        q = solution.q
        way.append(q)
        reached.append(solution.position_error <= 1e-6)
    joints, links = clearances(Skeleton(SCENE.robot).links(np.array(way)), POINTS)
    return {"case": case, "joints": joints.min(), "links": links.min(), "reached": percent(reached)}


def force(case: str) -> float:
    """Share of configurations where the step -grad H brings the joint nearest to an obstacle nearer to it [%]."""
    criterion = attraction if case == "sign as printed" else ObstacleAvoidance(POINTS)
    ik = jtik.InverseKinematics(SCENE.robot, jtik.FrameTask("tip"), criteria=criterion)
    skeleton, rng, nearer = Skeleton(SCENE.robot), np.random.default_rng(2), []
    for _ in range(FORCES):
        q = rng.uniform(-1, 1, 10)
        slope = ik.solve((5.0, 0.0), q0=q, max_iterations=0).gradient
        before, after = (
            clearances(skeleton.links(at), POINTS)[0] for at in (q, q - 1e-6 * slope / np.linalg.norm(slope))
        )
        least = np.unravel_index(np.argmin(before), before.shape)
        nearer.append(after[least] < before[least])
    return percent(nearer)


def compute(quick: bool) -> list[Row]:
    """The way through the field for every criterion, and the forces."""
    rows = [led(case) for case in CRITERIA]
    for row in rows[1:3]:
        row["nearer"] = force(str(row["case"]))
    return rows


def statements(rows: Sequence[Row]) -> dict[str, bool]:
    """What these rows show."""
    at = by_key(rows, ["case"])
    none, printed, repels = (at[case] for case in CRITERIA)
    return {
        "the printed sign brings the nearest joint nearer in most configurations": float(printed["nearer"]) > 80,
        "the other sign takes it away in most": float(repels["nearer"]) < 20,
        "along the path the printed sign leads joints nearer than no avoidance": float(printed["joints"])
        < float(none["joints"]),
        "the sign that repels keeps joints farther away than none": float(repels["joints"]) > 2 * float(none["joints"]),
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

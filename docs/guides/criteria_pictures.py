"""Draw what each criterion does to an arm: the pictures of docs/guides/criteria.md.

Every picture shows an arm whose end effector is at one target: light where the solve began, dark where it ended.

    python docs/guides/criteria_pictures.py [NAME ...]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import jtik
from jtik.geometry import Obstacle
from jtik.plotting import BACKGROUND, posture_figure
from jtik.robot import Mass
from jtik_formulations import (
    CompactPosture,
    DirectionalManipulability,
    EffectiveMass,
    FrameProximity,
    GravityTorque,
    Isotropy,
    JointCentering,
    KhatibPotential,
    KineticEnergy,
    LimitActivation,
    LimitBarrier,
    LimitCentering,
    LimitNorm,
    LookAt,
    Manipulability,
    MinimumDisplacement,
    ObstacleAvoidance,
    ObstacleBarrier,
    SelfCollision,
    SmallestSingularValue,
    SoftClearance,
    SupportPolygon,
    SwivelAngle,
    Visibility,
)

FOLDER = Path(__file__).parent / "criteria"
WINDOW = (-1.3, 5.3, -1.6, 3.6)  # left, right, bottom, top [m]

ROD = Mass(1.0, [0.5, 0.0, 0.0], np.diag([0.0, 1 / 12, 1 / 12]))
ARM = jtik.Robot.planar(6, lower=-2.2, upper=2.2).with_masses({f"link{k}": ROD for k in range(1, 7)})
START = [1.9, -1.3, -1.1, 0.9, 0.5, -0.9]  # [rad]
ROLLED_UP = [-0.66, 1.27, 1.13, 1.46, 1.03, -0.91]  # [rad], for a criterion that the other posture does not concern
BALL = jtik.Circle(center=(2.2, 0.55), radius=0.45)
FIELD = [
    jtik.Box.at((1.95, 0.7), (0.45, 0.15), 0.4),
    jtik.Capsule((0.2, 2.5), (1.4, 2.1), 0.12),
    jtik.HalfSpace((0.0, -0.9), (0.0, 1.0)),
]

CRITERIA: dict[str, tuple[jtik.Criterion, Sequence[Obstacle]]] = {
    "joint_centering": (JointCentering(preferred=[0.6, -0.4, -0.4, -0.4, -0.4, 0.2]), []),
    "minimum_displacement": (MinimumDisplacement(), []),
    "compact_posture": (CompactPosture(), []),
    "frame_proximity": (FrameProximity("link4", height=-0.8), []),
    "swivel_angle": (SwivelAngle("base", "link4", "tip", angle=-1.57), []),
    "limit_centering": (LimitCentering(), []),
    "limit_barrier": (LimitBarrier(), []),
    "limit_activation": (LimitActivation(), []),
    "limit_norm": (LimitNorm(), []),
    "manipulability": (Manipulability(kind="position"), []),
    "isotropy": (Isotropy(kind="position"), []),
    "smallest_singular_value": (SmallestSingularValue(kind="position"), []),
    "directional_manipulability": (DirectionalManipulability([0.0, 1.0]), []),
    "gravity_torque": (GravityTorque(), []),
    "kinetic_energy": (KineticEnergy(), []),
    "effective_mass": (EffectiveMass([1.0, 0.0]), []),
    "support_polygon": (SupportPolygon([(-0.5, -4.0), (1.0, -4.0), (1.0, 4.0), (-0.5, 4.0)], margin=0.1), []),
    "look_at": (LookAt((1.0, 3.2), "link5"), [jtik.Circle((1.0, 3.2), 0.08)]),
    "visibility": (Visibility((1.0, 3.2), "link5"), [jtik.Circle((1.0, 3.2), 0.08)]),
    "obstacle_avoidance": (ObstacleAvoidance([BALL], bodies="links"), [BALL]),
    "khatib_potential": (KhatibPotential(FIELD, gain=1e-2, influence=0.8, bodies="links"), FIELD),
    "obstacle_barrier": (ObstacleBarrier(FIELD, influence=0.8, bodies="links"), FIELD),
    "soft_clearance": (SoftClearance(FIELD, bodies="links"), FIELD),
    "self_collision": (SelfCollision(influence=0.7, radius=0.1), []),
}
"""Criteria by name, and the obstacles to draw."""


def draw(name: str) -> None:
    """Solve with the criterion from a posture on the target, and write the picture."""
    criterion, obstacles = CRITERIA[name]
    task = jtik.FrameTask("tip", kind="position")
    start = ROLLED_UP if name == "self_collision" else START
    with_it = jtik.InverseKinematics(ARM, task, criteria=criterion, strategy="hybrid+second_order")
    solution = with_it.solve(ARM.position(start), q0=start, max_iterations=3000)
    print(f"{name}: {solution.status.name}, H {criterion(start, ARM):.4g} -> {criterion(solution.q, ARM):.4g}")
    figure = posture_figure(ARM, [start, solution.q], obstacles=obstacles, window=WINDOW, width=4.0)
    figure.savefig(FOLDER / f"{name}.png", dpi=90, facecolor=BACKGROUND)


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for chosen in sys.argv[1:] or CRITERIA:
        draw(chosen)

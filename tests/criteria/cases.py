"""Every criterion of posture, limits, dexterity and visibility on ten links and on the Panda, for tests of all."""

from __future__ import annotations

import numpy as np

from jtik_formulations import (
    CompactPosture,
    DirectionalManipulability,
    EffectiveMass,
    FrameProximity,
    GravityTorque,
    Isotropy,
    KineticEnergy,
    LimitActivation,
    LimitBarrier,
    LimitCentering,
    LimitNorm,
    LookAt,
    Manipulability,
    MinimumDisplacement,
    SmallestSingularValue,
    SupportPolygon,
    SwivelAngle,
    Visibility,
)


def _kind(robot):
    return "position" if robot.dimension == 2 else "pose"


def _elbow(robot):
    return "link6" if robot.dimension == 2 else "panda_link4"


def _along(robot):
    return (1.0, 2.0, -1.0)[: robot.dimension]


def _swivel(robot):
    if robot.dimension == 2:
        return SwivelAngle("base", "link6", "tip", angle=np.pi / 2, floor=1.0)
    return SwivelAngle("panda_link2", "panda_link4", "panda_link6", angle=0.8)


def _support(robot):
    if robot.dimension == 2:
        return SupportPolygon([(-1.0, -2.0), (3.0, -1.0), (2.0, 2.0), (-2.0, 1.0)], margin=0.3)
    frame = "vehicle" if "vehicle" in robot.frame_names else None
    return SupportPolygon([(-0.05, -0.05), (0.02, -0.05), (-0.02, 0.05)], margin=0.03, frame=frame)


CASES = {
    "limit_centering": lambda robot: LimitCentering(),
    "limit_barrier": lambda robot: LimitBarrier(),
    "limit_activation": lambda robot: LimitActivation(),
    "limit_norm": lambda robot: LimitNorm(),
    "manipulability": lambda robot: Manipulability(kind=_kind(robot)),
    "manipulability volume": lambda robot: Manipulability(kind=_kind(robot), measure="volume"),
    "isotropy": lambda robot: Isotropy(kind=_kind(robot)),
    "smallest_singular_value": lambda robot: SmallestSingularValue(kind=_kind(robot)),
    "velocity": lambda robot: DirectionalManipulability([0.6, 0.8, 0.5][: robot.dimension]),
    "force": lambda robot: DirectionalManipulability([0.6, 0.8, 0.5][: robot.dimension], measure="force"),
    "minimum_displacement": lambda robot: MinimumDisplacement(),
    "point": lambda robot: FrameProximity(_elbow(robot), point=(0.4, 0.3, 0.5)[: robot.dimension]),
    "line": lambda robot: FrameProximity(_elbow(robot), line=((0.4, 0.3, 0.5)[: robot.dimension], _along(robot))),
    "plane": lambda robot: FrameProximity(_elbow(robot), plane=((0.4, 0.3, 0.5)[: robot.dimension], _along(robot))),
    "height": lambda robot: FrameProximity(_elbow(robot), height=0.7),
    "swivel_angle": lambda robot: _swivel(robot),
    "compact_posture": lambda robot: CompactPosture(),
    "look_at": lambda robot: LookAt(
        (0.5, 0.4, 0.3)[: robot.dimension], None if robot.dimension == 2 else _elbow(robot)
    ),
    "gravity_torque": lambda robot: GravityTorque(),
    "kinetic_energy": lambda robot: KineticEnergy(),
    "effective_mass": lambda robot: EffectiveMass([0.6, 0.8, 0.5][: robot.dimension]),
    "support_polygon": lambda robot: _support(robot),
    "visibility": lambda robot: Visibility((0.5, 0.4, 0.3)[: robot.dimension], _elbow(robot)),
}
"""Criteria by name, each made for a robot."""

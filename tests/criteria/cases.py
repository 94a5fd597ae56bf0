"""Every criterion of posture, limits, dexterity and visibility on ten links and on the Panda, for tests of all."""

from __future__ import annotations

from jtik_formulations import (
    DirectionalManipulability,
    Isotropy,
    LimitActivation,
    LimitBarrier,
    LimitCentering,
    LimitNorm,
    Manipulability,
    SmallestSingularValue,
)


def _kind(robot):
    return "position" if robot.dimension == 2 else "pose"


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
}
"""Criteria by name, each made for a robot."""

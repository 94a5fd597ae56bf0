"""The scene of the demo: a ten-link arm, seven discs, and the way the tip takes between them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from jtik.criterion.base import CriterionSum
from jtik.geometry import Circle
from jtik.registry import criteria
from jtik.robot import Robot
from jtik.solver import InverseKinematics
from jtik.strategy import Strategy
from jtik.task import FrameTask
from jtik.types import Array

_DISCS = (
    ((1.75, 0.30), 0.55),
    ((4.05, 1.00), 0.60),
    ((6.20, -0.40), 0.60),
    ((8.35, 1.10), 0.55),
    ((4.10, -1.55), 0.60),
    ((6.35, 1.95), 0.65),
    ((8.60, -1.05), 0.50),
)


@dataclass(frozen=True)
class Scene:
    """What Figure 2.2 of the paper shows: ten unit links, a field of obstacles, the tip led through it.

    Attributes:
        robot: the arm.
        obstacles: the discs.
        start: configuration to start from (10,) [rad]: an arc whose tip is in front of the field.
        centering: weight of zero joint angles.
        avoidance: weight of obstacle avoidance.
    """

    robot: Robot = field(default_factory=lambda: Robot.planar(10))
    obstacles: tuple[Circle, ...] = tuple(Circle(center, radius) for center, radius in _DISCS)
    start: tuple[float, ...] = (1.9, *[-0.42] * 9)
    centering: float = 1.0
    avoidance: float = 1.0

    def path(self, count: int) -> Array:
        """Targets of the tip (count, 2) [m]: a wave below the second disc, above the third and below the fourth."""
        x = np.linspace(2.75, 8.8, count)
        return np.stack([x, 0.2 + 0.55 * np.cos(2 * np.pi * (x - 6.25) / 4.4)], axis=1)

    def solver(self, strategy: str | Strategy = "hybrid", *, avoid: bool = True) -> InverseKinematics:
        """Inverse kinematics of the tip's position with zero joint angles and, unless told not to, avoidance."""
        wanted: CriterionSum = self.centering * criteria["joint_centering"]()
        if avoid:
            # what a registered class takes beyond the base class is its own business
            avoidance = criteria["obstacle_avoidance"](self.obstacles, bodies="both")  # type: ignore[call-arg]
            wanted = wanted + self.avoidance * avoidance
        return InverseKinematics(self.robot, FrameTask("tip"), criteria=wanted, strategy=strategy)

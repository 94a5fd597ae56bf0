"""The scene of the demo: a ten-link arm, seven discs, and the path of the end effector between them."""

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

_DISCS = (  # centre and radius [m]
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
    """The scene of Figure 2.2 of the paper: ten unit links, a field of obstacles, a path through it.

    Attributes:
        robot: the arm.
        obstacles: the discs.
        start: configuration to start from (10,) [rad]: an arc that ends in front of the field.
        centering: weight of the criterion "joint_centering".
        avoidance: weight of the criterion "obstacle_avoidance".
    """

    robot: Robot = field(default_factory=lambda: Robot.planar(10))
    obstacles: tuple[Circle, ...] = tuple(Circle(center, radius) for center, radius in _DISCS)
    start: tuple[float, ...] = (1.9, *[-0.42] * 9)
    centering: float = 1.0
    avoidance: float = 1.0

    def path(self, count: int) -> Array:
        """Targets of the end effector: a wave below the second disc, above the third and below the fourth.

        Args:
            count: number of targets.

        Returns:
            Positions (count, 2) [m].
        """
        x = np.linspace(2.75, 8.8, count)
        return np.stack([x, 0.2 + 0.55 * np.cos(2 * np.pi * (x - 6.25) / 4.4)], axis=1)

    def solver(self, strategy: str | Strategy = "hybrid", *, avoid: bool = True) -> InverseKinematics:
        """A solver for the position of the end effector.

        Args:
            strategy: a strategy or its name.
            avoid: whether obstacle avoidance is a criterion beside joint centering.
        """
        wanted: CriterionSum = self.centering * criteria["joint_centering"]()
        if avoid:
            # the base class does not know the arguments of this criterion
            avoidance = criteria["obstacle_avoidance"](self.obstacles, bodies="both")  # type: ignore[call-arg]
            wanted = wanted + self.avoidance * avoidance
        return InverseKinematics(self.robot, FrameTask("tip"), criteria=wanted, strategy=strategy)

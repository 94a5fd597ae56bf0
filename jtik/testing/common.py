"""Helpers shared by the contracts of criteria and strategies."""

from __future__ import annotations

import numpy as np

from jtik.criterion import criterion
from jtik.robot import Robot
from jtik.symbolic import Expression, sumsqr
from jtik.types import Array


def require(condition: bool | np.bool_, message: str) -> None:
    """Raise AssertionError with the message unless the condition holds, also under ``python -O``."""
    if not condition:
        raise AssertionError(message)


@criterion
def posture(q: Expression, robot: Robot, *, preferred: float = 0.2) -> Expression:
    """1/2 |q - preferred|^2 over the revolute and prismatic joints."""
    return sumsqr(q[[int(i) for i in robot.scalar_q]] - preferred) / 2


def moved(robot: Robot, q: Array, dq: Array) -> Array:
    """q after the step dq, clamped to the limits."""
    moved: Array = np.clip(robot.integrate(q, dq), robot.lower, robot.upper)
    return moved

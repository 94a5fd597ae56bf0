"""The configurations at which a contract is checked: ordinary ones, singular ones, and ones at the limits."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from jtik.robot import Robot
from jtik.types import Array

DRAWN = 50
"""Random configurations of which the one nearest to a singular pose counts as near-singular."""


def configurations(robot: Robot, samples: int | Iterable[ArrayLike], generator: np.random.Generator) -> list[Array]:
    """The configurations (nq,) given, or, for a number, that many random ones and those where a criterion may fail.

    These are the neutral one; the one with every joint at 0, or at the limit nearest to 0, where most arms are exactly
    singular; of `DRAWN` random ones that with the worst condition of the Jacobian of the tip; and two with every joint
    at its lower and at its upper limit.

    Args:
        robot: the robot.
        samples: a number, or configurations.
        generator: draws the random ones.
    """
    if not isinstance(samples, int):
        return [robot.configuration(sample, argument="samples") for sample in samples]
    scalar, straight = robot.scalar_q, robot.neutral.copy()
    straight[scalar] = np.clip(0.0, robot.lower, robot.upper)[scalar]
    ends = []
    for limit in (robot.lower, robot.upper):
        end = robot.neutral.copy()
        end[scalar] = np.where(np.isfinite(limit), limit, robot.neutral)[scalar]
        ends.append(end)
    drawn = [robot.random_configuration(generator) for _ in range(DRAWN)]
    return [robot.neutral, straight, max(drawn, key=lambda q: _condition(robot, q)), *ends, *drawn[:samples]]


def _condition(robot: Robot, q: Array) -> float:
    """Ratio of the largest to the smallest singular value of the Jacobian of the tip."""
    values = np.linalg.svd(np.asarray(robot.jacobian(q, robot.tip)), compute_uv=False)
    significant = values[: min(robot.n, 3 if robot.dimension == 2 else 6)]
    return float(significant[0] / max(significant[-1], 1e-300))

"""One-sided joint limits: zero until a joint is near a limit (formulations/limit_activation.md)."""

from __future__ import annotations

from collections.abc import Mapping

from jtik import register_criterion
from jtik.robot import Kinematics
from jtik.symbolic import Expression, fmax
from jtik_formulations.bibliography import MARCHAND_1996
from jtik_formulations.criteria._parts.joint_numbers import JointNumbers
from jtik_formulations.criteria._parts.joint_ranges import JointRangeCriterion
from jtik_formulations.criteria._parts.scalars import number_between

SHORTEST_ZONE = 1e-4
"""Shortest zone, 1 - start, that is divided by."""


@register_criterion("limit_activation")
class LimitActivation(JointRangeCriterion):
    """H = sum of w_i max(0, (|x_i| - start) / (1 - start))^3, x_i the deviation in halves of the range.

    H has no unit. A joint adds nothing while it is nearer to the middle than ``start``, and w_i at a limit. Gradient
    and Hessian are continuous. Prefer it where joints shall move freely and only keep off the limits; prefer
    `LimitBarrier` where the middle itself is preferred.

    Live parameters: ``limit_activation.lower``, ``.upper`` (nq,) [rad] or [m], ``.weights`` (nq,) and ``.start``.

    Args:
        lower: lower limits [rad] or [m], in any form of `Robot.joint_values`; the robot's by default.
        upper: upper limits [rad] or [m]; the robot's by default.
        weights: non-negative factors; by default 1 for a joint with two limits and 0 for any other.
        start: deviation from which a joint counts, as a fraction of half its range; between 0 and 1.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when a weight is negative, ``start`` is out of range, limits are not finite or cross, or a size
            does not fit the robot.
        UnknownNameError: when a dict names a joint that does not exist.

    Source: Marchand, Chaumette and Rizzo (1996), the activation zone; here with a cube in place of a square.
    """

    name = "limit_activation"
    summary = "pushes joints off their limits, zero until they are near"
    source = "after Marchand, Chaumette and Rizzo 1996"
    bibtex = MARCHAND_1996
    non_negative_parameters = ("weights", "start")

    def __init__(
        self,
        *,
        lower: JointNumbers | None = None,
        upper: JointNumbers | None = None,
        weights: JointNumbers | None = None,
        start: float = 0.8,
        name: str = "limit_activation",
    ) -> None:
        super().__init__(lower, upper, weights, name)
        self._start = number_between("start", start, 0, 1)

    def options(self) -> Mapping[str, float]:
        """The deviation from which a joint counts."""
        return {"start": self._start}

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """Sum of w_i max(0, (|x_i| - start) / (1 - start))^3, one term for each limit."""
        x, start = self.deviations(kinematics, parameters), parameters["start"]
        zone = fmax(1 - start, SHORTEST_ZONE)
        high, low = fmax(0, x - start) / zone, fmax(0, -x - start) / zone
        return self.weighted_sum(kinematics, parameters, high**3 + low**3)

"""Centring within the limits: squared deviations from the middle of each range (formulations/limit_centering.md)."""

from __future__ import annotations

from collections.abc import Mapping

from jtik import register_criterion
from jtik.robot import Kinematics
from jtik.symbolic import Expression
from jtik_formulations.bibliography import LIEGEOIS_1977
from jtik_formulations.criteria._parts.joint_numbers import JointNumbers
from jtik_formulations.criteria._parts.joint_ranges import JointRangeCriterion


@register_criterion("limit_centering")
class LimitCentering(JointRangeCriterion):
    """H = 1/8 of the weighted mean of x_i^2, x_i the deviation from the middle of the range in halves of the range.

    With equal weights this is 1/(2n) sum ((q_i - middle_i) / (upper_i - lower_i))^2. H has no unit; it is 0 in the
    middle of all ranges, 1/8 where all joints are at a limit. Prefer it as a weak and smooth preference for the middle;
    prefer `LimitBarrier` where joints shall keep away from their limits, and `LimitNorm` for the one joint that is
    closest to a limit.

    Live parameters: ``limit_centering.lower``, ``.upper`` (nq,) [rad] or [m], and ``.weights`` (nq,).

    Args:
        lower: lower limits [rad] or [m], in any form of `Robot.joint_values`; the robot's by default.
        upper: upper limits [rad] or [m]; the robot's by default.
        weights: non-negative factors; by default 1 for a joint with two limits and 0 for any other.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when a weight is negative, limits are not finite or cross, or a size does not fit the robot.
        UnknownNameError: when a dict names a joint that does not exist.

    Source: Liegeois (1977).
    """

    name = "limit_centering"
    summary = "pulls joints to the middle of their ranges"
    source = "Liegeois 1977"
    bibtex = LIEGEOIS_1977

    def __init__(
        self,
        *,
        lower: JointNumbers | None = None,
        upper: JointNumbers | None = None,
        weights: JointNumbers | None = None,
        name: str = "limit_centering",
    ) -> None:
        super().__init__(lower, upper, weights, name)

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """1/8 of the weighted mean of x_i^2."""
        return self.weighted_mean(kinematics, parameters, self.deviations(kinematics, parameters) ** 2) / 8

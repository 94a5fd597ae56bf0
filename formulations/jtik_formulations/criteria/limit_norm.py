"""The p-norm of the deviations from the middle of the ranges (formulations/limit_norm.md)."""

from __future__ import annotations

from collections.abc import Mapping

from jtik import register_criterion
from jtik.robot import Kinematics
from jtik.symbolic import Expression, fmax, if_else, sum1
from jtik_formulations.bibliography import KLEIN_1984
from jtik_formulations.criteria._parts.joint_numbers import JointNumbers
from jtik_formulations.criteria._parts.joint_ranges import JointRangeCriterion
from jtik_formulations.criteria._parts.scalars import number_from_to

SMALLEST_POWER, LARGEST_POWER = 2.0, 64.0
"""Range of p. A smaller one is not twice differentiable at zero; at a larger one the norm is the largest deviation
within 7 % for any arm of up to 80 joints, and its Hessian is larger than is useful.
"""

SMOOTHING = 1e-2
"""Length added to every deviation in quadrature: the norm itself has a kink where all joints are in the middle."""


@register_criterion("limit_norm")
class LimitNorm(JointRangeCriterion):
    """H = (weighted mean of (x_i^2 + 0.01^2)^(p/2))^(1/p), x_i the deviation in halves of the range.

    H has no unit: about 0 in the middle of all ranges, 1 where all joints are at a limit. With a larger p it follows
    the joint that is nearest to a limit. Prefer it to make the worst joint better at the expense of the others.

    Live parameters: ``limit_norm.lower``, ``.upper`` (nq,) [rad] or [m], ``.weights`` (nq,) and ``.power``.

    Args:
        lower: lower limits [rad] or [m], in any form of `Robot.joint_values`; the robot's by default.
        upper: upper limits [rad] or [m]; the robot's by default.
        weights: non-negative factors; by default 1 for a joint with two limits and 0 for any other.
        power: p, at least 2 and at most 64.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when a weight is negative, the power is out of range, limits are not finite or cross, or a size
            does not fit the robot.
        UnknownNameError: when a dict names a joint that does not exist.

    Source: Klein (1984), the largest deviation; the p-norm is its usual smooth form.
    """

    name = "limit_norm"
    summary = "reduces the deviation of the joint that is farthest from the middle of its range"
    source = "after Klein 1984"
    bibtex = KLEIN_1984
    non_negative_parameters = ("weights", "power")

    def __init__(
        self,
        *,
        lower: JointNumbers | None = None,
        upper: JointNumbers | None = None,
        weights: JointNumbers | None = None,
        power: float = 8.0,
        name: str = "limit_norm",
    ) -> None:
        super().__init__(lower, upper, weights, name)
        self._power = number_from_to("power", power, SMALLEST_POWER, LARGEST_POWER)

    def options(self) -> Mapping[str, float]:
        """The power p."""
        return {"power": self._power}

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """The smoothed p-norm of the deviations."""
        p = fmax(parameters["power"], SMALLEST_POWER)
        squared = self.deviations(kinematics, parameters) ** 2 + SMOOTHING**2
        mean = self.weighted_mean(kinematics, parameters, squared ** (p / 2))
        counted = sum1(parameters["weights"][[int(i) for i in kinematics.robot.scalar_q]]) > 0
        return counted * if_else(counted, mean, 1) ** (1 / p)  # the root of 0 has no finite derivative

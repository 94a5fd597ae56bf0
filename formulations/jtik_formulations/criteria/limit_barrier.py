"""Barrier at the joint limits: the reciprocal of the distances to both limits (formulations/limit_barrier.md)."""

from __future__ import annotations

from collections.abc import Mapping

from jtik import register_criterion
from jtik.robot import Kinematics
from jtik.symbolic import Expression, fmax, fmin
from jtik_formulations.bibliography import CHAN_DUBEY_1995, ZGHAL_1990
from jtik_formulations.criteria._parts.joint_numbers import JointNumbers
from jtik_formulations.criteria._parts.joint_ranges import JointRangeCriterion
from jtik_formulations.criteria._parts.scalars import number_between

SMALLEST_MARGIN = 1e-4
"""Smallest margin that is used: the curvature at the limit is about the inverse of its cube."""


@register_criterion("limit_barrier")
class LimitBarrier(JointRangeCriterion):
    """H = sum of w_i (upper_i - lower_i)^2 / (4 (upper_i - q_i) (q_i - lower_i)), continued beyond the limits.

    H has no unit. A joint adds 1 in the middle of its range, and more without bound towards a limit. Within ``margin``
    of a limit, and beyond it, the term is continued by its second-order expansion in the squared deviation: H, its
    gradient and its Hessian are continuous and finite everywhere, and H still rises outwards. Prefer it where joints
    shall keep away from limits all the time; prefer `LimitActivation` where a joint shall move freely until it is near
    a limit.

    Live parameters: ``limit_barrier.lower``, ``.upper`` (nq,) [rad] or [m], ``.weights`` (nq,) and ``.margin``.

    Args:
        lower: lower limits [rad] or [m], in any form of `Robot.joint_values`; the robot's by default.
        upper: upper limits [rad] or [m]; the robot's by default.
        weights: non-negative factors; by default 1 for a joint with two limits and 0 for any other.
        margin: fraction of half the range, before a limit, in which the term is continued; between 0 and 1.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when a weight is negative, the margin is out of range, limits are not finite or cross, or a size
            does not fit the robot.
        UnknownNameError: when a dict names a joint that does not exist.

    Source: Zghal, Dubey and Euler (1990); Chan and Dubey (1995).
    """

    name = "limit_barrier"
    summary = "rises steeply towards joint limits, finite at and beyond them"
    source = "Zghal, Dubey and Euler 1990; Chan and Dubey 1995"
    bibtex = "\n".join((ZGHAL_1990, CHAN_DUBEY_1995))
    non_negative_parameters = ("weights", "margin")

    def __init__(
        self,
        *,
        lower: JointNumbers | None = None,
        upper: JointNumbers | None = None,
        weights: JointNumbers | None = None,
        margin: float = 0.02,
        name: str = "limit_barrier",
    ) -> None:
        super().__init__(lower, upper, weights, name)
        self._margin = number_between("margin", margin, 0, 1)

    def options(self) -> Mapping[str, float]:
        """The margin."""
        return {"margin": self._margin}

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """Sum of w_i / (1 - x_i^2), beyond x_i^2 = (1 - margin)^2 its second-order expansion in x_i^2."""
        squared = self.deviations(kinematics, parameters) ** 2
        inside = fmin(squared, (1 - fmax(parameters["margin"], SMALLEST_MARGIN)) ** 2)
        beyond = squared - inside
        reciprocal = 1 / (1 - inside)
        share = beyond * reciprocal
        return self.weighted_sum(kinematics, parameters, reciprocal * (1 + share + share**2))

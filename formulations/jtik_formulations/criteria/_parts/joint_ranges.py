"""Base of the criteria on the place of each joint within its range."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jtik import Criterion
from jtik.arguments import name as read_name
from jtik.criterion.short_repr import call_text
from jtik.errors import ArgumentError
from jtik.robot import JointType, Kinematics, Robot
from jtik.symbolic import Expression, dot, fmax, sum1
from jtik.types import Array
from jtik_formulations.criteria._parts.joint_numbers import (
    JointNumbers,
    joint_numbers,
    non_negative_joint_numbers,
)

SHORTEST_RANGE = 1e-9
"""Shortest range [rad] or [m] that is divided by."""

SMALLEST_SUM = 1e-9
"""Smallest sum of weights that is divided by."""


class JointRangeCriterion(Criterion):
    """Base: H is a function of x_i, the deviation of joint i from the middle of its range, -1 and 1 at its limits.

    Only revolute and prismatic joints count.

    Args:
        lower: lower limits [rad] or [m]; the robot's by default.
        upper: upper limits [rad] or [m]; the robot's by default.
        weights: non-negative factors w_i. By default 1 for a joint with two limits, of the robot or of both
            arguments, and 0 for any other.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when a weight is negative, limits are not finite or cross, or a size does not fit the robot.
        UnknownNameError: when a dict names a joint that does not exist.
    """

    joint_parameters = ("lower", "upper", "weights")
    non_negative_parameters: ClassVar[tuple[str, ...]] = ("weights",)

    def __init__(
        self, lower: JointNumbers | None, upper: JointNumbers | None, weights: JointNumbers | None, name: str
    ) -> None:
        self._lower = None if lower is None else joint_numbers("lower", lower)
        self._upper = None if upper is None else joint_numbers("upper", upper)
        self._weights = None if weights is None else non_negative_joint_numbers("weights", weights)
        self.name = read_name("name", name)

    def __repr__(self) -> str:
        values = {"lower": self._lower, "upper": self._upper, "weights": self._weights, **self.options()}
        shown: dict[str, object] = {key: value for key, value in values.items() if value is not None}
        if self.name != type(self).name:
            shown["name"] = self.name
        return call_text(type(self).__name__, **shown)

    def options(self) -> Mapping[str, float]:
        """Names and first values of the live parameters besides limits and weights."""
        return {}

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Limits and weights, one value for each entry of q, and the criterion's own parameters."""
        low, high = _open_ranges(robot)
        lower = low if self._lower is None else robot.joint_values(self._lower, default=low, argument="lower")
        upper = high if self._upper is None else robot.joint_values(self._upper, default=high, argument="upper")
        scalar = robot.scalar_q
        if np.any(lower[scalar] > upper[scalar]):
            i = scalar[np.argmax(lower[scalar] > upper[scalar])]
            raise ArgumentError("lower", f"{lower[i]:g} at index {i}", f"at most the upper limit {upper[i]:g}")
        return {"lower": lower, "upper": upper, "weights": self._weights_on(robot), **self.options()}

    def deviations(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """x (k, 1): the deviation of each revolute and prismatic joint from the middle, in halves of its range."""
        scalar = [int(i) for i in kinematics.robot.scalar_q]
        lower, upper = parameters["lower"][scalar], parameters["upper"][scalar]
        return (2 * kinematics.q[scalar] - lower - upper) / fmax(upper - lower, SHORTEST_RANGE)

    def weighted_sum(
        self, kinematics: Kinematics, parameters: Mapping[str, Expression], terms: Expression
    ) -> Expression:
        """The sum of w_i terms_i."""
        return dot(parameters["weights"][[int(i) for i in kinematics.robot.scalar_q]], terms)

    def weighted_mean(
        self, kinematics: Kinematics, parameters: Mapping[str, Expression], terms: Expression
    ) -> Expression:
        """The mean of the terms with the weights w_i; 0 where all weights are 0."""
        weights = parameters["weights"][[int(i) for i in kinematics.robot.scalar_q]]
        return dot(weights, terms) / fmax(sum1(weights), SMALLEST_SUM)

    def _weights_on(self, robot: Robot) -> Array:
        if self._weights is None:
            limited = np.isfinite(robot.lower) & np.isfinite(robot.upper)
            given = _named(robot, self._lower, limited) & _named(robot, self._upper, limited)
            scalar = np.isin(np.arange(robot.nq), robot.scalar_q)
            return np.where(scalar & (limited | given), 1.0, 0.0)
        return robot.joint_values(self._weights, default=1.0, argument="weights")


def _named(robot: Robot, given: Any, limited: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """For each entry of q whether a limit is given for it."""
    if given is None:
        return limited
    if isinstance(given, Mapping):
        return robot.joint_values(dict.fromkeys(given, 1.0), default=limited.astype(float)) > 0
    return np.ones(robot.nq, dtype=bool)


def _open_ranges(robot: Robot) -> tuple[Array, Array]:
    """Limits (nq,), where a missing one is replaced by one at 2 pi or 2 m from the other, or at pi or 1 m from zero."""
    width = np.ones(robot.nq)
    for joint in robot.independent_joints:
        if joint.type is JointType.REVOLUTE:
            width[robot.q_slice(joint.name)] = np.pi
    has_lower, has_upper = np.isfinite(robot.lower), np.isfinite(robot.upper)
    lower = np.where(has_lower, robot.lower, np.where(has_upper, robot.upper - 2 * width, -width))
    upper = np.where(has_upper, robot.upper, lower + 2 * width)
    return lower, upper

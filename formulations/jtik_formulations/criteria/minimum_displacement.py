"""Minimum displacement from a reference configuration (formulations/minimum_displacement.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from jtik import Criterion, register_criterion
from jtik.arguments import name as read_name
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, dot
from jtik.types import Array
from jtik_formulations.bibliography import WHITNEY_1969
from jtik_formulations.criteria._parts.displacement import displacement
from jtik_formulations.criteria._parts.joint_numbers import configuration_numbers, non_negative_joint_numbers
from jtik_formulations.criteria._parts.shown import shown


@register_criterion("minimum_displacement")
class MinimumDisplacement(Criterion):
    """H = 1/2 sum of k_i d_i^2, d the displacement of the joints from a reference configuration.

    The unit of H is that of k times [rad^2] or [m^2]. All joints count, ball and free joints, too: of a rotation by the
    angle theta about the axis a, d is 2 sin(theta / 2) a, which is smooth at every angle. Prefer it to change a posture
    as little as a task permits: assign the present configuration to the parameter ``reference`` before each solve.
    `JointCentering` has one stiffness for each entry of q, and leaves ball and free joints out.

    Live parameters: ``minimum_displacement.reference`` (nq,) and ``minimum_displacement.stiffness`` (n,).

    Args:
        reference: configuration [rad] and [m], as ``robot.configuration`` accepts it; by default ``robot.home``, where
            a solve starts by default.
        stiffness: non-negative, one number, or one for each velocity entry (n,), or a dict by joint name.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when a stiffness is negative or not finite, or a size does not fit the robot.
        UnknownNameError: when a dict names a joint that does not exist.

    Source: Whitney (1969), for the increments; here for the whole displacement.
    """

    name = "minimum_displacement"
    summary = "stays near a reference configuration, by all joints"
    source = "after Whitney 1969"
    bibtex = WHITNEY_1969
    joint_parameters = ("reference",)
    non_negative_parameters = ("stiffness",)

    def __init__(
        self,
        reference: ArrayLike | Mapping[str, ArrayLike] | None = None,
        stiffness: ArrayLike | Mapping[str, float] = 1.0,
        *,
        name: str = "minimum_displacement",
    ) -> None:
        self._reference = None if reference is None else configuration_numbers("reference", reference)
        self._stiffness = non_negative_joint_numbers("stiffness", stiffness)
        self.name = read_name("name", name)

    def __repr__(self) -> str:
        given = {"reference": self._reference, "stiffness": self._stiffness}
        return shown(self, given, {"stiffness": 1.0})

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """The reference (nq,) and the stiffness of each velocity entry (n,)."""
        reference = robot.home if self._reference is None else self._reference
        return {
            "reference": robot.configuration(reference, argument="reference"),
            "stiffness": self._stiffness_on(robot),
        }

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """1/2 sum of k_i d_i^2."""
        d = displacement(kinematics.robot, kinematics.q, parameters["reference"])
        return dot(parameters["stiffness"], d**2) / 2

    def _stiffness_on(self, robot: Robot) -> Array:
        given = self._stiffness
        if isinstance(given, np.ndarray) and given.ndim == 0:
            return np.full(robot.n, float(given))
        return robot.velocity_values(given, default=1.0, argument="stiffness")

"""Kinetic energy of the motion from a reference, by the mass matrix as metric (formulations/kinetic_energy.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from jtik import Criterion, register_criterion
from jtik.arguments import name as read_name
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, dot
from jtik_formulations.bibliography import WHITNEY_1969
from jtik_formulations.criteria._parts.displacement import displacement
from jtik_formulations.criteria._parts.joint_numbers import configuration_numbers, non_negative_joint_numbers
from jtik_formulations.criteria._parts.shown import shown
from jtik_formulations.criteria._parts.weighted_robot import require_masses


@register_criterion("kinetic_energy")
class KineticEnergy(Criterion):
    """H = 1/2 d' M(q) d, d the displacement of all joints from a reference: the kinetic energy [J] of d in one second.

    A motion of the wrist is cheap, one of the shoulder or of a vehicle is dear, by their masses. Prefer it to
    `MinimumDisplacement` where a robot's joints move very different masses; assign the present configuration to the
    parameter ``reference`` before each solve. Of a rotation by the angle theta about the axis a, d is
    2 sin(theta / 2) a.

    Live parameters: ``kinetic_energy.reference`` (nq,) and ``kinetic_energy.rotor_inertia`` (n,) [kg m^2] or [kg].

    Args:
        reference: configuration [rad] and [m], as ``robot.configuration`` accepts it; by default ``robot.home``, where
            a solve starts by default.
        rotor_inertia: non-negative inertia of motors and gears, seen from the joints, which is added to the diagonal of
            M: one number, one for each velocity entry (n,) [kg m^2] or [kg], or a dict by joint name.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when an inertia is negative or not finite, a size does not fit the robot, or a joint moves no
            mass: the message names the links.
        UnknownNameError: when a dict names a joint that does not exist.

    Source: Whitney (1969), the inertia as metric; here for the whole displacement.
    """

    name = "kinetic_energy"
    summary = "stays near a reference configuration, with the mass matrix as metric"
    source = "after Whitney 1969"
    bibtex = WHITNEY_1969
    joint_parameters = ("reference",)
    non_negative_parameters = ("rotor_inertia",)

    def __init__(
        self,
        reference: ArrayLike | Mapping[str, ArrayLike] | None = None,
        *,
        rotor_inertia: ArrayLike | Mapping[str, float] = 0.0,
        name: str = "kinetic_energy",
    ) -> None:
        self._reference = None if reference is None else configuration_numbers("reference", reference)
        self._rotor_inertia = non_negative_joint_numbers("rotor_inertia", rotor_inertia)
        self.name = read_name("name", name)

    def __repr__(self) -> str:
        given = {"reference": self._reference, "rotor_inertia": self._rotor_inertia}
        return shown(self, given, {"rotor_inertia": 0.0})

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """The reference (nq,) and the rotor inertia of each velocity entry (n,)."""
        require_masses(robot)
        reference = robot.home if self._reference is None else self._reference
        given = self._rotor_inertia
        if isinstance(given, np.ndarray) and given.ndim == 0:
            given = np.full(robot.n, float(given))
        return {
            "reference": robot.configuration(reference, argument="reference"),
            "rotor_inertia": robot.velocity_values(given, default=0.0, argument="rotor_inertia"),
        }

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """1/2 d' (M + diag(rotor inertia)) d."""
        d = displacement(kinematics.robot, kinematics.q, parameters["reference"])
        return kinematics.kinetic_energy(d) + dot(parameters["rotor_inertia"], d**2) / 2

"""Static torques that hold the arm against gravity (formulations/gravity_torque.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from jtik import Criterion, register_criterion
from jtik.arguments import name as read_name
from jtik.robot import JointType, Kinematics, Robot
from jtik.symbolic import Expression, sumsqr
from jtik.types import Array
from jtik_formulations.bibliography import HOLLERBACH_SUH_1987
from jtik_formulations.criteria._parts.joint_numbers import positive_joint_numbers
from jtik_formulations.criteria._parts.scalars import point, vector
from jtik_formulations.criteria._parts.shown import shown
from jtik_formulations.criteria._parts.weighted_robot import require_masses


@register_criterion("gravity_torque")
class GravityTorque(Criterion):
    """H = 1/2 sum of (tau_i / scale_i)^2, tau the torques that hold the robot against gravity.

    By default H has no unit: ``scale`` is the effort limit of a joint that has one, and 1 N m or 1 N else. Prefer it to
    rest, to save energy, or to keep motors cool. It knows gravity only, not what the tool carries unless that has a
    mass (`Robot.with_tool`), and no accelerations.

    Live parameters: ``gravity_torque.gravity`` (3,), or (2,) on a planar robot [m/s^2], and
    ``gravity_torque.inverse_scale`` (n,) [1/(N m)] or [1/N]; zero leaves a joint out.

    Args:
        scale: positive torques [N m] and forces [N]: one number, one for each velocity entry (n,), or a dict by joint
            name; by default the effort limits, and 1 where there is none. Free joints, which no motor moves, are left
            out unless numbers for each joint include them.
        gravity: gravity in the base frame [m/s^2]; 9.81 along -z, or along -y of a planar robot, by default.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when a scale is not positive, a size does not fit the robot, or a joint moves no mass: the
            message names the links.
        UnknownNameError: when a dict names a joint that does not exist.

    Source: Hollerbach and Suh (1987), the static part of the torque.
    """

    name = "gravity_torque"
    summary = "keeps the torques small that hold the robot against gravity"
    source = "Hollerbach and Suh 1987, the static part"
    bibtex = HOLLERBACH_SUH_1987
    non_negative_parameters = ("inverse_scale",)

    def __init__(
        self,
        scale: ArrayLike | Mapping[str, float] | None = None,
        *,
        gravity: ArrayLike | None = None,
        name: str = "gravity_torque",
    ) -> None:
        self._scale = None if scale is None else positive_joint_numbers("scale", scale)
        self._gravity = None if gravity is None else point("gravity", gravity)
        self.name = read_name("name", name)

    def __repr__(self) -> str:
        return shown(self, {"scale": self._scale, "gravity": self._gravity}, {})

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Gravity, and the reciprocal scale of each velocity entry (n,)."""
        require_masses(robot)
        down = np.zeros(robot.dimension)
        down[-1] = -9.81
        gravity = down if self._gravity is None else vector("gravity", self._gravity, robot.dimension)
        return {"gravity": gravity, "inverse_scale": self._inverse_scale(robot)}

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """1/2 sum of (tau_i / scale_i)^2."""
        torque = kinematics.gravity_torque(parameters["gravity"])
        return sumsqr(parameters["inverse_scale"] * torque) / 2

    def _inverse_scale(self, robot: Robot) -> Array:
        """1 / scale (n,); zero for free joints that a scale for each joint does not name."""
        effort = robot.effort_limit
        known, moved_by_motors = np.where(np.isfinite(effort), effort, 1.0), np.ones(robot.n)
        for joint in robot.independent_joints:
            if joint.type is JointType.FREE:
                moved_by_motors[robot.v_slice(joint.name)] = 0.0
        if self._scale is None:
            return np.asarray(moved_by_motors / known)
        if isinstance(self._scale, np.ndarray):
            if self._scale.ndim == 0:
                return np.asarray(moved_by_motors / self._scale)
            return 1 / robot.velocity_values(self._scale, default=1.0, argument="scale")
        named = robot.velocity_values(self._scale, default=0.0, argument="scale")
        return np.where(named > 0, 1 / np.where(named > 0, named, 1.0), moved_by_motors / known)

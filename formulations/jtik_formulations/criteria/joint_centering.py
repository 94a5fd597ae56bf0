"""Joint centering: springs that pull the joints to preferred positions (formulations/joint_centering.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from jtik import Criterion, register_criterion
from jtik.arguments import array_of, non_negative_number
from jtik.arguments import name as read_name
from jtik.criterion.short_repr import call_text
from jtik.errors import UnknownNameError
from jtik.robot import JointType, Kinematics, Robot
from jtik.symbolic import Expression, dot
from jtik.types import Array
from jtik_formulations.bibliography import DAS_1988


@register_criterion("joint_centering")
class JointCentering(Criterion):
    """H = 1/2 (q - q_preferred)' K (q - q_preferred) over the revolute and prismatic joints.

    The unit of H is that of K times [rad^2] or [m^2]. The defaults, zero angles and K = I, are the shaping of the
    paper's Figure 2.2. Prefer it to keep an arm close to a posture, or beside a criterion without a minimum.

    Live parameters: ``joint_centering.stiffness`` (nq,) and ``joint_centering.preferred`` (nq,).

    Args:
        stiffness: non-negative diagonal of K, in any form of `Robot.joint_values`; joints that a dict does not name
            keep 1.0, the default.
        preferred: preferred joint positions [rad] or [m], as ``robot.configuration`` accepts a configuration; by
            default the robot's neutral configuration (zeros within the limits, ``qpos0`` of a MuJoCo model).
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when a stiffness is negative or not finite, or a size does not fit the robot.
        UnknownNameError: when the dict of stiffnesses names no revolute or prismatic joint of the robot.

    Source: Das, Slotine and Sheridan (1988), (2.2), the term K q~.
    """

    summary = "springs to preferred joint angles, zero by default"
    source = "Das, Slotine and Sheridan 1988, eq. 2.2"
    bibtex = DAS_1988
    joint_parameters = ("stiffness", "preferred")
    non_negative_parameters = ("stiffness",)

    def __init__(
        self,
        stiffness: ArrayLike | Mapping[str, float] = 1.0,
        preferred: ArrayLike | Mapping[str, ArrayLike] | None = None,
        *,
        name: str = "joint_centering",
    ) -> None:
        self._stiffness = _stiffness(stiffness)
        self._preferred = dict(preferred) if isinstance(preferred, Mapping) else _copied("preferred", preferred)
        self.name = read_name("name", name)

    def __repr__(self) -> str:
        shown = {"stiffness": self._stiffness, "preferred": self._preferred, "name": self.name}
        if isinstance(self._stiffness, np.ndarray) and np.all(self._stiffness == 1.0):
            del shown["stiffness"]
        if self._preferred is None:
            del shown["preferred"]
        if self.name == "joint_centering":
            del shown["name"]
        return call_text(type(self).__name__, **shown)

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Stiffness and preferred configuration, one value for each entry of q."""
        if self._preferred is None:
            preferred = robot.neutral
        else:
            preferred = robot.configuration(self._preferred, argument="preferred")
        return {"stiffness": self._stiffness_on(robot), "preferred": preferred}

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """1/2 sum of k_i (q_i - preferred_i)^2."""
        scalar = [int(i) for i in kinematics.robot.scalar_q]
        away = (kinematics.q - parameters["preferred"])[scalar]
        return 0.5 * dot(parameters["stiffness"][scalar], away**2)

    def _stiffness_on(self, robot: Robot) -> Array:
        """The stiffness of each entry of q, (nq,)."""
        if isinstance(self._stiffness, dict):
            scalar_types = (JointType.REVOLUTE, JointType.PRISMATIC)
            known = [joint.name for joint in robot.independent_joints if joint.type in scalar_types]
            for joint in self._stiffness:
                if joint in robot.joint_names and joint not in known:
                    raise UnknownNameError("revolute or prismatic joint", joint, known)
        return robot.joint_values(self._stiffness, default=1.0, argument="stiffness")


def _stiffness(given: ArrayLike | Mapping[str, float]) -> Array | dict[str, float]:
    """A copy of the stiffnesses. Raises ArgumentError where one is negative or not finite."""
    if isinstance(given, Mapping):
        return {str(joint): non_negative_number(f"stiffness[{joint!r}]", each) for joint, each in given.items()}
    accepted = "non-negative numbers: one, one for each entry of q, or a dict by joint name"
    return array_of("stiffness", given, [(), (None,)], accepted, lambda x: (x >= 0) & np.isfinite(x))


def _copied(argument: str, given: ArrayLike | None) -> Array | None:
    """A copy of the numbers given, or None. Raises ArgumentError for what is not numeric."""
    accepted = "numbers, one for each entry of q, or a dict by joint name"
    return None if given is None else array_of(argument, given, [(None,)], accepted)

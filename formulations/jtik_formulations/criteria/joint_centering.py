"""Joint centering: springs that pull the joints to preferred angles (formulations/joint_centering.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from jtik import Criterion, register_criterion
from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, dot
from jtik.types import Array


@register_criterion("joint_centering")
class JointCentering(Criterion):
    """H = 1/2 (q - q_preferred)' K (q - q_preferred) over the hinge and slide joints; unit: that of K times [rad^2]
    or [m^2].

    The shaping of the paper's Figure 2.2 is the default: zero angles, K = I. Live parameters:
    ``joint_centering.stiffness`` (nq,) and ``joint_centering.preferred`` (nq,).

    Args:
        stiffness: diagonal of K, a scalar or one value a joint, from 0.
        preferred: preferred joint values [rad] or [m]; the robot's neutral configuration (zeros within limits) by
        default.
        name: how its parameters are addressed.

    Source: Das, Slotine and Sheridan (1988), (2.2), the term K q~.
    """

    summary = "springs to preferred joint angles, zero by default"
    source = "Das, Slotine and Sheridan 1988, eq. 2.2"

    def __init__(
        self,
        stiffness: ArrayLike = 1.0,
        preferred: ArrayLike | None = None,
        *,
        name: str = "joint_centering",
    ) -> None:
        self._stiffness = _array("stiffness", stiffness)
        self._preferred = None if preferred is None else _array("preferred", preferred)
        self.name = name
        if not np.all(self._stiffness >= 0):
            raise ArgumentError("stiffness", stiffness, "values from 0")

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Stiffness and preferred configuration, one entry a configuration entry."""
        preferred = robot.neutral if self._preferred is None else self._preferred
        if preferred.shape != (robot.nq,):
            raise ArgumentError("preferred", preferred, f"shape ({robot.nq},), one value a configuration entry")
        if self._stiffness.shape not in ((), (robot.nq,)):
            raise ArgumentError("stiffness", self._stiffness, f"a scalar or shape ({robot.nq},)")
        return {"stiffness": np.broadcast_to(self._stiffness, robot.nq), "preferred": preferred}

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """1/2 sum of k_i (q_i - preferred_i)^2."""
        scalar = [int(i) for i in kinematics.robot.scalar_q]
        away = (kinematics.q - parameters["preferred"])[scalar]
        return 0.5 * dot(parameters["stiffness"][scalar], away**2)


def _array(argument: str, given: ArrayLike) -> Array:
    """The numbers given. Raises ArgumentError for what is none."""
    try:
        return np.array(given, dtype=float)
    except (TypeError, ValueError):
        raise ArgumentError(argument, given, "numbers, one for each configuration entry") from None

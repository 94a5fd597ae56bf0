"""Effective mass of a frame in one direction (formulations/effective_mass.md)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from jtik import Criterion, register_criterion
from jtik.arguments import name as read_name
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, diag, dot, fmax, log, solve_ldl, sqrt, sumsqr
from jtik_formulations.bibliography import KHATIB_1995
from jtik_formulations.criteria._parts.joint_numbers import non_negative_joint_numbers
from jtik_formulations.criteria._parts.scalars import direction as read_direction
from jtik_formulations.criteria._parts.scalars import frame_or_tip, nonzero
from jtik_formulations.criteria._parts.shown import shown
from jtik_formulations.criteria._parts.weighted_robot import require_masses

ROTOR_INERTIA = 1e-4
"""Default inertia that is added to the diagonal of M [kg m^2] or [kg]: less than that of any arm's motor."""

SMALLEST_ROTOR_INERTIA = 1e-9
"""Smallest inertia that is added: it keeps M + B positive definite where masses are points on the axis of a joint."""

LARGEST_MASS = 1e6
"""Mass [kg] at which H levels off, in directions in which the frame cannot move."""

SHORTEST_DIRECTION = 1e-9
"""Length of a live direction below which it counts as shorter than 1."""


@register_criterion("effective_mass")
class EffectiveMass(Criterion):
    """H = 1/2 ln(m_u / 1 kg), m_u = 1 / (u' J M^-1 J' u) the mass [kg] that a push along u feels at a frame.

    Prefer it to make the arm light in the direction in which it may hit something, since the peak force of an impact
    grows with the square root of m_u; take its negative, ``-EffectiveMass(u)``, to hold a tool against a disturbance
    along u. m_u is not the weight of the arm, and at a pose in which the frame cannot move along u it is 1e6 kg.

    Live parameters: ``effective_mass.direction`` (3,), or (2,) on a planar robot, used with length 1, and
    ``effective_mass.rotor_inertia`` (n,) [kg m^2] or [kg].

    Args:
        direction: u in base axes, of any length other than zero.
        frame: name of the frame; the tip when None.
        rotor_inertia: non-negative inertia of motors and gears, seen from the joints, which is added to the diagonal of
            M: one number, one for each velocity entry (n,) [kg m^2] or [kg], or a dict by joint name. At least 1e-9 is
            used.
        name: the first part of the names of its parameters.

    Raises:
        ArgumentError: when a direction is zero, an inertia is negative, a size does not fit the robot, or a joint moves
            no mass: the message names the links.
        UnknownNameError: when the robot has no such frame, or a dict names a joint that does not exist.

    Source: Khatib (1995).
    """

    name = "effective_mass"
    summary = "makes a frame light in one direction, against impacts"
    source = "Khatib 1995"
    bibtex = KHATIB_1995
    non_negative_parameters = ("rotor_inertia",)

    def __init__(
        self,
        direction: ArrayLike,
        frame: str | None = None,
        *,
        rotor_inertia: ArrayLike | Mapping[str, float] = ROTOR_INERTIA,
        name: str = "effective_mass",
    ) -> None:
        self._direction = nonzero("direction", direction)
        self._frame = frame_or_tip(frame)
        self._rotor_inertia = non_negative_joint_numbers("rotor_inertia", rotor_inertia)
        self.name = read_name("name", name)

    @classmethod
    def example(cls, robot: Robot) -> EffectiveMass:
        """A diagonal direction for the tip."""
        return cls(np.arange(1.0, robot.dimension + 1))

    def __repr__(self) -> str:
        given = {"direction": self._direction, "frame": self._frame, "rotor_inertia": self._rotor_inertia}
        return shown(self, given, {"rotor_inertia": ROTOR_INERTIA})

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """The direction, and the rotor inertia of each velocity entry (n,)."""
        require_masses(robot)
        robot.frame(self._frame)
        given = self._rotor_inertia
        if isinstance(given, np.ndarray) and given.ndim == 0:
            given = np.full(robot.n, float(given))
        return {
            "direction": read_direction("direction", self._direction, robot.dimension),
            "rotor_inertia": robot.velocity_values(given, default=ROTOR_INERTIA, argument="rotor_inertia"),
        }

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """-1/2 ln(u' J (M + B)^-1 J' u + 1 / (1e6 kg))."""
        u = parameters["direction"]
        u = u / fmax(sqrt(sumsqr(u)), SHORTEST_DIRECTION)
        along = kinematics.plain_jacobian(self._frame)[: kinematics.robot.dimension, :].T @ u
        M = kinematics.mass_matrix() + diag(fmax(parameters["rotor_inertia"], SMALLEST_ROTOR_INERTIA))
        mobility = dot(along, solve_ldl(M, along))
        return -log(mobility + 1 / LARGEST_MASS) / 2

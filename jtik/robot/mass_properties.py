"""What the masses of a robot give: the centre of mass, gravity torques and the mass matrix."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType
from typing import Any

from jtik.arguments import finite_array
from jtik.robot.dynamics import standard_gravity
from jtik.robot.evaluator import Evaluator
from jtik.robot.masses_and_shapes import Mass
from jtik.robot.rigid_bodies import massless_frames, rigid_bodies
from jtik.symbolic import SX, Expression


class MassProperties:
    """The methods of `Robot` that need masses."""

    _evaluator: Evaluator

    @cached_property
    def bodies(self) -> Mapping[str, Mass]:
        """The masses on frames that move as one, merged, by the frame of the joint that moves them."""
        robot: Any = self
        return MappingProxyType(rigid_bodies(robot))

    @cached_property
    def massless_frames(self) -> tuple[str, ...]:
        """The frames of the joints that move no mass. The mass matrix is singular where there are any."""
        robot: Any = self
        return massless_frames(robot, self.bodies)

    def center_of_mass(self, q: Expression) -> Any:
        """The centre of mass in the base frame [m], shape (3,), or (2,) of a planar robot.

        Args:
            q: a configuration, in any form that `configuration` accepts, or an expression (nq, 1).

        Raises:
            ArgumentError: when the robot has no masses, or ``q`` has another shape than (nq,) or is not finite.
        """
        return self._evaluator.of_frame("center_of_mass", q, None)

    def gravity_torque(self, q: Expression, *, gravity: Any = None) -> Any:
        """The torques [N m] and forces [N] with which the joints hold the robot against gravity, shape (n,).

        The entries of a free joint are the force in the axes of the joint and the torque in those of the moving frame,
        as its velocities are.

        Args:
            q: a configuration, in any form that `configuration` accepts, or an expression (nq, 1).
            gravity: gravity in the base frame (3,) [m/s^2], or (2,) of a planar robot; 9.81 along -z, or along -y of a
                planar robot, when None.

        Raises:
            ArgumentError: when no joint moves a mass, or an argument has another shape or is not finite.
        """
        robot: Any = self
        standard = standard_gravity(robot.dimension)
        g = standard if gravity is None else finite_array("gravity", gravity, standard.shape)
        if isinstance(q, SX):
            return robot.at(q).gravity_torque(g)
        return -self._evaluator.of_frame("first_moment_jacobian", q, None).T[:, : robot.dimension] @ g

    def mass_matrix(self, q: Expression) -> Any:
        """The mass matrix M, shape (n, n): 1/2 v' M v is the kinetic energy [J] at the velocity v.

        Entries are in [kg m^2] of two rotations, [kg] of two translations, [kg m] of one of each. The inertias of
        motors and gears are not in it.

        Args:
            q: a configuration, in any form that `configuration` accepts, or an expression (nq, 1).

        Raises:
            ArgumentError: when no joint moves a mass, or ``q`` has another shape than (nq,) or is not finite.
        """
        return self._evaluator.of_frame("mass_matrix", q, None)

"""Limits of position, velocity and acceleration: which of them apply, and their values for one robot."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from jtik.arguments import array_of, flag, share
from jtik.constructors import Constructed
from jtik.errors import ArgumentError
from jtik.robot import Robot
from jtik.types import Array

AT_LIMIT = 1e-9
"""Distance to a limit at which a joint counts as being at it [rad] or [m]."""

Speeds: TypeAlias = bool | float | Sequence[float] | NDArray[np.float64]
"""True for the robot's own limits, False for none, one number for all joints, or one for each velocity entry."""


@dataclass(frozen=True, kw_only=True)
class Limits(metaclass=Constructed):
    """Which limits apply, for `InverseKinematics`.

    Position limits apply in every method. Velocity and acceleration limits apply where a time is given, in ``track``
    and ``step(..., dt=)``; there all three are one box on the step, which is never empty (formulations/limits.md). Each
    revolute and prismatic joint has its own limits; the velocity of a ball or free joint is scaled.

    A joint that starts at rest inside its limits keeps all three, whatever the strategy does. If a start violates one,
    accelerations have priority over velocities, and these over positions; the joint returns to its position limits as
    fast as the others allow. With an acceleration limit, joints decelerate before position limits, but not before
    clearances; a ``step`` brakes before its target, too, and `track` does not: its targets should move as the robot
    can. How well each strategy follows them is measured in formulations/motion.md.

    Attributes:
        position: whether the robot's position limits apply.
        position_gain: share of its distance to a position limit that a joint may move in one step towards it, in
            (0, 1], in `track` and ``step(dt=)``. At 1 a joint may reach the limit in one step. Below 1 it comes to rest
            more softly and a path that ends at a limit is followed with a delay; 0.5 is pink's value, 0.95 mink's.
        velocity: largest speeds: True for the robot's own ``velocity_limit``, False for none, a number for all joints,
            or (n,) for the joints that the solver moves [rad/s] or [m/s]; ``inf`` for none.
        acceleration: largest accelerations: None for none, a number, or (n,) [rad/s^2] or [m/s^2].

    Raises:
        ArgumentError: for a value that is not a limit, such as a negative number or NaN.

    Example:
        >>> limits = jtik.Limits(velocity=1.5, acceleration=10.0)  # of all joints, [rad/s] and [rad/s^2]
        >>> ik = jtik.InverseKinematics(jtik.Robot.planar(3), jtik.FrameTask("tip"), limits=limits)
        >>> q = ik.step([0.3, 0.2, 0.1], [2.5, 1.0], dt=0.01).q
    """

    position: bool = True
    position_gain: float = 1.0
    velocity: Speeds = True
    acceleration: Speeds | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", flag("position", self.position, "whether position limits hold"))
        object.__setattr__(self, "position_gain", share("position_gain", self.position_gain))
        if isinstance(self.velocity, (bool, np.bool_)):
            object.__setattr__(self, "velocity", bool(self.velocity))
        else:
            accepted = "True for the robot's own, False for none, or positive numbers [rad/s] or [m/s], one or (n,)"
            object.__setattr__(self, "velocity", _positive("velocity", self.velocity, accepted))
        if self.acceleration is not None:
            accepted = "None for none, or positive numbers [rad/s^2] or [m/s^2], one or (n,)"
            object.__setattr__(self, "acceleration", _positive("acceleration", self.acceleration, accepted))

    def of(self, robot: Robot) -> Bounds:
        """The limits of a robot as numbers.

        Args:
            robot: the robot.

        Raises:
            ArgumentError: when there are not as many as the robot has velocity entries.
        """
        speeds = robot.velocity_limit if self.velocity is True else self.velocity
        return Bounds(
            robot=robot,
            lower=robot.lower.copy() if self.position else np.full(robot.nq, -np.inf),
            upper=robot.upper.copy() if self.position else np.full(robot.nq, np.inf),
            position_gain=self.position_gain,
            velocity=_spread("limits.velocity", math.inf if speeds is False else speeds, robot.n),
            acceleration=_spread(
                "limits.acceleration", math.inf if self.acceleration is None else self.acceleration, robot.n
            ),
        )


@dataclass(frozen=True, eq=False)
class Bounds:
    """Limits as numbers; infinite where there is none.

    Attributes:
        robot: the robot.
        lower: lower position limits (nq,) [rad] or [m].
        upper: upper position limits (nq,) [rad] or [m].
        position_gain: share of the distance to a position limit that a step may use.
        velocity: largest speeds (n,) [rad/s] or [m/s].
        acceleration: largest accelerations (n,) [rad/s^2] or [m/s^2].
    """

    robot: Robot
    lower: Array
    upper: Array
    position_gain: float
    velocity: Array
    acceleration: Array

    @property
    def bounded(self) -> tuple[tuple[int, int], ...]:
        """(q index, v index) of the revolute and prismatic joints that have a limit of any kind."""
        return tuple(
            (int(i), int(j))
            for i, j in zip(self.robot.scalar_q, self.robot.scalar_v, strict=True)
            if self.lower[i] > -math.inf
            or self.upper[i] < math.inf
            or min(self.velocity[j], self.acceleration[j]) < math.inf
        )

    @property
    def locked(self) -> tuple[int, ...]:
        """Velocity entries of the revolute and prismatic joints whose lower limit is their upper limit."""
        fixed = self.upper - self.lower <= AT_LIMIT
        return tuple(int(j) for i, j in zip(self.robot.scalar_q, self.robot.scalar_v, strict=True) if fixed[i])

    @property
    def unboxed(self) -> NDArray[np.intp]:
        """Velocity entries of ball and free joints that have a limit, which no box on q can express."""
        limited = np.minimum(self.velocity, self.acceleration) < math.inf
        limited[self.robot.scalar_v] = False
        return np.flatnonzero(limited)


def limits_of(limits: object) -> Limits:
    """The argument ``limits`` of a solver as `Limits`: True for the robot's own, False for no position limits.

    Raises:
        ArgumentError: for anything else.
    """
    if isinstance(limits, Limits):
        return limits
    return Limits(position=flag("limits", limits, "whether the robot's position limits hold; or a jtik.Limits"))


def _positive(argument: str, value: object, accepted: str) -> float | tuple[float, ...]:
    """One positive number, or several; infinity is one."""
    numbers = array_of(argument, value, [(), (None,)], accepted, lambda x: x > 0)
    if not numbers.size:
        raise ArgumentError(argument, value, accepted)
    return tuple(numbers.tolist()) if numbers.ndim else float(numbers)


def _spread(argument: str, value: object, n: int) -> Array:
    """One number for all, or n."""
    given = np.asarray(value, dtype=np.float64)
    if given.ndim and given.shape != (n,):
        accepted = f"one number, or {n}: one for each velocity entry of the joints that move"
        raise ArgumentError(argument, f"{given.size} numbers", accepted)
    return np.full(n, given)

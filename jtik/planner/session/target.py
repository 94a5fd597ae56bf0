"""The target that the operator guides: it follows the commands at a limited speed."""

from __future__ import annotations

import math

import numpy as np

from jtik.planner.edits.messages import HoldTarget, MoveTarget
from jtik.planner.session import rotations
from jtik.types import Array

AT_REST = 1e-9
"""Distance [m] and angle [rad] up to which the target is where it was sent."""


class GuidedTarget:
    """A pose that moves to where it was sent, straight and about one axis, or at the velocity that is held.

    Args:
        position: where it is, (2,) or (3,) [m].
        orientation: its orientation, a unit quaternion (w, x, y, z).
        speed: largest speed [m/s].
        rotation_speed: largest angular speed [rad/s].
        turns: whether its orientation counts.

    Attributes:
        position: where it is, (2,) or (3,) [m].
        orientation: its orientation, a unit quaternion (w, x, y, z).
        speed: largest speed [m/s].
        rotation_speed: largest angular speed [rad/s].
        turns: whether its orientation counts.
    """

    def __init__(
        self, position: Array, orientation: Array, *, speed: float, rotation_speed: float, turns: bool
    ) -> None:
        self.speed, self.rotation_speed, self.turns = speed, rotation_speed, turns
        self._velocity = np.zeros(len(position))
        self._rotation = np.zeros(3)
        self.put(position, orientation)

    @property
    def moving(self) -> bool:
        """Whether it moves in the next period."""
        if self._velocity.any() or self._rotation.any():
            return True
        away = self._position_goal - self.position
        return bool(np.abs(away).max() > AT_REST) or rotations.angle(self.orientation, self._goal) > AT_REST

    def put(self, position: Array, orientation: Array) -> None:
        """Put it somewhere at once, at rest."""
        self.position, self.orientation = np.array(position, dtype=float), np.array(orientation, dtype=float)
        self.stop()

    def stop(self) -> None:
        """Stop where it is."""
        self._velocity[:], self._rotation[:] = 0.0, 0.0
        self._position_goal, self._goal = self.position, self.orientation

    def move(self, edit: MoveTarget) -> None:
        """Send it somewhere."""
        self.stop()
        self._position_goal = np.array(edit.position)
        if edit.orientation is not None and self.turns:
            self._goal = np.array(edit.orientation)

    def hold(self, edit: HoldTarget) -> None:
        """Move it at a velocity, at most at its speed; zeros stop it."""
        self.stop()
        self._velocity[:] = edit.velocity
        if edit.rotation is not None and self.turns:
            self._rotation[:] = edit.rotation

    def advance(self, dt: float) -> bool:
        """Move it for ``dt`` [s]. Returns whether it has moved."""
        moved = False
        if self._velocity.any() or self._rotation.any():
            self._follow_velocity(dt)
            moved = True
        away = self._position_goal - self.position
        distance = math.hypot(*away)
        if distance > 0:
            reach = self.speed * dt
            self.position = self._position_goal if distance <= reach else self.position + away * (reach / distance)
            moved = True
        angle = rotations.angle(self.orientation, self._goal) if self._goal is not self.orientation else 0.0
        if angle > 0:
            share = min(1.0, self.rotation_speed * dt / angle)
            self.orientation = self._goal if share == 1 else rotations.slerp(self.orientation, self._goal, share)
            moved = True
        return moved

    def _follow_velocity(self, dt: float) -> None:
        speed, turn = math.hypot(*self._velocity), math.hypot(*self._rotation)
        self.position = self.position + self._velocity * (dt * min(1.0, self.speed / speed if speed else 1.0))
        if turn:
            vector = self._rotation * (dt * min(1.0, self.rotation_speed / turn))
            self.orientation = rotations.turned(self.orientation, vector)
        self._position_goal, self._goal = self.position, self.orientation

"""The jump limit of a solve: the largest change of each joint from where the search began."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from jtik.constraints.limits import AT_LIMIT
from jtik.result.status import Status
from jtik.robot import Robot
from jtik.types import Array

if TYPE_CHECKING:
    from jtik._loop.inspection import Inspection


class Jump:
    """The jump limit of one search.

    Revolute and prismatic joints keep it as a limit of their position; one that others mimic moves so little that these
    keep it, too. It bounds the angle of the rotation of a ball or free joint, and the length of the displacement of a
    free joint, which no limits of single entries of q can express: restarts are drawn within it, and a configuration
    beyond it is no arrival.

    Args:
        robot: the robot.
        q0: where the search began, (nq,).
        limit: the largest change of a joint [rad] or [m].
        lower: lower limits otherwise, (nq,).
        upper: upper limits otherwise, (nq,).

    Attributes:
        box: lower and upper limits of the search, (nq,) each.
    """

    def __init__(self, robot: Robot, q0: Array, limit: float, lower: Array, upper: Array) -> None:
        self._robot, self._q0, self._limit = robot, q0.copy(), limit
        self._ratios = _ratios(robot)
        reach, scalar = np.full(robot.nq, np.inf), robot.scalar_q
        reach[scalar] = limit / self._ratios
        self.box = np.maximum(lower, q0 - reach), np.minimum(upper, q0 + reach)
        motions = [robot.v_slice(joint.name) for joint in robot.independent_joints if not joint.type.is_scalar]
        self._motions = [slice(end - 3, end) for v in motions for end in range(v.start + 3, v.stop + 1, 3)]

    def holds(self, q: Array) -> bool:
        """Whether no joint is further from where the search began."""
        v, most = np.asarray(self._robot.difference(self._q0, q)), self._limit + AT_LIMIT
        if not (np.abs(v[self._robot.scalar_v]) * self._ratios <= most).all():
            return False
        return all(float(np.linalg.norm(v[motion])) <= most for motion in self._motions)

    def drawn(self, rows: Array, generator: np.random.Generator) -> Array:
        """Configurations, one a row, within the limit; the entries of ``rows`` stay where one has less than two limits.

        Rotations and displacements are uniform in direction and in the cube of their size.
        """
        lower, upper = self.box
        bounded = np.isfinite(lower) & np.isfinite(upper)
        rows = rows.copy()
        rows[:, bounded] = generator.uniform(lower[bounded], upper[bounded], (len(rows), int(bounded.sum())))
        if not self._motions:
            return rows
        v, about = np.zeros((len(rows), self._robot.n)), self._q0.copy()
        for motion in self._motions:
            direction = generator.normal(size=(len(rows), 3))
            size = self._limit * generator.uniform(size=(len(rows), 1)) ** (1 / 3)
            v[:, motion] = size * direction / np.linalg.norm(direction, axis=1, keepdims=True)
        moved = np.array([self._robot.integrate(about, each) for each in v])
        moved[:, self._robot.scalar_q] = rows[:, self._robot.scalar_q]
        return moved

    def status(self, status: Status, q: Array, inspection: Inspection) -> Status:
        """``status``, or JUMP_LIMIT where this limit keeps the search from its target."""
        if not self.holds(q):
            return Status.JUMP_LIMIT if status.on_target else status
        report, (lower, upper) = inspection.report, self.box
        q_of_v = dict(zip(self._robot.scalar_v.tolist(), self._robot.scalar_q.tolist(), strict=True))
        own = [upper[q_of_v[j]] < self._robot.upper[q_of_v[j]] for j in report.at_upper]
        own += [lower[q_of_v[j]] > self._robot.lower[q_of_v[j]] for j in report.at_lower]
        return Status.JUMP_LIMIT if any(own) and status is Status.LIMITS else status


def _ratios(robot: Robot) -> Array:
    """How far each revolute or prismatic joint, or one that mimics it, moves, relative to its own motion."""
    largest = {joint.name: 1.0 for joint in robot.independent_joints}
    for joint in robot.joints:
        if joint.mimic is not None:
            largest[joint.mimic.joint] = max(largest[joint.mimic.joint], abs(joint.mimic.multiplier))
    return np.array([largest[joint.name] for joint in robot.independent_joints if joint.type.is_scalar])

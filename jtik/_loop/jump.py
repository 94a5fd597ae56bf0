"""The jump limit of a solve: the largest change of each joint from where the search began."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from jtik._loop.inspection import Inspection
from jtik.constraints.limits import AT_LIMIT
from jtik.result.status import Status
from jtik.robot import Robot
from jtik.types import Array


class Jump:
    """The jump limit of one search.

    Revolute and prismatic joints keep it as a limit of their position. The rotation of a ball joint and the motion of a
    free joint are judged when the search is over.

    Args:
        robot: the robot.
        q0: where the search began, (nq,).
        limit: the largest change of a joint [rad] or [m].
        box_about: gives the limits of the search from ``q0`` and ``limit``.

    Attributes:
        box: lower and upper limits of the search, (nq,) each.
    """

    def __init__(
        self, robot: Robot, q0: Array, limit: float, box_about: Callable[[Array, float], tuple[Array, Array]]
    ) -> None:
        self._robot, self._q0, self._limit = robot, q0.copy(), limit
        self.box = box_about(self._q0, limit)

    def status(self, status: Status, q: Array, inspection: Inspection) -> Status:
        """``status``, or JUMP_LIMIT where this limit keeps the search from its target."""
        if (np.abs(self._robot.difference(self._q0, q)) > self._limit + AT_LIMIT).any():
            return Status.JUMP_LIMIT if status.on_target else status
        report, (lower, upper) = inspection.report, self.box
        q_of_v = dict(zip(self._robot.scalar_v.tolist(), self._robot.scalar_q.tolist(), strict=True))
        own = [upper[q_of_v[j]] < self._robot.upper[q_of_v[j]] for j in report.at_upper]
        own += [lower[q_of_v[j]] > self._robot.lower[q_of_v[j]] for j in report.at_lower]
        return Status.JUMP_LIMIT if any(own) and status is Status.LIMITS else status

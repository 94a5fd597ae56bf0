"""The target of one arm: what a user drags, and the solver that follows it."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np

from jtik.result import Solution
from jtik.robot import Robot
from jtik.solver import InverseKinematics
from jtik.task import FrameTask
from jtik.types import Array

MOST_ITERATIONS = 300
"""Largest number of iterations of a solve: the next position of the target is waiting."""


class LiveTarget:
    """Solves for the target of one arm.

    Args:
        robot: the robot that is shown.
        ik: its solver, of one `FrameTask`, or None for one that is made when the target is first dragged: of the pose
            of the tip, or of its position on a planar robot.

    Attributes:
        frame: the frame that follows the target.
        turns: whether its orientation follows, too.
    """

    def __init__(self, robot: Robot, ik: InverseKinematics | None) -> None:
        self._robot = robot
        self._ik = None if ik is None else copy.copy(ik)
        task = None if ik is None else ik.tasks.tasks[0]
        self.frame = robot.frame(task.frame if isinstance(task, FrameTask) else None)
        kind = task.kind if isinstance(task, FrameTask) else ("pose" if robot.dimension == 3 else "position")
        self.turns, self.moves = kind != "position", kind != "orientation"

    @staticmethod
    def fits(ik: InverseKinematics | None) -> bool:
        """Whether a solver has a target that can be dragged: that of one `FrameTask`."""
        return ik is None or (len(ik.tasks.tasks) == 1 and isinstance(ik.tasks.tasks[0], FrameTask))

    def solve(self, pose: Array, q: Array) -> tuple[Array, Solution]:
        """The configuration (nq,) of the robot for a target, and the Solution.

        Args:
            pose: the target (4, 4) [m].
            q: where to start, (nq,); joints that the solver does not move stay.
        """
        if self._ik is None:
            task = FrameTask(self.frame, kind="pose" if self.turns else "position")
            self._ik = InverseKinematics(self._robot, task)
        solution = self._ik.solve(self._target(pose), q0=self._own(q), max_iterations=MOST_ITERATIONS)
        full = q.copy()
        for name in self._ik.robot.joint_names:
            full[self._robot.q_slice(name)] = solution.q[self._ik.robot.q_slice(name)]
        return full, solution

    def update(self, ik: InverseKinematics) -> None:
        """Take the live parameters of another solver."""
        if self._ik is not None:
            for name, value in ik.parameters.items():
                self._ik.parameters[name] = value

    def _own(self, q: Array) -> Array:
        """The part of a configuration that the solver moves."""
        assert self._ik is not None
        own = self._ik.robot
        return np.concatenate([q[self._robot.q_slice(name)] for name in own.joint_names])

    def _target(self, pose: Array) -> Any:
        if self._robot.dimension == 3:
            return pose
        angle = float(np.arctan2(pose[1, 0], pose[0, 0]))
        return np.array([*pose[:2, 3], angle]) if self.turns else pose[:2, 3]

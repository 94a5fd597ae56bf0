"""placo as a contender: one quadratic program for each step in C++, on Pinocchio's kinematics."""

from __future__ import annotations

import math
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from jtik.study.peers.base import Goal, Peer
from jtik.study.peers.loop import StepLoop
from jtik.types import Array


@dataclass(kw_only=True)
class PlacoPeer(Peer):
    """A loop over ``KinematicsSolver.solve`` with soft position and orientation tasks and position limits.

    It does not accept criteria from Python. The defaults are the best of a search on a Panda and a UR5e: orientation
    weights 1, 1/4 and 1/16, regularization 1e-6 to 1e-2, 15 to 60 steps for an attempt.

    Attributes:
        label: name of the library in a study.
        orientation_weight: weight of one squared radian relative to one squared metre.
        regularization: weight of the squared step; None is 1e-3, or 1e-6 if restarts are allowed.
        restarted: maximum steps of an attempt if restarts are allowed.
    """

    label: str = "placo"
    orientation_weight: float = 0.0625
    regularization: float | None = None
    restarted: int = 30
    module: ClassVar[str] = "placo"
    package: ClassVar[str] = "placo"
    optimizes = False

    def build(self, library: Any, goal: Goal) -> StepLoop:
        """Build it on the robot as a URDF."""
        return _PlacoLoop(library, goal, self)


class _PlacoLoop(StepLoop):
    """The loop of placo."""

    def __init__(self, library: Any, goal: Goal, options: PlacoPeer) -> None:
        super().__init__(goal, restarted=options.restarted)
        self._wrapper = _read(library, goal)
        self._solver = library.KinematicsSolver(self._wrapper)
        self._solver.mask_fbase(True)
        self._solver.enable_joint_limits(bool(goal.setting.limits))
        self._solver.enable_velocity_limits(False)
        usual = 1e-6 if goal.setting.restarts else 1e-3
        self._solver.add_regularization_task(usual if options.regularization is None else options.regularization)
        self._position = self._orientation = None
        if goal.has_position:
            self._position = self._solver.add_position_task(goal.frame, np.zeros(3))
            self._position.configure("position", "soft", 1.0)
        if goal.has_orientation:
            self._orientation = self._solver.add_orientation_task(goal.frame, np.eye(3))
            self._orientation.configure("orientation", "soft", options.orientation_weight)
        names = [joint.name for joint in goal.robot.independent_joints]
        self._places = [self._wrapper.get_joint_offset(name) for name in names]
        self._full = self._wrapper.neutral_state().q.copy()

    def convert(self, target: Any) -> Any:
        """The pose (4, 4)."""
        return self.goal.pose(target)

    def set_target(self, target: Any) -> None:
        """Set the targets of the tasks."""
        if self._position is not None:
            self._position.target_world = target[:3, 3]
        if self._orientation is not None:
            self._orientation.R_world_frame = target[:3, :3]

    def set_configuration(self, q: Array) -> None:
        """Set q of the state."""
        self._full[self._places] = q
        self._wrapper.state.q = self._full
        self._wrapper.update_kinematics()

    def q(self) -> Array:
        """q from the state."""
        q: Array = np.array(self._wrapper.state.q)[self._places]
        return q

    def error(self) -> tuple[float, float]:
        """Errors of the tasks."""
        errors = []
        for task in (self._position, self._orientation):
            if task is not None:
                task.update()
            errors.append(0.0 if task is None else float(task.error_norm()))
        return errors[0], errors[1]

    def step(self) -> float | None:
        """Step with ``solve``, which raises if the quadratic program has no solution."""
        try:
            dq = self._solver.solve(True)
        except RuntimeError:
            return None
        self._wrapper.update_kinematics()
        length = math.sqrt(dq @ dq)
        return length if math.isfinite(length) else None


def _read(library: Any, goal: Goal) -> Any:
    """placo's robot. Revolute joints without limits get wide limits, so that each has one entry in placo's q."""
    from jtik.interop.urdf import UNLIMITED, to_urdf

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "robot.urdf"
        file.write_text(to_urdf(goal.robot, revolute_limit=UNLIMITED), encoding="utf-8")
        return library.RobotWrapper(str(file), library.Flags.ignore_collisions)

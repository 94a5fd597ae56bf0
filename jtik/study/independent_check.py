"""Independent check of answers: task errors by MuJoCo's kinematics, which no contender supplies, and joint limits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from jtik.errors import ArgumentError
from jtik.robot import Robot
from jtik.symbolic import function, symbol
from jtik.symbolic.compile import CompiledFunction
from jtik.task import FrameTask, Task, TaskStack
from jtik.types import Array

SLACK = 1e-11
"""Rounding difference allowed between two kinematics [m], [rad]."""

ROUNDING = 1e-9
"""Rounding allowed beyond a limit, relative to the joint's range."""


class IndependentCheck:
    """Checks task errors and joint limits of answers.

    Errors of `FrameTask` are computed with MuJoCo's kinematics: distances and angles, also where the task's own error
    is a logarithm, unless that has only some rows. Errors of all other tasks are computed by the tasks themselves.

    Args:
        robot: the reduced robot.
        tasks: the tasks on it.

    Attributes:
        independent: whether all errors are computed with MuJoCo.
        has_position: whether the tasks have position rows.
        has_orientation: whether the tasks have orientation rows.
    """

    def __init__(self, robot: Robot, tasks: TaskStack) -> None:
        self._tasks = tasks
        model = _Model.of(robot) if any(type(task) is FrameTask for task in tasks.tasks) else None
        self._parts: list[tuple[slice, Callable[[Array, Array], tuple[Array, Array]]]] = []
        self.independent, start = True, 0
        for task in tasks.tasks:
            place = slice(start, start + task.target_size(robot))
            start = place.stop
            if model is not None and type(task) is FrameTask and (task.error == "separate" or task.axes is None):
                self._parts.append((place, model.errors(robot, task)))
            else:
                self.independent = False
                self._parts.append((place, _own_errors(robot, task)))
        linear = tasks.rows(robot.at(symbol("q", robot.nq)), symbol("target", tasks.target_size)).linear
        self.has_position, self.has_orientation = any(linear), not all(linear)
        scalar = robot.scalar_q
        self._places, self._lower, self._upper = scalar, robot.lower[scalar], robot.upper[scalar]
        self._ranged = np.isfinite(self._upper - self._lower) & (self._upper > self._lower)

    def errors(self, q: Array, numbers: Array) -> tuple[float, float]:
        """Norms of the position error [m] and of the orientation error [rad] at q, for a target as numbers."""
        position, orientation = 0.0, 0.0
        for place, errors in self._parts:
            lengths, angles = errors(q, numbers[place])
            position += float(lengths @ lengths)
            orientation += float(angles @ angles)
        return float(np.sqrt(position)), float(np.sqrt(orientation))

    def margin(self, q: Array) -> float:
        """Smallest distance of a joint to a limit relative to its range; negative outside, NaN without limits."""
        if not self._ranged.any():
            return float("nan")
        own, lower, upper = q[self._places][self._ranged], self._lower[self._ranged], self._upper[self._ranged]
        return float((np.minimum(own - lower, upper - own) / (upper - lower)).min())

    def within(self, q: Array) -> bool:
        """Whether all joints are within their limits up to rounding."""
        own = q[self._places]
        slack = ROUNDING * np.where(self._ranged, self._upper - self._lower, 1.0)
        return bool(((own >= self._lower - slack) & (own <= self._upper + slack)).all())


class _Model:
    """MuJoCo model of a robot, which keeps the kinematics of the last configuration."""

    def __init__(self, robot: Robot, model: Any) -> None:
        import mujoco

        from jtik.interop.mujoco_model import MujocoCorrespondence

        self._mujoco, self._model, self._data = mujoco, model, mujoco.MjData(model)
        self._places = MujocoCorrespondence(robot, model)
        self._frames = {frame: model.body(frame).id for frame in robot.frame_names if frame != robot.base}
        self._at: bytes = b""

    @classmethod
    def of(cls, robot: Robot) -> _Model | None:
        """The model, or None for a robot that MuJoCo does not support."""
        from jtik.interop.mujoco_model import to_mujoco

        try:
            return cls(robot, to_mujoco(robot))
        except ArgumentError:
            return None

    def frame_pose(self, q: Array, frame: str) -> tuple[Array, Array]:
        """Position (3,) [m] and rotation (3, 3) of a frame at q."""
        if self._at != q.tobytes():
            self._data.qpos[:] = self._places.qpos(q)
            self._mujoco.mj_kinematics(self._model, self._data)
            self._at = q.tobytes()
        number = self._frames.get(frame, 0)
        return self._data.xpos[number], self._data.xmat[number].reshape(3, 3)

    def errors(self, robot: Robot, task: FrameTask) -> Callable[[Array, Array], tuple[Array, Array]]:
        """(q, target numbers) -> position rows [m] and orientation rows [rad] of a task."""
        planar, kind = robot.dimension == 2, task.kind
        rotations = ["rz"] if planar else ["rx", "ry", "rz"]
        lengths = [i for i, axis in enumerate("xyz"[: robot.dimension]) if task.axes is None or axis in task.axes]
        angles = [i for i, axis in enumerate(rotations) if task.axes is None or axis in task.axes]
        split = 0 if kind == "orientation" else robot.dimension
        empty = np.zeros(0)

        def errors(q: Array, numbers: Array) -> tuple[Array, Array]:
            position, rotation = self.frame_pose(q, robot.frame(task.frame))
            away = (position[: robot.dimension] - numbers[:split])[lengths] if kind != "orientation" else empty
            if kind == "position":
                return away, empty
            if planar:
                angle = np.arctan2(rotation[1, 0], rotation[0, 0]) - numbers[split]
                return away, np.array([np.arctan2(np.sin(angle), np.cos(angle))])[angles]
            return away, self._rotation_vector(numbers[split:].reshape(3, 3, order="F").T @ rotation)[angles]

        return errors

    def _rotation_vector(self, rotation: Array) -> Array:
        """The rotation vector (3,) [rad] of a rotation."""
        quaternion, vector = np.zeros(4), np.zeros(3)
        self._mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
        self._mujoco.mju_quat2Vel(vector, quaternion, 1.0)
        return vector


def _own_errors(robot: Robot, task: Task) -> Callable[[Array, Array], tuple[Array, Array]]:
    """(q, target numbers) -> position rows [m] and orientation rows [rad], by the task itself."""
    q, target = symbol("q", robot.nq), symbol("target", task.target_size(robot))
    rows = task.rows(robot.at(q), target)
    evaluate = CompiledFunction(function("error", [q, target], [rows.error]))
    linear = np.array(rows.linear, dtype=bool)

    def errors(at: Array, numbers: Array) -> tuple[Array, Array]:
        error = evaluate(at, numbers)[0][:, 0]
        return error[linear], error[~linear]

    return errors

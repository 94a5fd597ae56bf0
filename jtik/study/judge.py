"""The judge: how far an answer is from its target, by kinematics that no contender has a part in."""

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
"""Error [m], [rad] by which two kinematics may differ without anybody being wrong."""

ROUNDING = 1e-9
"""Share of a joint's range that an answer may be outside of it by rounding."""


class Judge:
    """Errors of frame tasks by MuJoCo's kinematics of the robot, of all other tasks by their own numbers.

    Args:
        robot: the robot that configurations belong to.
        tasks: the tasks on it.

    Attributes:
        independent: whether every task is judged by MuJoCo.
        lengths, angles: whether there are position rows, and orientation rows, at all.
    """

    def __init__(self, robot: Robot, tasks: TaskStack) -> None:
        self._tasks = tasks
        model = _Model.of(robot) if any(type(task) is FrameTask for task in tasks.tasks) else None
        self._parts: list[tuple[slice, Callable[[Array, Array], tuple[Array, Array]]]] = []
        self.independent, start = True, 0
        for task in tasks.tasks:
            place = slice(start, start + task.target_size(robot))
            start = place.stop
            if model is not None and type(task) is FrameTask:
                self._parts.append((place, model.errors(robot, task)))
            else:
                self.independent = False
                self._parts.append((place, _own_errors(robot, task)))
        linear = tasks.rows(robot.at(symbol("q", robot.nq)), symbol("target", tasks.target_size)).linear
        self.lengths, self.angles = any(linear), not all(linear)
        scalar = robot.scalar_q
        self._places, self._lower, self._upper = scalar, robot.lower[scalar], robot.upper[scalar]
        self._ranged = np.isfinite(self._upper - self._lower) & (self._upper > self._lower)

    def errors(self, q: Array, numbers: Array) -> tuple[float, float]:
        """Norms of all position rows [m] and of all orientation rows [rad] at q, for a target read as numbers."""
        position, orientation = 0.0, 0.0
        for place, errors in self._parts:
            lengths, angles = errors(q, numbers[place])
            position += float(lengths @ lengths)
            orientation += float(angles @ angles)
        return float(np.sqrt(position)), float(np.sqrt(orientation))

    def margin(self, q: Array) -> float:
        """The least distance of a joint to a limit as a share of its range, negative outside; NaN without ranges."""
        if not self._ranged.any():
            return float("nan")
        own, lower, upper = q[self._places][self._ranged], self._lower[self._ranged], self._upper[self._ranged]
        return float((np.minimum(own - lower, upper - own) / (upper - lower)).min())

    def within(self, q: Array) -> bool:
        """Whether every joint is within its limits, but for rounding."""
        own = q[self._places]
        slack = ROUNDING * np.where(self._ranged, self._upper - self._lower, 1.0)
        return bool(((own >= self._lower - slack) & (own <= self._upper + slack)).all())


class _Model:
    """A robot as MuJoCo sees it, at one configuration at a time."""

    def __init__(self, robot: Robot, model: Any) -> None:
        import mujoco

        from jtik.interop.mujoco_model import Correspondence

        self._mujoco, self._model, self._data = mujoco, model, mujoco.MjData(model)
        self._places = Correspondence(robot, model)
        self._frames = {frame: model.body(frame).id for frame in robot.frame_names if frame != robot.base}
        self._at: bytes = b""

    @classmethod
    def of(cls, robot: Robot) -> _Model | None:
        """None for a robot that MuJoCo cannot take."""
        from jtik.interop.mujoco_model import to_mujoco

        try:
            return cls(robot, to_mujoco(robot))
        except ArgumentError:
            return None

    def place(self, q: Array, frame: str) -> tuple[Array, Array]:
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
        turns = ["rz"] if planar else ["rx", "ry", "rz"]
        lengths = [i for i, axis in enumerate("xyz"[: robot.dimension]) if task.axes is None or axis in task.axes]
        angles = [i for i, axis in enumerate(turns) if task.axes is None or axis in task.axes]
        split = 0 if kind == "orientation" else robot.dimension
        none = np.zeros(0)

        def errors(q: Array, numbers: Array) -> tuple[Array, Array]:
            position, rotation = self.place(q, task.frame)
            away = (position[: robot.dimension] - numbers[:split])[lengths] if kind != "orientation" else none
            if kind == "position":
                return away, none
            if planar:
                turn = np.arctan2(rotation[1, 0], rotation[0, 0]) - numbers[split]
                return away, np.array([np.arctan2(np.sin(turn), np.cos(turn))])[angles]
            return away, self._turn(numbers[split:].reshape(3, 3, order="F").T @ rotation)[angles]

        return errors

    def _turn(self, rotation: Array) -> Array:
        """The rotation vector (3,) [rad] of a rotation."""
        quaternion, vector = np.zeros(4), np.zeros(3)
        self._mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
        self._mujoco.mju_quat2Vel(vector, quaternion, 1.0)
        return vector


def _own_errors(robot: Robot, task: Task) -> Callable[[Array, Array], tuple[Array, Array]]:
    """The same by the task's own error."""
    q, target = symbol("q", robot.nq), symbol("target", task.target_size(robot))
    rows = task.rows(robot.at(q), target)
    evaluate = CompiledFunction(function("error", [q, target], [rows.error]))
    linear = np.array(rows.linear, dtype=bool)

    def errors(at: Array, numbers: Array) -> tuple[Array, Array]:
        error = evaluate(at, numbers)[0][:, 0]
        return error[linear], error[~linear]

    return errors

"""All tasks of a solver as one: rows below each other, targets by name."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, jacobian, symbol, symvar, vertcat
from jtik.task.base import Task
from jtik.types import Array


@dataclass(frozen=True)
class StackRows:
    """The rows of all tasks together.

    Attributes: error (m, 1); which rows are lengths; its derivative with respect to the velocity (m, n); the rows of
    each level of priority, the highest (0) first.
    """

    error: Expression
    linear: tuple[bool, ...]
    jacobian: Expression
    levels: tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class TaskStack:
    """All tasks of a solver, one below the other, on one robot."""

    robot: Robot
    tasks: tuple[Task, ...]

    @classmethod
    def of(cls, robot: Robot, tasks: Task | Iterable[Task]) -> TaskStack:
        """From one task or several; raises ArgumentError for none, for something else, or for a repeated name."""
        if isinstance(tasks, Task):
            chosen: tuple[Task, ...] = (tasks,)
        elif isinstance(tasks, Iterable) and not isinstance(tasks, str):
            chosen = tuple(tasks)
        else:
            raise ArgumentError("task", tasks, "a jtik.Task such as jtik.FrameTask, or a list of them")
        for task in chosen:
            if not isinstance(task, Task):
                raise ArgumentError("task", task, "a jtik.Task such as jtik.FrameTask, or a list of them")
        names = [task.name for task in chosen]
        if not chosen or len(set(names)) != len(names):
            raise ArgumentError("task", names, "at least one task, each with a name of its own: name=...")
        return cls(robot, chosen)

    @property
    def target_size(self) -> int:
        """How many numbers all targets are together."""
        return sum(task.target_size(self.robot) for task in self.tasks)

    @property
    def plain(self) -> bool:
        """Whether a target given as a vector of the right length is the task's numbers as it stands."""
        return len(self.tasks) == 1 and self.tasks[0].plain(self.robot)

    def read_target(self, target: Any) -> Array:
        """The numbers of one target, or of a dict from task name to target, shape (target_size,).

        Raises:
            ArgumentError: naming ``target``, or ``target['left hand']`` where a dict says which one is wrong.
        """
        if isinstance(target, dict):
            if target.keys() != self._parts.keys():
                raise ArgumentError("target", list(target), f"one target for each of the tasks {list(self._parts)}")
            return np.concatenate([self._read(name, *part, target[name]) for name, part in self._parts.items()])
        if len(self.tasks) > 1:
            names = [task.name for task in self.tasks]
            raise ArgumentError("target", target, f"a dict with a target for each of the tasks {names}")
        return self.tasks[0].read_target(self.robot, target)

    @cached_property
    def _parts(self) -> dict[str, tuple[Task, tuple[int, ...] | None]]:
        """Each task by its name, with the shape of a target that is its numbers as it stands, or None."""
        sizes = {task.name: (task.target_size(self.robot),) for task in self.tasks}
        return {task.name: (task, sizes[task.name] if task.plain(self.robot) else None) for task in self.tasks}

    def _read(self, name: str, task: Task, plain: tuple[int, ...] | None, target: Any) -> Array:
        """The numbers of one target of a dict."""
        if type(target) is np.ndarray and target.shape == plain and target.dtype == np.float64:
            usual: Array = target
            if math.isfinite(sum(usual.tolist())):
                return usual
        try:
            return task.read_target(self.robot, target)
        except ArgumentError as error:
            raise ArgumentError(f"target[{name!r}]", error.given, error.accepted) from None

    def rows(self, kinematics: Kinematics, target: Expression) -> StackRows:
        """The rows of all tasks, with their Jacobian."""
        errors: list[Expression] = []
        jacobians: list[Expression] = []
        linear: list[bool] = []
        rows_of: dict[int, list[int]] = {}
        start, tangent = 0, self.robot.tangent(kinematics.q)
        for task in self.tasks:
            size = task.target_size(self.robot)
            rows = task.rows(kinematics, target[start : start + size])
            errors.append(rows.error)
            rows_of.setdefault(task.priority, []).extend(range(len(linear), len(linear) + len(rows.linear)))
            linear.extend(rows.linear)
            own = rows.jacobian
            jacobians.append(jacobian(rows.error, kinematics.q) @ tangent if own is None else own)
            start += size
        levels = tuple(tuple(rows_of[priority]) for priority in sorted(rows_of))
        return StackRows(vertcat(*errors), tuple(linear), vertcat(*jacobians), levels)

    def moving_joints(self) -> tuple[str, ...]:
        """The joints that move a frame some task is about, or that its error depends on, in the robot's order."""
        robot, moving = self.robot, set[str]()
        kinematics = robot.at(symbol("q", robot.nq))
        for task in self.tasks:
            frames = task.frames(robot)
            for frame in frames:
                moving |= {joint.mimic.joint if joint.mimic else joint.name for joint in robot.path(frame)}
            if not frames:
                moving |= _felt(task.rows(kinematics, symbol("target", task.target_size(robot))).error, kinematics)
        return tuple(joint for joint in robot.joint_names if joint in moving)

    def weight_factor(self) -> Array:
        """L with ``Kp = L L'``: the residual ``L' e`` has the weighted norm of e. Shape (m, m), lower triangular."""
        blocks = [np.linalg.cholesky(task.weight(task.row_count(self.robot))) for task in self.tasks]
        total = sum(len(block) for block in blocks)
        factor, start = np.zeros((total, total)), 0
        for block in blocks:
            stop = start + len(block)
            factor[start:stop, start:stop] = block
            start = stop
        return factor


def _felt(error: Expression, kinematics: Kinematics) -> set[str]:
    """The joints whose position appears in an error."""
    robot, q = kinematics.robot, kinematics.q
    names = {entry.name() for entry in symvar(error)}
    felt = [q[i].name() in names for i in range(robot.nq)]
    return {joint for joint in robot.joint_names if any(felt[robot.q_slice(joint)])}

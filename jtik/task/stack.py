"""All tasks of a solver as one: their rows stacked, their targets by name."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from jtik.arguments import instances
from jtik.errors import ArgumentError
from jtik.result.deprecated import RenamedAttribute
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, Function, jacobian, symbol, symvar, vertcat
from jtik.task.base import Task
from jtik.types import Array


@dataclass(frozen=True)
class StackRows:
    """The rows of all tasks together.

    Attributes:
        error: the errors (m, 1) [m] and [rad].
        linear: for each row, True for a length [m] and False for an angle [rad].
        jacobian: derivative of the errors with respect to the velocity, (m, n).
        levels: the indices of the rows of each level of priority, the highest level first.
        near_jacobian: a cheaper matrix (m, n) that approaches ``jacobian`` where the error approaches zero.
    """

    error: Expression
    linear: tuple[bool, ...]
    jacobian: Expression
    levels: tuple[tuple[int, ...], ...]
    near_jacobian: Expression


@dataclass(frozen=True)
class TaskStack:
    """All tasks of a solver, stacked, on one robot.

    Attributes:
        robot: the robot.
        tasks: the tasks, in the order of their rows.
    """

    robot: Robot
    tasks: tuple[Task, ...]

    @classmethod
    def of(cls, robot: Robot, tasks: Task | Iterable[Task]) -> TaskStack:
        """The stack of one task or several.

        Args:
            robot: the robot.
            tasks: a task, or several with different names.

        Raises:
            ArgumentError: for no task, for anything that is not a task, or for a name that repeats.
        """
        accepted = "a jtik.Task such as jtik.FrameTask, or a list of them"
        chosen: tuple[Task, ...] = instances("task", tasks, Task, accepted)  # type: ignore[type-abstract]
        names = [task.name for task in chosen]
        if not chosen or len(set(names)) != len(names):
            raise ArgumentError("task", names, "at least one task, each with a name of its own: name=...")
        return cls(robot, chosen)

    @property
    def target_size(self) -> int:
        """How many numbers all targets have together."""
        return sum(task.target_size(self.robot) for task in self.tasks)

    @property
    def target_is_vector(self) -> bool:
        """Whether a target is a vector of ``target_size`` numbers that needs no conversion."""
        return len(self.tasks) == 1 and self.tasks[0].target_is_vector(self.robot)

    plain = RenamedAttribute("target_is_vector")

    @cached_property
    def matrix_reader(self) -> Function | None:
        """The function that reads a matrix (4, 4) as the target of the only task, as `Task.matrix_reader` gives it."""
        return self.tasks[0].matrix_reader(self.robot) if len(self.tasks) == 1 else None

    def read_target(self, target: Any) -> Array:
        """The numbers of one target, or of a dict from task name to target, shape (target_size,).

        Args:
            target: the target of the only task, or a dict from task name to target.

        Raises:
            ArgumentError: for anything else; it names ``target``, or for a dict the entry, as ``target['left hand']``.
        """
        if isinstance(target, dict):
            if target.keys() != self._parts.keys():
                raise ArgumentError("target", list(target), f"one target for each of the tasks {list(self._parts)}")
            return np.concatenate([self._read(name, *part, target[name]) for name, part in self._parts.items()])
        if len(self.tasks) > 1:
            names = [task.name for task in self.tasks]
            raise ArgumentError("target", target, f"a dict with a target for each of the tasks {names}")
        return self.tasks[0].read_target(self.robot, target)

    def read_table(self, targets: Any, read_matrices: Callable[[Array], Array | None] | None = None) -> Array | None:
        """The numbers of many targets of the only task, (k, target_size), where all are usual and valid; else None.

        Args:
            targets: arrays of float64, each a vector that needs no conversion or each a matrix (4, 4); or one array of
                all.
            read_matrices: a faster way than `Task.read_matrices`, which is not always there.
        """
        if len(self.tasks) != 1 or not len(targets):
            return None
        shape: tuple[int, ...] = (self.target_size,)
        if not self.target_is_vector or getattr(targets[0], "shape", None) == (4, 4):
            shape = (4, 4)
        if type(targets) is not np.ndarray:
            usual = [type(each) is np.ndarray and each.dtype == _FLOAT and each.shape == shape for each in targets]
            if False in usual:
                return None
            targets = np.array(targets)
        if targets.dtype != _FLOAT or targets.shape[1:] != shape:
            return None
        if shape == (4, 4):
            numbers = None if read_matrices is None else read_matrices(targets)
            return self.tasks[0].read_matrices(self.robot, targets) if numbers is None else numbers
        with np.errstate(over="ignore", invalid="ignore"):
            finite = np.isfinite(targets.sum(axis=1)).all()
        return targets.copy(order="C") if finite else None

    def unused(self, target: Any) -> str | None:
        """The parts of a target that the tasks do not use, such as "orientation of the target".

        Args:
            target: one target, or a dict from task name to target, that `read_target` accepts.

        Returns:
            A text for the report, with the names of the tasks for a dict; None where all of the target is used.
        """
        if not isinstance(target, dict):
            return self.tasks[0].unused(self.robot, target)
        parts = {task.name: task.unused(self.robot, target[task.name]) for task in self.tasks}
        found = [f"{name}: {part}" for name, part in parts.items() if part is not None]
        return "; ".join(found) or None

    @cached_property
    def _parts(self) -> dict[str, tuple[Task, tuple[int, ...] | None]]:
        """Each task by its name, with the shape of a target that needs no conversion, or None."""
        sizes = {task.name: (task.target_size(self.robot),) for task in self.tasks}
        return {
            task.name: (task, sizes[task.name] if task.target_is_vector(self.robot) else None) for task in self.tasks
        }

    def _read(self, name: str, task: Task, vector_shape: tuple[int, ...] | None, target: Any) -> Array:
        """The numbers of one target of a dict; an array that needs no conversion is read without a copy."""
        if type(target) is np.ndarray and target.shape == vector_shape and target.dtype == np.float64:
            numbers: Array = target
            if math.isfinite(sum(numbers.tolist())):
                return numbers
        try:
            return task.read_target(self.robot, target)
        except ArgumentError as error:
            raise ArgumentError(f"target[{name!r}]", error.given, error.accepted) from None

    def rows(self, kinematics: Kinematics, target: Expression) -> StackRows:
        """The rows of all tasks, with their Jacobian.

        Args:
            kinematics: the robot at a symbolic configuration.
            target: the numbers of all targets as symbols (target_size, 1).
        """
        errors: list[Expression] = []
        jacobians: list[Expression] = []
        near: list[Expression] = []
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
            near.append(jacobians[-1] if rows.near_jacobian is None else rows.near_jacobian)
            start += size
        levels = tuple(tuple(rows_of[priority]) for priority in sorted(rows_of))
        return StackRows(vertcat(*errors), tuple(linear), vertcat(*jacobians), levels, vertcat(*near))

    def held_target(self, kinematics: Kinematics, target: Expression) -> Expression:
        """The numbers of the targets that ``kinematics.q`` meets; those of ``target`` for tasks that do not say.

        Args:
            kinematics: the robot at a symbolic configuration.
            target: the numbers of all targets as symbols (target_size, 1).
        """
        start, held = 0, []
        for task in self.tasks:
            size = task.target_size(self.robot)
            own = task.held_target(kinematics)
            held.append(target[start : start + size] if own is None else own)
            start += size
        return vertcat(*held)

    @cached_property
    def row_indices(self) -> dict[str, tuple[int, ...]]:
        """The indices of the rows of each task, by name."""
        ends = np.cumsum([0, *(task.row_count(self.robot) for task in self.tasks)]).tolist()
        return {task.name: tuple(range(ends[i], ends[i + 1])) for i, task in enumerate(self.tasks)}

    def moving_joints(self) -> tuple[str, ...]:
        """The joints that move a frame of some task, or on which its error depends, in the order of the robot."""
        robot, moving = self.robot, set[str]()
        kinematics = robot.at(symbol("q", robot.nq))
        for task in self.tasks:
            frames = task.frames(robot)
            for frame in frames:
                moving |= {joint.mimic.joint if joint.mimic else joint.name for joint in robot.path(frame)}
            if not frames:
                moving |= _joints_in(task.rows(kinematics, symbol("target", task.target_size(robot))).error, kinematics)
        return tuple(joint for joint in robot.joint_names if joint in moving)

    def weight_factor(self) -> Array:
        """The Cholesky factor L (m, m) of the stiffness, ``Kp = L L'``: ``L' e`` has the weighted norm of e."""
        blocks = [np.linalg.cholesky(task.weight(task.row_count(self.robot))) for task in self.tasks]
        total = sum(len(block) for block in blocks)
        factor, start = np.zeros((total, total)), 0
        for block in blocks:
            stop = start + len(block)
            factor[start:stop, start:stop] = block
            start = stop
        return factor


def _joints_in(error: Expression, kinematics: Kinematics) -> set[str]:
    """The joints on which an error depends."""
    robot, q = kinematics.robot, kinematics.q
    names = {entry.name() for entry in symvar(error)}
    appears = [q[i].name() in names for i in range(robot.nq)]
    return {joint for joint in robot.joint_names if any(appears[robot.q_slice(joint)])}


_FLOAT = np.dtype(np.float64)

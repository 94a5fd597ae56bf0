"""The primary task: what the tip must do, as an error e(q, target) whose every row is in [m] or [rad]."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jtik import rotation
from jtik.errors import ArgumentError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, atan2, cos, reshape, sin, symbol, vertcat

Array = NDArray[np.float64]
Kind = Literal["position", "orientation", "pose"]

_ROTATION_TOLERANCE = 1e-6
"""How far a target's rotation may be from orthonormal: what six printed digits leave."""


@dataclass(frozen=True)
class TaskRows:
    """The rows of a task on one robot: error (m, 1) and, for each row, whether it is a length [m] or an angle [rad]."""

    error: Expression
    linear: tuple[bool, ...]


class Task(ABC):
    """Something the robot must do. Subclass it by an error and the numbers that make up a target.

    ``name`` identifies the task in a dict of targets; ``priority`` orders tasks for the strategies that know levels
    (0 is the highest).
    """

    name: str
    priority: int

    @abstractmethod
    def target_size(self, robot: Robot) -> int:
        """How many numbers a target of this task is, on this robot."""

    @abstractmethod
    def read_target(self, robot: Robot, target: Any) -> Array:
        """The numbers of ``target``, shape (target_size,). Raises ArgumentError for what is not a target."""

    def plain(self, robot: Robot) -> bool:
        """Whether a vector of ``target_size`` numbers is a target as it stands."""
        return False

    @abstractmethod
    def rows(self, kinematics: Kinematics, target: Expression) -> TaskRows:
        """The error at ``kinematics.q`` for the symbolic ``target`` (target_size, 1)."""

    @abstractmethod
    def weight(self, rows: int) -> Array:
        """Stiffness Kp (rows, rows), symmetric positive definite, of a task with that many rows."""


class FrameTask(Task):
    """Bring a frame of the robot to a target: its position, its orientation, or both.

    Error: position in world axes, ``p(q) - p_target`` [m]; orientation in the *target's* axes, the logarithm of
    ``R_target' R(q)`` [rad], so that dropping its z row frees the spin about the tool's z axis. On a planar robot a
    position is (x, y) and an orientation is one angle, with an error in (-pi, pi].

    Args:
        frame: name of the frame.
        kind: "position", "orientation" or "pose".
        axes: which rows to keep, of "x", "y", "z" (position) and "rx", "ry", "rz" (orientation); None keeps all.
        stiffness: Kp of the paper: a scalar, one value a row, or an SPD matrix (m, m). A length of L metres counts as
            much as one radian where orientation rows have stiffness L^2 times that of position rows.
        priority: level for the strategies that know levels; 0 is the highest.
        name: how a dict of targets refers to the task; the frame's name by default.
    """

    def __init__(
        self,
        frame: str = "tip",
        kind: Kind = "position",
        *,
        axes: str | Sequence[str] | None = None,
        stiffness: ArrayLike = 1.0,
        priority: int = 0,
        name: str | None = None,
    ) -> None:
        if kind not in ("position", "orientation", "pose"):
            raise ArgumentError("kind", kind, "'position', 'orientation' or 'pose'")
        if not isinstance(priority, int) or priority < 0:
            raise ArgumentError("priority", priority, "an integer from 0 (the highest level)")
        self.frame = frame
        self.kind: Kind = kind
        self.axes = None if axes is None else tuple(axes)
        self.stiffness = np.array(stiffness, dtype=float)
        self.priority = priority
        self.name = name or frame
        if self.stiffness.ndim > 2 or not np.all(np.isfinite(self.stiffness)):
            raise ArgumentError("stiffness", stiffness, "a finite scalar, one value a row, or a square matrix")

    def __repr__(self) -> str:
        return f"FrameTask({self.frame!r}, kind={self.kind!r})"

    def _names(self, robot: Robot) -> list[str]:
        """Names of all rows the kind has on this robot, before ``axes`` chooses."""
        position = ["x", "y"] if robot.dimension == 2 else ["x", "y", "z"]
        orientation = ["rz"] if robot.dimension == 2 else ["rx", "ry", "rz"]
        return {"position": position, "orientation": orientation, "pose": position + orientation}[self.kind]

    def _kept(self, robot: Robot) -> list[int]:
        names = self._names(robot)
        if self.axes is None:
            return list(range(len(names)))
        unknown = [axis for axis in self.axes if axis not in names]
        if unknown or not self.axes or len(set(self.axes)) != len(self.axes):
            raise ArgumentError("axes", self.axes, f"distinct names from {names} for kind {self.kind!r}")
        return [names.index(axis) for axis in self.axes]

    def target_size(self, robot: Robot) -> int:
        """Position: 2 or 3; orientation: 1 angle or 9 entries of R; pose: both."""
        position, orientation = (2, 1) if robot.dimension == 2 else (3, 9)
        return {"position": position, "orientation": orientation, "pose": position + orientation}[self.kind]

    def plain(self, robot: Robot) -> bool:
        """Positions are, and everything in the plane."""
        return self.kind == "position" or robot.dimension == 2

    def accepted(self, robot: Robot) -> str:
        """What a target may be, in words."""
        if robot.dimension == 2:
            plain = {"position": "(x, y) [m]", "orientation": "an angle [rad]", "pose": "(x, y, angle) [m, rad]"}
        else:
            plain = {
                "position": "(x, y, z) [m]",
                "orientation": "a rotation matrix (3, 3)",
                "pose": "a pose (4, 4)",
            }
        return f"{plain[self.kind]}, a pose (4, 4), or an object with as_matrix()"

    def read_target(self, robot: Robot, target: Any) -> Array:
        """A position, angle, rotation or pose, or an object with ``as_matrix()``, as the task's numbers."""
        given = target
        if hasattr(target, "as_matrix"):
            target = target.as_matrix()
        try:
            array = np.array(target, dtype=float)
        except (TypeError, ValueError):
            raise ArgumentError("target", given, self.accepted(robot)) from None
        if not np.all(np.isfinite(array)):
            raise ArgumentError("target", given, f"finite numbers: {self.accepted(robot)}")
        size = self.target_size(robot)
        if array.shape == (4, 4):
            self._check_pose(array, robot, given)
            position, R = array[: robot.dimension, 3], array[:3, :3]
        elif self.kind == "orientation" and array.shape == (3, 3):
            self._check_rotation(array, given)
            position, R = np.zeros(0), array
        elif array.shape == (size,) and (self.kind == "position" or robot.dimension == 2):
            return array
        elif robot.dimension == 2 and self.kind == "orientation" and array.shape == ():
            return array.reshape(1)
        else:
            raise ArgumentError("target", given, self.accepted(robot))
        if self.kind == "position":
            return position
        turn = np.array([np.arctan2(R[1, 0], R[0, 0])]) if robot.dimension == 2 else R.ravel(order="F")
        return turn if self.kind == "orientation" else np.concatenate([position, turn])

    def _check_pose(self, pose: Array, robot: Robot, given: object) -> None:
        self._check_rotation(pose[:3, :3], given)
        if np.abs(pose[3] - (0, 0, 0, 1)).max() > _ROTATION_TOLERANCE:
            raise ArgumentError("target", given, "a pose with the last row (0, 0, 0, 1)")
        off_plane = max(np.abs(pose[2, :3] - (0, 0, 1)).max(), abs(pose[2, 3]))
        if robot.dimension == 2 and off_plane > _ROTATION_TOLERANCE:
            raise ArgumentError("target", given, "a pose in the plane of this planar robot: z = 0, turned about z")

    @staticmethod
    def _check_rotation(R: Array, given: object) -> None:
        if np.abs(R.T @ R - np.eye(3)).max() > _ROTATION_TOLERANCE or np.linalg.det(R) < 0:
            raise ArgumentError("target", given, "a rotation: orthonormal columns, determinant +1")

    def rows(self, kinematics: Kinematics, target: Expression) -> TaskRows:
        """Position rows in world axes, orientation rows in the target's axes."""
        robot = kinematics.robot
        kept = self._kept(robot)
        split = 0 if self.kind == "orientation" else (robot.dimension)
        parts = []
        if self.kind != "orientation":
            parts.append(kinematics.position(self.frame) - target[:split])
        if self.kind != "position":
            parts.append(_turn(kinematics.rotation(self.frame), target[split:], robot.dimension))
        error = vertcat(*parts)
        return TaskRows(
            error=vertcat(*[error[row] for row in kept]),
            linear=tuple(row < split for row in kept),
        )

    def weight(self, rows: int) -> Array:
        """Kp as a matrix. Raises ArgumentError when it does not fit or is not symmetric positive definite."""
        wanted = f"a positive scalar, {rows} positive values, or a symmetric positive definite ({rows}, {rows})"
        K = self.stiffness
        if K.ndim == 0:
            K = K * np.eye(rows)
        elif K.shape == (rows,):
            K = np.diag(K)
        if K.shape != (rows, rows) or not np.allclose(K, K.T, rtol=1e-12, atol=0):
            raise ArgumentError("stiffness", self.stiffness, wanted)
        if np.linalg.eigvalsh(K)[0] <= 0:
            raise ArgumentError("stiffness", self.stiffness, wanted)
        return np.asarray(K)


def _turn(R: Expression, target: Expression, dimension: int) -> Expression:
    """Rotation from the target to ``R``, in the target's axes: one angle in the plane, a rotation vector in space."""
    if dimension == 2:
        c, s = cos(target[0]), sin(target[0])
        return atan2(R[1, 0] * c - R[0, 0] * s, R[0, 0] * c + R[1, 0] * s)
    return rotation.log(reshape(target, 3, 3).T @ R)


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
            raise ArgumentError("task", names, "at least one task, each with a name of its own")
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
        """The numbers of one target, or of a dict from task name to target, shape (target_size,)."""
        names = [task.name for task in self.tasks]
        if isinstance(target, dict):
            if set(target) != set(names):
                raise ArgumentError("target", sorted(target), f"one target for each of the tasks {names}")
            return np.concatenate([task.read_target(self.robot, target[task.name]) for task in self.tasks])
        if len(self.tasks) > 1:
            raise ArgumentError("target", target, f"a dict with a target for each of the tasks {names}")
        return self.tasks[0].read_target(self.robot, target)

    def rows(self, kinematics: Kinematics, target: Expression) -> TaskRows:
        """The rows of all tasks."""
        errors: list[Expression] = []
        linear: list[bool] = []
        start = 0
        for task in self.tasks:
            size = task.target_size(self.robot)
            rows = task.rows(kinematics, target[start : start + size])
            errors.append(rows.error)
            linear.extend(rows.linear)
            start += size
        return TaskRows(vertcat(*errors), tuple(linear))

    def weight_factor(self) -> Array:
        """L with ``Kp = L L'``: the residual ``L' e`` has the weighted norm of e. Shape (m, m), lower triangular."""
        kinematics = self.robot.at(symbol("q", self.robot.nq))
        blocks = []
        for task in self.tasks:
            rows = task.rows(kinematics, symbol("target", task.target_size(self.robot)))
            blocks.append(np.linalg.cholesky(task.weight(len(rows.linear))))
        total = sum(len(block) for block in blocks)
        factor, start = np.zeros((total, total)), 0
        for block in blocks:
            stop = start + len(block)
            factor[start:stop, start:stop] = block
            start = stop
        return factor

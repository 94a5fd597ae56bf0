"""Base of all peers: import of their library, the single task that they support, and its targets as poses."""

from __future__ import annotations

import importlib
import math
from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from jtik.errors import ArgumentError, JtikError
from jtik.robot import Robot
from jtik.study.contender import Contender, PreparedContender, Setting
from jtik.task import FrameTask, TaskStack
from jtik.types import Array

ROUNDING = 1e-6
"""Violation of a limit that is attributed to the tolerance of a QP solver and clamped [rad], [m]."""


class NotInstalledError(JtikError, ModuleNotFoundError):
    """The library of a peer is not installed or cannot be imported.

    Attributes:
        package: the package to install.
        reason: why its import failed; "" if it is not installed.
    """

    def __init__(self, package: str, reason: str = "") -> None:
        super().__init__(package, reason)
        self.package = package
        self.reason = reason

    def __str__(self) -> str:
        if self.reason:
            return f"cannot be imported ({self.reason}); installed by: python -m pip install {self.package}"
        return f"not installed: python -m pip install {self.package}"


def imported(module: str, package: str) -> Any:
    """Import a module of an optional package.

    Raises:
        NotInstalledError: if it is not installed or cannot be imported.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        missing = error.name == module.split(".")[0]
        raise NotInstalledError(package, "" if missing else str(error)) from error
    except ImportError as error:
        raise NotInstalledError(package, str(error)) from error


@dataclass(frozen=True, kw_only=True, eq=False)
class Goal:
    """The part of a setting that a peer solves: one `FrameTask`, whose targets are poses in space.

    Attributes:
        setting: the setting.
        robot: the reduced robot.
        tasks: the task on it, as a stack.
        task: the task.
    """

    setting: Setting
    robot: Robot
    tasks: TaskStack
    task: FrameTask

    @classmethod
    def of(cls, setting: Setting, peer: str) -> Goal:
        """The goal of a setting.

        Args:
            setting: the setting.
            peer: name of the peer, for error messages.

        Raises:
            ArgumentError: unless the task is one `FrameTask` with all of its axes, whose frame no mimic joint moves.
        """
        robot, tasks = setting.reduced()
        task = tasks.tasks[0]
        if len(tasks.tasks) > 1 or type(task) is not FrameTask or task.axes is not None:
            raise ArgumentError("task", list(tasks.tasks), f"for {peer}: one FrameTask with all of its axes")
        for joint in robot.path(task.frame):
            if joint.mimic is not None:
                given = f"mimic joint {joint.name!r}, which follows {joint.mimic.joint!r}"
                raise ArgumentError("robot", given, f"for {peer}: no mimic joint between the base and {task.frame!r}")
        return cls(setting=setting, robot=robot, tasks=tasks, task=task)

    @property
    def frame(self) -> str:
        """The frame of the task."""
        return self.robot.frame(self.task.frame)

    @property
    def planar(self) -> bool:
        """Whether the robot moves in the x-y plane."""
        return self.robot.dimension == 2

    @property
    def has_position(self) -> bool:
        """Whether the task has a position."""
        return self.task.kind != "orientation"

    @property
    def has_orientation(self) -> bool:
        """Whether the task has an orientation."""
        return self.task.kind != "position"

    @cached_property
    def chain_indices(self) -> tuple[int, ...]:
        """Indices in q of the joints on the path to the frame, from the base."""
        robot = self.robot
        return tuple(robot.q_slice(joint.name).start for joint in robot.path(self.frame) if joint.is_independent)

    def require_scalar_joints(self, peer: str) -> None:
        """Raise ArgumentError unless all independent joints are revolute or prismatic."""
        for joint in self.robot.independent_joints:
            if not joint.type.is_scalar:
                given = f"a {joint.type.value} joint {joint.name!r}"
                raise ArgumentError("robot", given, f"for {peer}: revolute and prismatic joints")

    def pose(self, target: Any) -> Array:
        """A target as T_base_frame (4, 4); components outside the task are those of the neutral configuration."""
        values, pose = self.tasks.read_target(target), self._neutral.copy()
        split = self.robot.dimension if self.has_position else 0
        pose[:split, 3] = values[:split]
        if self.has_orientation and self.planar:
            c, s = math.cos(values[split]), math.sin(values[split])
            flipped = np.diag([1.0, pose[2, 2], pose[2, 2]])  # the z axis of the frame may point down
            pose[:3, :3] = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ flipped
        elif self.has_orientation:
            pose[:3, :3] = values[split:].reshape(3, 3, order="F")
        return pose

    @cached_property
    def _neutral(self) -> Array:
        pose: Array = self.robot.pose(self.robot.neutral, self.frame)
        return pose

    @cached_property
    def lower(self) -> Array:
        """Lower limits (nq,), -inf if there are none or they do not apply."""
        return self.robot.lower if self.setting.limits else np.full(self.robot.nq, -math.inf)

    @cached_property
    def upper(self) -> Array:
        """Upper limits (nq,), inf if there are none or they do not apply."""
        return self.robot.upper if self.setting.limits else np.full(self.robot.nq, math.inf)

    def bounds(self, *, turn: float = math.pi) -> tuple[Array, Array]:
        """Limits (nq,), with -turn and turn [rad] or [m] for those that are infinite."""
        return np.where(np.isfinite(self.lower), self.lower, -turn), np.where(np.isfinite(self.upper), self.upper, turn)

    @cached_property
    def bare(self) -> Robot:
        """The robot as joints only, without limits if they do not apply, for libraries that always keep limits."""
        joints = self.robot.joints
        if not self.setting.limits:
            joints = tuple(replace(joint, lower=-math.inf, upper=math.inf) for joint in joints)
        return Robot(joints, name=self.robot.name, base=self.robot.base, tip=self.robot.tip)

    def clamped(self, q: Array) -> Array:
        """``q`` clamped to the limits."""
        return np.clip(q, self.lower, self.upper)

    def clamped_rounding(self, q: Array) -> Array:
        """``q`` with violations of limits up to `ROUNDING` clamped."""
        clamped = self.clamped(q)
        return np.where(abs(q - clamped) <= ROUNDING, clamped, q)

    def starts(self, q0: Array) -> Iterator[Array]:
        """``q0`` and the starts of all restarts, the same ones at every call."""
        yield self.clamped(q0)
        if self.setting.restarts:
            generator = np.random.default_rng(self.setting.seed)
            for _ in range(self.setting.restarts):
                yield self.robot.random_configuration(generator)

    def is_reached(self, position: float, orientation: float) -> bool:
        """Whether the errors [m], [rad] of the task are within the tolerances."""
        return (not self.has_position or position <= self.setting.position_tolerance) and (
            not self.has_orientation or orientation <= self.setting.orientation_tolerance
        )


@dataclass(kw_only=True)
class Peer(Contender):
    """Another library as a contender, with default options that were found to work well.

    Attributes:
        label: its name in the study.
        module: name of the module to import.
        package: name of the package to install.
    """

    label: str = ""
    module: ClassVar[str]
    package: ClassVar[str]

    def prepare(self, setting: Setting) -> PreparedContender:
        """Build the peer for a setting.

        Raises:
            ArgumentError: if the peer does not support the setting.
            NotInstalledError: if its library is not installed.
        """
        goal = Goal.of(setting, self.label)
        self.check(goal)
        prepared = self.build(imported(self.module, self.package), goal)
        left_out = []
        if setting.criteria is not None and not self.optimizes:
            left_out.append("the criterion")
        if setting.clearances:
            left_out.append("the clearances")
        prepared.note = f"without {' and '.join(left_out)}" if left_out else ""
        return prepared

    def check(self, goal: Goal) -> None:
        """Raise ArgumentError for a goal that the peer does not support.

        Args:
            goal: the robot, the task and the options of the study.
        """
        goal.require_scalar_joints(self.label)

    @abstractmethod
    def build(self, library: Any, goal: Goal) -> PreparedContender:
        """Build the peer with its library.

        Args:
            library: the imported module of the peer.
            goal: the robot, the task and the options of the study.
        """

"""What all peers share: where they come from, the one task they can take, and its targets as poses in space."""

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
"""How far [rad] or [m] beyond a limit an answer may be put down to the tolerance of a QP solver, and led back."""


class NotInstalledError(JtikError, ModuleNotFoundError):
    """A peer's library is not there.

    Attributes:
        package: what to install.
        reason: what else went wrong when it was imported, or "".
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
    """The module of that name, of a package that may not be installed.

    Raises:
        NotInstalledError: when it is not, or does not import.
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
    """The part of a setting that a peer works on: one frame of one robot, to be brought to poses in space.

    Attributes:
        setting: the whole of it.
        robot: the robot with only the joints that take part.
        tasks: the task on it.
        task: the task.
    """

    setting: Setting
    robot: Robot
    tasks: TaskStack
    task: FrameTask

    @classmethod
    def of(cls, setting: Setting, peer: str) -> Goal:
        """Read a setting.

        Raises:
            ArgumentError: when it is not one whole `FrameTask`, or joints that follow others move its frame.
        """
        robot, tasks = setting.reduced()
        task = tasks.tasks[0]
        if len(tasks.tasks) > 1 or type(task) is not FrameTask or task.axes is not None:
            raise ArgumentError("task", list(tasks.tasks), f"for {peer}: one FrameTask with all of its axes")
        for joint in robot.path(task.frame):
            if joint.mimic is not None:
                given = f"joint {joint.name!r}, which follows {joint.mimic.joint!r}"
                raise ArgumentError("robot", given, f"for {peer}: joints that follow no others up to {task.frame!r}")
        return cls(setting=setting, robot=robot, tasks=tasks, task=task)

    @property
    def frame(self) -> str:
        """The frame to bring there."""
        return self.task.frame

    @property
    def planar(self) -> bool:
        """Whether everything happens in the x-y plane."""
        return self.robot.dimension == 2

    @property
    def has_position(self) -> bool:
        """Whether the position matters."""
        return self.task.kind != "orientation"

    @property
    def has_orientation(self) -> bool:
        """Whether the orientation matters."""
        return self.task.kind != "position"

    @cached_property
    def chain_indices(self) -> tuple[int, ...]:
        """Places in q of the joints on the way to the frame, from the base on."""
        robot = self.robot
        return tuple(robot.q_slice(joint.name).start for joint in robot.path(self.frame) if joint.is_independent)

    def require_scalar_joints(self, peer: str) -> None:
        """Raise ArgumentError unless these are all of the robot's joints that move."""
        for joint in self.robot.independent_joints:
            if not joint.type.is_scalar:
                given = f"a {joint.type.value} joint {joint.name!r}"
                raise ArgumentError("robot", given, f"for {peer}: hinges and slides")

    def pose(self, target: Any) -> Array:
        """A target as T_base_frame (4, 4); what the task does not ask for is the frame's at the neutral posture."""
        values, pose = self.tasks.read_target(target), self._neutral.copy()
        split = self.robot.dimension if self.has_position else 0
        pose[:split, 3] = values[:split]
        if self.has_orientation and self.planar:
            c, s = math.cos(values[split]), math.sin(values[split])
            flipped = np.diag([1.0, pose[2, 2], pose[2, 2]])  # a frame may hang upside down in the plane
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
        """Lower limits (nq,), -inf where there are none or they do not hold."""
        return self.robot.lower if self.setting.limits else np.full(self.robot.nq, -math.inf)

    @cached_property
    def upper(self) -> Array:
        """Upper limits (nq,), inf where there are none or they do not hold."""
        return self.robot.upper if self.setting.limits else np.full(self.robot.nq, math.inf)

    def bounds(self, *, turn: float = math.pi) -> tuple[Array, Array]:
        """Limits (nq,) with -turn and turn [rad] or [m] where there are none."""
        return np.where(np.isfinite(self.lower), self.lower, -turn), np.where(np.isfinite(self.upper), self.upper, turn)

    @cached_property
    def bare(self) -> Robot:
        """The robot as joints alone, without the limits where they do not hold: for the libraries that keep them."""
        joints = self.robot.joints
        if not self.setting.limits:
            joints = tuple(replace(joint, lower=-math.inf, upper=math.inf) for joint in joints)
        return Robot(joints, name=self.robot.name, base=self.robot.base, tip=self.robot.tip)

    def clamped(self, q: Array) -> Array:
        """The nearest configuration within the limits."""
        return np.clip(q, self.lower, self.upper)

    def clamped_rounding(self, q: Array) -> Array:
        """``q`` led back into limits that it leaves by no more than `ROUNDING`."""
        kept = self.clamped(q)
        return np.where(abs(q - kept) <= ROUNDING, kept, q)

    def starts(self, q0: Array) -> Iterator[Array]:
        """``q0`` and as many others as there may be restarts, the same ones every time."""
        yield self.clamped(q0)
        if self.setting.restarts:
            generator = np.random.default_rng(self.setting.seed)
            for _ in range(self.setting.restarts):
                yield self.robot.random_configuration(generator)

    def is_reached(self, position: float, orientation: float) -> bool:
        """Whether errors [m], [rad] are within the tolerances, where they matter."""
        return (not self.has_position or position <= self.setting.position_tolerance) and (
            not self.has_orientation or orientation <= self.setting.orientation_tolerance
        )


@dataclass(kw_only=True)
class Peer(Contender):
    """Another library as a contender. Its options are those that it is known to do well with.

    A study may give it another label, so it is no frozen value.

    Attributes:
        label: what to call it.
    """

    label: str = ""
    module: ClassVar[str]
    """What is imported."""
    package: ClassVar[str]
    """What is installed."""

    def prepare(self, setting: Setting) -> PreparedContender:
        """Build it for a setting.

        Raises:
            ArgumentError: when the peer cannot do what is asked.
            NotInstalledError: when its library is not there.
        """
        goal = Goal.of(setting, self.label)
        self.check(goal)
        ready = self.build(imported(self.module, self.package), goal)
        left_out = []
        if setting.criteria is not None and not self.optimizes:
            left_out.append("the criterion")
        if setting.clearances:
            left_out.append("the clearances")
        ready.note = f"without {' and '.join(left_out)}" if left_out else ""
        return ready

    def check(self, goal: Goal) -> None:
        """Raise ArgumentError for a goal that the peer cannot have."""
        goal.require_scalar_joints(self.label)

    @abstractmethod
    def build(self, library: Any, goal: Goal) -> PreparedContender:
        """Build it with its library."""

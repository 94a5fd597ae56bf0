"""The targets of the tasks: one that the operator guides, and the others, which are held."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Self

import numpy as np

from jtik.arguments import finite_array, mapping
from jtik.errors import UnknownNameError
from jtik.planner.session import rotations
from jtik.planner.session.arm import Arm
from jtik.planner.session.settings import Problem
from jtik.types import Array


class Pose(NamedTuple):
    """Where a target is.

    Attributes:
        position: its position (2,) or (3,) [m].
        orientation: its orientation, a unit quaternion (w, x, y, z).
    """

    position: Array
    orientation: Array


@dataclass(frozen=True, eq=False)
class Targets:
    """Which task is guided, and where the targets of the others are.

    Attributes:
        guided: name of the task that the operator guides.
        held: the targets of the others by name of the task.
    """

    guided: str
    held: Mapping[str, Pose] = field(default_factory=dict)

    def with_guided(self, name: str, left: Pose) -> Self:
        """Another task guided.

        Args:
            name: name of that task.
            left: where the target of the task that was guided stays.
        """
        held = {**self.held, self.guided: left}
        held.pop(name)
        return replace(self, guided=name, held=held)

    def to_plain(self, problem: Problem) -> dict[str, Any]:
        """Plain data for the settings of an attempt, which `of_settings` reads."""
        held = {name: np.concatenate(pose).tolist() for name, pose in self.held.items()}
        return {"guided": self.guided, "frame": problem.guided_frame(self.guided), "held": held}


def of_settings(settings: Mapping[str, Any], problem: Problem, others: Targets) -> Targets:
    """The targets in the settings of an attempt; others where it has none, as with one task.

    Args:
        settings: settings of the attempt.
        problem: what stays as it is.
        others: the targets where the settings have none.

    Raises:
        ArgumentError: for targets that cannot be read.
        UnknownNameError: for a task that does not exist.
    """
    if "targets" not in settings:
        return others
    given = mapping("settings.targets", settings["targets"], "the guided task, and the held ones")
    tasks, held, d = problem.task_by_name, {}, problem.robot.dimension
    for name, numbers in mapping("settings.targets.held", given.get("held"), "positions and quaternions").items():
        pose = finite_array(f"settings.targets.held[{name!r}]", numbers, (d + 4,))
        held[name] = Pose(pose[:d], pose[d:])
    guided = given.get("guided")
    for name in (guided, *held):
        if name not in tasks:
            raise UnknownNameError("task", str(name), tasks)
    if {guided, *held} != set(tasks):
        raise UnknownNameError("task", str(next(iter(set(tasks) - {guided, *held}))), [str(guided), *held])
    return Targets(str(guided), held)


def guided_frame(settings: Mapping[str, Any], arm: Arm) -> str:
    """Frame that is guided in an attempt, whose path it is; the end effector where its settings name none."""
    given = settings.get("targets")
    frame = given.get("frame") if isinstance(given, Mapping) else None
    return frame if isinstance(frame, str) and frame in arm.robot.frame_names else arm.tip


def target_of(problem: Problem, targets: Targets, position: Array, orientation: Array | None) -> Any:
    """The targets as the solver reads them.

    Args:
        problem: what stays as it is.
        targets: the held ones.
        position: position of the guided one, (2,) or (3,) [m].
        orientation: its orientation, a unit quaternion (w, x, y, z); None where its task uses none.
    """
    if len(problem.tasks) == 1:
        return _target(problem, problem.tasks[0].target_kind, position, orientation)
    poses: dict[str, Any] = {**targets.held, targets.guided: (position, orientation)}
    return {task.name: _target(problem, task.target_kind, *poses[task.name]) for task in problem.tasks}


def _target(problem: Problem, kind: str, position: Array, orientation: Array | None) -> Any:
    """The target of one task as it reads it."""
    if kind == "position" or orientation is None:
        return position
    if problem.robot.dimension == 2:
        angle = 2 * math.atan2(orientation[3], orientation[0])
        return np.array([angle] if kind == "orientation" else [*position, angle])
    if kind == "orientation":
        return rotations.matrix(orientation)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotations.matrix(orientation), position
    return pose

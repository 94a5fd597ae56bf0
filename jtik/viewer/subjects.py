"""What is shown: each robot with its motion, and with its solver where it has one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from jtik.arguments import instance
from jtik.arguments import names as read_names
from jtik.errors import ArgumentError
from jtik.geometry import HalfSpace
from jtik.plotting.body import THICKNESS, Poses, reach
from jtik.plotting.obstacles_in import obstacles_in
from jtik.plotting.postures import configurations_of, spaced
from jtik.plotting.surfaces import Extent, extent_of, obstacle_surface
from jtik.result import Solution, Trajectory
from jtik.robot import Robot
from jtik.solver import InverseKinematics
from jtik.types import Array

ACCEPTED = "a jtik.Robot, InverseKinematics, Solution or Trajectory, a configuration, or one Comparison alone"


@dataclass(frozen=True, eq=False)
class Subject:
    """A robot and its motion.

    Attributes:
        label: its name in the panel.
        robot: the robot.
        q: configurations, (k, nq); one where it does not move by itself.
        times: time of each configuration, (k,) [s]; or iterations.
        ik: the solver of its target; None to make one.
        obstacles: the obstacles of its solver.
    """

    label: str
    robot: Robot
    q: Array
    times: Array
    ik: InverseKinematics | None = None
    obstacles: tuple[Any, ...] = ()

    @property
    def moves(self) -> bool:
        """Whether it has a motion."""
        return len(self.q) > 1

    def with_obstacles(self, obstacles: tuple[Any, ...]) -> Subject:
        """The same with other obstacles of its solver."""
        return replace(self, obstacles=obstacles)

    def at(self, time: float) -> Array:
        """The configuration (nq,) at a time: on a straight line in joint space between those given."""
        k = int(np.clip(np.searchsorted(self.times, time, side="right") - 1, 0, len(self.q) - 1))
        if k == len(self.q) - 1 or time <= self.times[0]:
            return np.asarray(self.q[k])
        share = (time - self.times[k]) / (self.times[k + 1] - self.times[k])
        displacement = self.robot.difference(self.q[k], self.q[k + 1])
        return np.asarray(self.robot.integrate(self.q[k], share * displacement))


def read_subjects(given: Sequence[Any], robot: Any, labels: Iterable[str] | None) -> list[Subject]:
    """The subjects of what `jtik.view` is given.

    Raises:
        ArgumentError: for something else, or for a Solution, a Trajectory or a configuration without its robot.
    """
    if robot is not None:
        instance("robot", robot, Robot, "a jtik.Robot, or None")
    owner: Robot | InverseKinematics | None = robot
    found: list[Subject] = []
    unused: Robot | InverseKinematics | None = None
    for each in given:
        if isinstance(each, (Robot, InverseKinematics)):
            if unused is not None:
                found.append(_of_owner(unused))
            owner = unused = each
            continue
        if owner is None:
            raise ArgumentError(
                "robot", None, f"the robot of the {type(each).__name__}, or a robot or solver before it"
            )
        found.append(_with_motion(owner, each))
        unused = None
    if unused is not None:
        found.append(_of_owner(unused))
    if not found:
        raise ArgumentError("subjects", "none", ACCEPTED)
    return _labelled(found, labels)


def _of_owner(owner: Robot | InverseKinematics) -> Subject:
    robot, ik, obstacles = _parts(owner)
    return Subject(robot.name, robot, robot.home[None], np.zeros(1), ik, obstacles)


def _with_motion(owner: Robot | InverseKinematics, given: Any) -> Subject:
    robot, ik, obstacles = _parts(owner)
    if isinstance(given, (int, float, str, bytes)) or given is None:
        raise ArgumentError("subjects", given, ACCEPTED)
    if not isinstance(given, (Solution, Trajectory)):
        given = np.asarray(robot.configuration(given, argument="subjects"))
    table = configurations_of(robot, given, "subjects")
    times = np.zeros(1)
    if isinstance(given, Trajectory):
        times = given.times if len(table) == len(given) else np.concatenate([[0.0], given.times])
    return Subject(robot.name, robot, table, times, ik, obstacles)


def _parts(owner: Robot | InverseKinematics) -> tuple[Robot, InverseKinematics | None, tuple[Any, ...]]:
    if isinstance(owner, Robot):
        return owner, None, ()
    return owner.robot, owner, obstacles_in(owner.parameters)


def _labelled(subjects: list[Subject], labels: Iterable[str] | None) -> list[Subject]:
    """The subjects with the labels given, or else with a number where several have the same name."""
    if labels is not None:
        accepted = f"{len(subjects)} names, one for each arm"
        names = list(read_names("labels", labels, accepted))
        if len(names) != len(subjects) or not all(names):
            raise ArgumentError("labels", names, accepted)
    else:
        own = [subject.label for subject in subjects]
        names = [name if own.count(name) == 1 else f"{name} {own[: k + 1].count(name)}" for k, name in enumerate(own)]
    return [replace(subject, label=name) for subject, name in zip(subjects, names, strict=True)]


class Size(NamedTuple):
    """How large what is shown is.

    Attributes:
        extent: a ball around it.
        reach: the longest reach of the robots [m].
        planar: whether all robots are planar.
    """

    extent: Extent
    reach: float
    planar: bool

    @property
    def thickness(self) -> float:
        """Radius of a link without a solid [m]."""
        return THICKNESS * self.reach


def size_of(subjects: Sequence[Subject], obstacles: Sequence[Any]) -> Size:
    """The size of subjects and obstacles."""
    longest = max(reach(subject.robot) for subject in subjects)
    points = []
    for subject in subjects:
        poses = Poses(subject.robot)
        for q in spaced(subject.q, 8):
            points += [pose[:3, 3] for pose in poses(q).values()]
    every = [*obstacles] or [each for subject in subjects for each in subject.obstacles]
    own = extent_of(np.array(points))
    for obstacle in every:
        if not isinstance(obstacle, HalfSpace):
            vertices = obstacle_surface(obstacle, own).vertices
            points += [vertices.min(axis=0), vertices.max(axis=0)]
    extent = extent_of(np.array(points))
    extent = extent._replace(radius=max(extent.radius, 0.5 * longest))
    return Size(extent, longest, all(subject.robot.dimension == 2 for subject in subjects))

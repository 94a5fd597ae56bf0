"""The joints that a solver moves: by default those on which its tasks depend; all others are locked."""

from __future__ import annotations

from collections.abc import Iterable

from jtik.arguments import names
from jtik.errors import ArgumentError
from jtik.robot import Robot
from jtik.task import Task, TaskStack


def joints_of(given: object) -> str | tuple[str, ...] | None:
    """The argument ``joints`` of a solver. Raises ArgumentError for what is neither a name nor several."""
    if given is None or isinstance(given, str):
        return given
    return names("joints", given, 'names of joints, "all", or None for those on which the tasks depend')


def reduced(
    robot: Robot, task: Task | Iterable[Task], joints: str | Iterable[str] | None, at: object
) -> tuple[Robot, TaskStack]:
    """The robot with only the chosen joints free, and the tasks on it.

    Args:
        robot: the robot.
        task: a task or several.
        joints: names of the joints to move, "all", or None for those on which the tasks depend.
        at: the configuration at which the others are locked, in any form that `Robot.configuration` accepts; neutral
            when None.

    Raises:
        ArgumentError: when the tasks depend on none of the joints.
        UnknownNameError: when there is no such joint or frame.
    """
    if robot.n == 0:
        raise ArgumentError("robot", robot, "a robot with joints that move")
    at = None if at is None else robot.configuration(at, argument="at")
    stack = TaskStack.of(robot, task)
    moving = stack.moving_joints()
    if not moving:
        raise ArgumentError("task", stack.tasks, f"a task on frames that {robot!r} can move")
    joints = joints_of(joints)
    named = (joints,) if isinstance(joints, str) else joints
    chosen = moving if named is None else robot.joint_names if joints == "all" else named
    if not set(chosen) & set(moving):
        raise ArgumentError("joints", list(chosen), f"at least one on which the tasks depend: {list(moving)}")
    if set(chosen) == set(robot.joint_names):
        return robot, stack
    part = robot.subset(chosen, at=at)
    return part, TaskStack.of(part, stack.tasks)

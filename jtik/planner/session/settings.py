"""What an operator sets: the structure that a solver is built for, and the values that change in a built one."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from jtik.constraints import Limits
from jtik.geometry import Scene, Slots
from jtik.planner.session.catalogue import Criteria
from jtik.planner.session.frames import plain
from jtik.robot import Robot
from jtik.robot.joint_weights import Weights, read_weights
from jtik.strategy import Strategy
from jtik.task import FrameTask
from jtik.types import Array


@dataclass(frozen=True, eq=False)
class Problem:
    """What stays as it is for the whole session.

    Attributes:
        robot: the robot.
        tasks: what its end effector does, or what several frames do: the first is guided at first.
        criteria: the criteria that can be chosen.
        weights: first weight of each criterion by name, 1 where there is none.
        bodies: what keeps away from obstacles, as of obstacle criteria: "both" or "shapes".
        limits: the limits, with those of the positions.
        strategy: a strategy object that can be chosen by the name "given"; None for none.
        compiled: whether solvers run as generated C.
    """

    robot: Robot
    tasks: tuple[FrameTask, ...]
    criteria: Criteria
    weights: Mapping[str, float] = field(default_factory=dict)
    bodies: str = "both"
    limits: Limits = field(default_factory=Limits)
    strategy: Strategy | None = None
    compiled: bool = False

    @property
    def task_by_name(self) -> dict[str, FrameTask]:
        """The tasks by their names."""
        return {task.name: task for task in self.tasks}

    def guided_frame(self, name: str) -> str:
        """The frame of a task."""
        return self.robot.frame(self.task_by_name[name].frame)


@dataclass(frozen=True, eq=False)
class Structure:
    """What a solver is built for.

    Attributes:
        strategy: name of the strategy.
        options: options of the strategy.
        criteria: names of the criteria.
        limits: whether the position limits hold.
        clearance: whether the clearance holds.
        slots: the places for obstacles.
        joint_weights: weights of the velocity entries (n,), as `jtik.InverseKinematics` takes them.
    """

    strategy: str
    options: Mapping[str, Any]
    criteria: tuple[str, ...]
    limits: bool
    clearance: bool
    slots: Slots
    joint_weights: tuple[float, ...]

    @property
    def key(self) -> str:
        """A text that is the same for structures of the same solver."""
        options = {name: plain(value) for name, value in sorted(self.options.items())}
        parts = [
            self.strategy,
            options,
            self.criteria,
            self.limits,
            self.clearance,
            dict(self.slots.counts),
            self.slots.corners,
            self.joint_weights,
        ]
        return json.dumps(parts)


def joint_weights(robot: Robot, given: Weights) -> tuple[float, ...]:
    """The weights of the velocity entries (n,); 1 each where none are given.

    Raises:
        ArgumentError: for weights that cannot be used.
        UnknownNameError: for a joint that does not exist.
    """
    found = read_weights(robot, given)
    return (1.0,) * robot.n if found is None else tuple(found.tolist())


@dataclass(frozen=True, eq=False)
class Values:
    """What changes in a built solver.

    Attributes:
        scene: the obstacles.
        preferred: preferred posture (nq,) [rad] and [m].
        gains: values of other live parameters by name.
        safe: smallest distance that the clearance allows [m].
    """

    scene: Scene
    preferred: Array
    gains: Mapping[str, Any]
    safe: float

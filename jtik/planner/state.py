"""The state of a session, which belongs to the thread of the loop."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from jtik.errors import JtikError
from jtik.geometry import Scene
from jtik.planner import rotations
from jtik.planner.arm import Arm
from jtik.planner.frames import Level, Message
from jtik.planner.settings import Problem, Structure, Values
from jtik.planner.solving import Solver
from jtik.planner.target import GuidedTarget
from jtik.types import Array

MESSAGES = 200
"""Number of messages that are kept."""

AGAIN = 5.0
"""Time after which a message of the same text is told again [s]."""


class Messages:
    """The latest messages, each text at most once in some seconds.

    Args:
        clock: the time [s].

    Attributes:
        latest: the latest messages, which any thread may read.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._told: dict[str, float] = {}
        self._count = 0
        self.latest: deque[Message] = deque(maxlen=MESSAGES)

    def tell(self, level: Level, text: str) -> None:
        """Add a message."""
        now = self._clock()
        if now - self._told.get(text, -AGAIN) < AGAIN:
            return
        if len(self._told) > MESSAGES:
            self._told.clear()
        self._told[text] = now
        self.latest.append(Message(self._count, level, " ".join(text.split())))
        self._count += 1


class State:
    """Where the arm and its target are, what is set, and the solver.

    Args:
        problem: what stays as it is.
        solver: the first solver.
        values: what changes in a built solver.
        q: where the arm is (nq,).
        target_speed: largest speed [m/s] and angular speed [rad/s] of the target.
        tell: takes a message.

    Attributes:
        q: where the arm is (nq,).
        target: the target.
        solver: the solver that steps.
        wanted: the structure that was asked for last.
        values: what changes in a built solver.
        jog: speed and direction along the self-motion.
    """

    def __init__(
        self,
        problem: Problem,
        solver: Solver,
        values: Values,
        q: Array,
        *,
        target_speed: tuple[float, float],
        messages: Messages,
    ) -> None:
        self.problem, self.solver, self.values, self.messages = problem, solver, values, messages
        self.wanted: Structure = solver.structure
        self.arm = Arm(solver.ik.robot, solver.ik.robot.frame(problem.task.frame))
        self.q = np.array(q, dtype=float)
        position, orientation = self.arm.end_effector(self.q)
        speed, rotation_speed = target_speed
        self.target = GuidedTarget(
            position,
            orientation,
            speed=speed,
            rotation_speed=rotation_speed,
            turns=problem.task.target_kind != "position",
        )
        self.jog: tuple[float, tuple[float, ...] | None] = (0.0, None)
        self.changes = 0
        solver.fill(values)

    def task_target(self) -> Any:
        """The target as the task reads it."""
        task, target = self.problem.task, self.target
        kind = task.target_kind
        if kind == "position":
            return target.position
        if self.arm.robot.dimension == 2:
            angle = 2 * np.arctan2(target.orientation[3], target.orientation[0])
            return np.array([angle] if kind == "orientation" else [*target.position, angle])
        if kind == "orientation":
            return rotations.matrix(target.orientation)
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = rotations.matrix(target.orientation), target.position
        return pose

    def step(self, dt: float) -> bool:
        """One step of the arm; whether it has moved. A step that fails leaves the arm where it is, and is told."""
        try:
            found = self.solver.step(self.q, self.task_target(), dt)
        except JtikError as error:
            self.messages.tell("error", f"the step failed: {error}")
            return False
        except Exception as error:  # a criterion or a strategy of a third party may raise anything
            self.messages.tell("error", f"the step failed: {type(error).__name__}: {error}")
            return False
        if not np.isfinite(found.q).all():
            self.messages.tell("error", "the step led to no finite configuration; the arm stays where it is")
            self.solver.ik.reset()
            return False
        moved = bool((found.q != self.q).any())
        self.q = found.q
        return moved

    def take(self, solver: Solver) -> None:
        """Go on with another solver, from where the arm is."""
        self.solver = solver
        solver.ik.reset()
        solver.fill(self.values)
        self.touch()

    def touch(self) -> None:
        """Note that the settings have changed."""
        self.changes += 1

    def set_values(self, **changes: Any) -> None:
        """Change values of the solver."""
        self.values = replace(self.values, **changes)
        self.solver.fill(self.values)
        self.touch()

    def set_scene(self, scene: Scene) -> None:
        """Change the obstacles; those without a place in the present solver are left out until there is another."""
        self.values = replace(self.values, scene=scene)
        self.solver.fill_scene(self.values)
        self.touch()

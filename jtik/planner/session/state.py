"""The state of a session, which belongs to the thread of the loop."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from jtik.errors import JtikError, UnknownNameError
from jtik.geometry import Scene
from jtik.planner.edits.messages import Jog
from jtik.planner.session.arm import Arm
from jtik.planner.session.frames import Level, Message
from jtik.planner.session.settings import Problem, Structure, Values
from jtik.planner.session.solving import Solver
from jtik.planner.session.target import GuidedTarget
from jtik.planner.session.targets import Pose, Targets, target_of
from jtik.task import FrameTask
from jtik.types import Array

MESSAGES = 200
"""Number of messages that are kept."""

AGAIN = 5.0
"""Time after which a message of the same text is shown again [s]."""


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


class Motion(NamedTuple):
    """The last motion of the arm.

    Attributes:
        before: where it began (nq,).
        after: where it ended (nq,).
        dt: its time [s].
    """

    before: Array
    after: Array
    dt: float


class State:
    """Where the arm and its target are, what is set, and the solver.

    Args:
        problem: what stays as it is.
        solver: the first solver.
        values: what changes in a built solver.
        q: where the arm is (nq,).
        messages: takes messages for the operator.

    Attributes:
        q: where the arm is (nq,).
        target: the target that the operator guides.
        targets: which task that is, and the targets of the others.
        solver: the solver that steps.
        wanted: the structure that was asked for last.
        values: what changes in a built solver.
        jog: motion along the self-motion.
        jogged: what that motion does, in words; empty without one.
        changes: how often the settings have changed.
    """

    def __init__(self, problem: Problem, solver: Solver, values: Values, q: Array, *, messages: Messages) -> None:
        self.problem, self.solver, self.values, self.messages = problem, solver, values, messages
        self.wanted: Structure = solver.structure
        first = problem.tasks[0]
        self.arm = Arm(problem.robot, problem.robot.frame(first.frame))
        self.q = np.array(q, dtype=float)
        here = {task.name: Pose(*self.arm.pose(self.q, problem.robot.frame(task.frame))) for task in problem.tasks}
        self.target = GuidedTarget(*here.pop(first.name), speed=1.0, rotation_speed=1.0, turns=_turns(first))
        self.targets = Targets(first.name, here)
        self.jog = Jog(0.0)
        self.jogged = ""
        self.changes = 0
        self._motion: Motion | None = None
        solver.fill(values)

    def set_target_speed(self, speed: float, rotation: float) -> None:
        """Set the largest speed [m/s] and angular speed [rad/s] of the target."""
        self.target.speed, self.target.rotation_speed = speed, rotation
        self.touch()

    def guide(self, name: str) -> None:
        """Guide another task; the one before is held where its target is. Raises UnknownNameError for another name."""
        if name not in self.problem.task_by_name:
            raise UnknownNameError("task", name, self.problem.task_by_name)
        if name != self.targets.guided:
            there = self.targets.held[name]
            self.take_targets(self.targets.with_guided(name, Pose(self.target.position, self.target.orientation)))
            self.target.put(*there)

    def take_targets(self, targets: Targets) -> None:
        """Take other held targets, and another task as the guided one."""
        self.targets = targets
        self.target.turns = _turns(self.problem.task_by_name[targets.guided])
        self.touch()

    def step(self, dt: float, *, guided: bool) -> None:
        """One step of the arm. A step that fails leaves the arm where it is, and is reported.

        Args:
            dt: period [s].
            guided: whether the target moves, which comes before a motion along the self-motion.
        """
        self.jogged = ""
        self._motion = None
        try:
            q = self._jog(dt) if self.jog.rate and not guided else self._follow(dt)
        except JtikError as error:
            self.messages.tell("error", f"the step failed: {error}")
            return
        except Exception as error:  # a criterion or a strategy of a third party may raise anything
            self.messages.tell("error", f"the step failed: {type(error).__name__}: {error}")
            return
        if np.isfinite(q).all():
            self._motion = Motion(self.q, q, dt)
            self.q = q
            return
        self.messages.tell("error", "the step led to no finite configuration; the arm stays where it is")
        self.solver.ik.reset()

    def _follow(self, dt: float) -> Array:
        """The configuration after one step to the target."""
        target = target_of(self.problem, self.targets, self.target.position, self.target.orientation)
        return self.solver.step(self.q, target, dt).q

    def _jog(self, dt: float) -> Array:
        """The configuration after one displacement along the self-motion."""
        found = self.solver.ik.jog(self.q, self.jog.rate, direction=self.jog.direction, dt=dt)
        self.jogged = found.reason
        return found.q

    def take(self, solver: Solver) -> None:
        """Go on with another solver, from where the arm is and as fast as it moves."""
        self.solver = solver
        solver.ik.reset(velocity=self._velocity())
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

    def _velocity(self) -> Array | None:
        """Velocity of the joints in the last step (n,) [rad/s] or [m/s]; None for rest."""
        if self._motion is None:
            return None
        velocity: Array = self.arm.robot.difference(self._motion.before, self._motion.after) / self._motion.dt
        return velocity

    def put(self, q: Array, position: Array, orientation: Array | None, *, motion: Motion | None = None) -> None:
        """Put the arm and the target somewhere at once; the target is at rest.

        Args:
            q: where the arm is then (nq,).
            position: position of the target [m].
            orientation: orientation of the target, a unit quaternion; None leaves it as it is.
            motion: its last motion, which it goes on from; None for an arm at rest.
        """
        self._motion = motion
        self.q = np.array(q, dtype=float)
        self.target.put(position, self.target.orientation if orientation is None else orientation)
        self.jog = Jog(0.0)
        self.solver.ik.reset(velocity=self._velocity())


def _turns(task: FrameTask) -> bool:
    """Whether the orientation of its target counts."""
    return task.target_kind != "position"

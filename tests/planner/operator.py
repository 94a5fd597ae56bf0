"""An operator in tests: a loop with a clock of its own, whose solvers are built when the test says so."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor, Future
from functools import cache
from typing import Any

import numpy as np

import jtik
from jtik.planner.edits.messages import Edit
from jtik.planner.session.catalogue import Criteria
from jtik.planner.session.loop import DT, Loop
from jtik.planner.session.settings import Problem, Structure, Values
from jtik.planner.session.solving import Solver
from jtik.planner.session.state import Messages, State

ROBOT = jtik.Robot.planar(4)
START = np.array([0.9, -0.6, -0.5, 0.4])
SCENE = jtik.Scene({"post": jtik.Circle((2.0, 2.4), 0.3)})
SLOTS = {"ball": 2}


class Later(Executor):
    """Runs nothing by itself; with ``at_once`` what is submitted is done at once."""

    def __init__(self, *, at_once: bool = True) -> None:
        self.at_once = at_once
        self.waiting: deque[Callable[[], None]] = deque()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()

        def work() -> None:
            try:
                future.set_result(fn(*args, **kwargs))
            except BaseException as error:
                future.set_exception(error)

        self.waiting.append(work)
        if self.at_once:
            self.finish()
        return future

    def finish(self) -> None:
        """Do everything that waits."""
        while self.waiting:
            self.waiting.popleft()()


@cache
def problem(task: str = "position", speed: float = 2.0) -> Problem:
    return Problem(
        robot=ROBOT,
        tasks=(jtik.FrameTask("tip", kind=task),),
        criteria=Criteria(),
        limits=jtik.Limits(velocity=speed),
    )


@cache
def first_solver(task: str = "position") -> Solver:
    slots = jtik.geometry.Slots(SLOTS, 2)
    return Solver(problem(task), Structure("newton", {}, ("joint_centering",), True, False, slots, (1.0,) * ROBOT.n))


class Operator:
    """A loop of a planar arm with four links, with the hand of an operator on it."""

    def __init__(self, *, at_once: bool = True, task: str = "position", **options: Any) -> None:
        self.now, self.executor = 0.0, Later(at_once=at_once)
        solver, messages = first_solver(task), Messages(lambda: self.now)
        solver.ik.reset()
        for name in ("joint_centering.weight", "joint_centering.stiffness"):
            solver.ik.parameters[name] = 1.0
        self.state = State(problem(task), solver, Values(SCENE, np.zeros(4), {}, 0.05), START, messages=messages)
        self.state.set_target_speed(1.0, 1.0)
        self.loop = Loop(self.state, self.executor, clock=lambda: self.now, **options)

    def go(self, seconds: float = DT) -> Operator:
        """Let some time pass."""
        for _ in range(max(1, round(seconds / DT))):
            self.now += DT
            self.loop.tick(self.now)
        return self

    def does(self, *edits: Edit, seconds: float = 0.2) -> Operator:
        """Ask for edits, and let some time pass."""
        for edit in edits:
            assert self.loop.submit(edit)
        return self.go(seconds)

    @property
    def told(self) -> list[str]:
        """The messages so far."""
        return [message.text for message in self.loop.messages]

    @property
    def tip(self) -> np.ndarray:
        """Where the end effector is, by the robot's own kinematics."""
        return ROBOT.position(self.loop.frame.q)

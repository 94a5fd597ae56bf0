"""The loop of the planner: the one thread that owns the solver, takes edits and publishes what any thread may read."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable

import numpy as np

from jtik.errors import JtikError
from jtik.planner import catalogue, measure
from jtik.planner.editing import Editor
from jtik.planner.edits import Edit
from jtik.planner.frames import Frame, Message, Settings, Setup, StatusLine
from jtik.planner.inbox import Inbox
from jtik.planner.schedule import Schedule
from jtik.planner.solving import Workshop
from jtik.planner.state import State

DT = 1 / 60
"""Period of the loop [s]."""

STATUS_PERIOD = 0.1
"""Time from one line of status to the next [s]."""

STILL = 1e-9
"""Motion of a joint in a period up to which the arm is at rest [rad] or [m]."""


class Loop:
    """Moves the target and the arm, one period after the other.

    Args:
        state: the state, which nobody else uses any more.
        workshop: builds solvers.
        clock: the time [s].
        dt: period [s].

    Attributes:
        setup: what the planner plans for.
        settings: what it is set to.
        frame: the arm.
        status: the state in words and figures.
    """

    def __init__(
        self, state: State, workshop: Workshop, *, clock: Callable[[], float] = time.monotonic, dt: float = DT
    ) -> None:
        self._state, self._workshop, self._clock, self._dt = state, workshop, clock, dt
        self._editor = Editor(state, workshop)
        self._inbox = Inbox()
        self._schedule = Schedule(dt, clock())
        self._tick, self._measured, self._published = 0, -np.inf, -1
        self._moved, self._guided, self._step_time = False, False, 0.0
        self._closed = threading.Event()
        self._thread: threading.Thread | None = None
        robot, task = state.arm.robot, state.problem.task
        self.setup = Setup(
            robot=state.arm.description(),
            frames=robot.frame_names,
            strategies=catalogue.strategy_entries(),
            criteria=state.problem.criteria.entries(),
            task={"kind": task.kind, "frame": state.arm.tip},
            dt=dt,
        )
        self.settings: Settings = self._settings()
        self.frame: Frame = self._frame(clock())
        self.status = StatusLine(words="starts")
        self._measure(clock())

    @property
    def messages(self) -> deque[Message]:
        """The latest messages."""
        return self._state.messages.latest

    def submit(self, edit: Edit) -> bool:
        """Ask for an edit, from any thread; it is applied in the next period. False where too many wait."""
        return self._inbox.put(edit)

    def tick(self, now: float) -> None:
        """One period: apply the edits, move the target and the arm, publish.

        Args:
            now: the time [s].
        """
        self._tick += 1
        edits, refused = self._inbox.take()
        if refused:
            self._state.messages.tell("warning", f"{refused} edits were left out: too many at once")
        for edit in edits:
            self._apply(edit)
        self._editor.swap()
        self._live()
        if self._moved or self._guided or edits:
            self.frame = self._frame(now)
        if now - self._measured >= STATUS_PERIOD - self._dt / 2:
            self._measure(now)

    def _apply(self, edit: Edit) -> None:
        try:
            self._editor.apply(edit)
        except JtikError as error:
            self._state.messages.tell("error", f"{edit.kind}: {error}")

    def _live(self) -> None:
        state = self._state
        self._guided = state.target.advance(self._dt)
        before = state.q
        start = time.perf_counter()
        state.step(self._dt)
        self._step_time = time.perf_counter() - start
        self._moved = state.q is not before and bool(np.abs(state.q - before).max(initial=0.0) > STILL)

    def _frame(self, now: float) -> Frame:
        state = self._state
        q = state.q.copy()
        q.flags.writeable = False
        return Frame(
            tick=self._tick,
            time=now,
            q=q,
            position=state.target.position.copy(),
            orientation=state.target.orientation.copy(),
            poses=state.arm.poses(q),
        )

    def _measure(self, now: float) -> None:
        """Publish the status, and the settings where they have changed."""
        self._measured, state = now, self._state
        if state.changes != self._published:
            self.settings = self._settings()
        report = state.solver.ik.report(state.q, state.task_target())
        distances = state.solver.gauge.distances(state.q)
        safe = state.values.safe if state.solver.structure.clearance else 0.0
        self.status = StatusLine(
            words=measure.words(report, moving=self._moved, guided=self._guided),
            heartbeat=self.status.heartbeat + 1 if hasattr(self, "status") else 0,
            clearance=state.solver.gauge.clearance(distances),
            violated=state.solver.gauge.nearer(distances, safe),
            step_time=self._step_time,
            rebuilding=self._workshop.busy,
            late=self._schedule.late,
            **measure.figures(report),
        )

    def _settings(self) -> Settings:
        state = self._state
        self._published, wanted = state.changes, state.wanted
        return Settings(
            version=state.changes,
            strategy={"name": wanted.strategy, "options": dict(wanted.options)},
            criteria=wanted.criteria,
            scene=state.values.scene.to_dict()["obstacles"],
            preferred=tuple(state.values.preferred.tolist()),
            gains={name: value.tolist() for name, value in state.solver.gains.items()},
            limits=wanted.limits,
            clearance=wanted.clearance,
            safe=state.values.safe,
            target_speed=(state.target.speed, state.target.rotation_speed),
            capacity=dict(state.solver.structure.slots.counts),
            rebuilding=self._workshop.busy,
        )

    def start(self) -> None:
        """Run in a thread of its own until `close`."""
        self._thread = threading.Thread(target=self.run, name="jtik planner", daemon=True)
        self._thread.start()

    def run(self) -> None:
        """Run until `close`. Whatever goes wrong in a period is told, and the next one follows."""
        while not self._closed.wait(self._schedule.wait(self._clock())):
            now = self._clock()
            try:
                self.tick(now)
            except Exception as error:
                self._state.messages.tell("error", f"a period failed: {type(error).__name__}: {error}")
            self._schedule.done(self._clock())

    def close(self) -> None:
        """End the loop."""
        self._closed.set()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join()

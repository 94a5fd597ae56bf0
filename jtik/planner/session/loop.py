"""The loop of the planner: the one thread that owns the solver, takes edits and publishes what any thread may read."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor

import numpy as np

from jtik.errors import ArgumentError, JtikError
from jtik.planner.attempts.history import History
from jtik.planner.attempts.of_session import Attempts
from jtik.planner.edits import messages as edits
from jtik.planner.edits.effects import Editor
from jtik.planner.files.journal import Journal
from jtik.planner.files.plan_file import Plan
from jtik.planner.files.sessions import Session
from jtik.planner.session import measure
from jtik.planner.session.arm import Arm
from jtik.planner.session.background import Background
from jtik.planner.session.frames import Frame, Message, Settings, Setup, StatusLine
from jtik.planner.session.inbox import Inbox
from jtik.planner.session.publishing import settings_of, setup_of
from jtik.planner.session.schedule import Schedule
from jtik.planner.session.solving import Workshop
from jtik.planner.session.state import State
from jtik.planner.session.targets import target_of

DT = 1 / 60
"""Period of the loop [s]."""

STATUS_PERIOD = 0.1
"""Time from one line of status to the next [s]."""

SNAPSHOT_PERIOD = 2.0
"""Shortest time between two snapshots of changed settings [s]; as many times longer as the attempts are larger."""

LARGE = 20_000
"""Number of samples of all attempts from which on snapshots are made less often."""

STILL = 1e-9
"""Motion of a joint in a period up to which the arm is where it was [rad] or [m]."""

LIVE_ONLY = (
    edits.MoveTarget,
    edits.HoldTarget,
    edits.Guide,
    edits.Jog,
    edits.AddObstacle,
    edits.ChangeObstacle,
    edits.DeleteObstacle,
    edits.SetObstacleGain,
    edits.TakePosture,
)
"""Edits that need an arm that follows the target."""


class Loop:
    """Moves the target and the arm, one period after the other.

    Args:
        state: the state, which nobody else uses any more.
        executor: where solvers are built, and whatever else takes long is done.
        clock: the time [s].
        dt: period [s].
        journal: where what is recorded is kept; None for nowhere.
        sessions: former sessions that can be recovered.

    Attributes:
        setup: what the planner plans for.
        settings: what it is set to.
        frame: the arm.
        status: the state in words and figures.
    """

    def __init__(
        self,
        state: State,
        executor: Executor,
        *,
        clock: Callable[[], float] = time.monotonic,
        dt: float = DT,
        journal: Journal | None = None,
        sessions: tuple[Session, ...] = (),
    ) -> None:
        self._state, self._clock, self._dt, self._journal = state, clock, dt, journal
        self._workshop = Workshop(state.problem, executor)
        self._workshop.keep(state.solver)
        self._editor = Editor(state, self._workshop)
        self._attempts = Attempts(state, self._editor, dt=dt, journal=journal)
        self._background = Background(state, self._attempts, self._editor, executor, sessions)
        self._inbox = Inbox()
        self._schedule = Schedule(dt, clock())
        self._tick, self._measured, self._saved = 0, clock(), (clock(), state.changes)
        self._moved, self._guided, self._step_time = False, False, 0.0
        self._shown_scene: object = None
        self._listeners: tuple[Callable[[], None], ...] = ()
        self._closed = threading.Event()
        self._thread: threading.Thread | None = None
        self.setup: Setup = setup_of(state, dt)
        self.settings: Settings = settings_of(state, None, rebuilding=False)
        self.frame: Frame = self._frame(clock())
        self.status: StatusLine = self._line(0)

    @property
    def messages(self) -> deque[Message]:
        """The latest messages."""
        return self._state.messages.latest

    @property
    def history(self) -> History:
        """The attempts; `StatusLine.attempts` grows when there are others."""
        return self._attempts.history

    @property
    def sessions(self) -> tuple[Session, ...]:
        """Former sessions that can be recovered."""
        return self._background.sessions

    @property
    def arm(self) -> Arm:
        """The robot as it is shown. Its compiled function is the loop's."""
        return self._state.arm

    def plan(self) -> Plan:
        """The whole plan as it is, from any thread."""
        return self._attempts.plan()

    def submit(self, edit: edits.Edit) -> bool:
        """Ask for an edit, from any thread; it is applied in the next period. False where too many wait."""
        return self._inbox.put(edit)

    def listen(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Have a function called, in the thread of the loop, when something is published.

        Args:
            listener: the function, which returns at once and raises nothing.

        Returns:
            A function that ends this.
        """
        self._listeners += (listener,)

        def end() -> None:
            self._listeners = tuple(each for each in self._listeners if each is not listener)

        return end

    def tick(self, now: float) -> None:
        """One period: apply the edits, move the target and the arm, publish.

        Args:
            now: the time [s].
        """
        self._tick += 1
        waiting, refused = self._inbox.take()
        if refused:
            self._state.messages.tell("warning", f"{refused} edits were left out: too many at once")
        for edit in waiting:
            self._apply(edit)
        self._editor.swap()
        self._background.poll()
        if self._attempts.mode == "live":
            self._follow()
            self._attempts.note(self._tick * self._dt)
            changed = self._moved or self._guided or bool(waiting)
        else:
            self._moved = self._guided = False
            changed = self._attempts.advance() or bool(waiting)
        if changed:
            self.frame = self._frame(now)
        due = now - self._measured >= STATUS_PERIOD - self._dt / 2
        if due:
            self._publish(now)
        if changed or due:
            for listener in self._listeners:
                listener()

    def _apply(self, edit: edits.Edit) -> None:
        try:
            if self._attempts.mode != "live" and isinstance(edit, LIVE_ONLY):
                if _is_stop(edit):
                    return
                raise ArgumentError(edit.kind, "while an attempt is shown", "go back to the live arm, undo or branch")
            for part in (self._editor, self._attempts, self._background):
                if part.handles(edit):
                    part.apply(edit)
                    return
            raise ArgumentError("edit", edit.kind, "an edit of the planner")
        except JtikError as error:
            self._state.messages.tell("error", f"{edit.kind}: {str(error).removeprefix(f'{edit.kind}: ')}")
        except Exception as error:  # what a class of a third party raises
            self._state.messages.tell("error", f"{edit.kind}: {type(error).__name__}: {error}")

    def _follow(self) -> None:
        """Move the target and the arm."""
        state = self._state
        self._guided = state.target.advance(self._dt)
        before, start = state.q, time.perf_counter()
        state.step(self._dt, guided=self._guided)
        self._step_time = time.perf_counter() - start
        self._moved = state.q is not before and bool(np.abs(state.q - before).max(initial=0.0) > STILL)

    def _frame(self, now: float) -> Frame:
        state, shown = self._state, self._attempts.shown
        q, position, orientation = state.q, state.target.position, state.target.orientation
        if shown is not None:
            q, position, recorded = self._attempts.sample()
            orientation = orientation if recorded is None else recorded
        arrays = [np.array(each) for each in (q, position, orientation)]
        for each in arrays:
            each.flags.writeable = False
        return Frame(
            tick=self._tick,
            time=now,
            q=arrays[0],
            position=arrays[1],
            orientation=arrays[2],
            poses=state.arm.poses(q),
            mode=self._attempts.mode,
            recording=self._attempts.recording,
            shown=shown,
        )

    def _publish(self, now: float) -> None:
        """Publish the status, and the settings where they have changed; have the journal keep what has changed."""
        self._measured, state = now, self._state
        scene = self._attempts.scene()
        if scene != self._shown_scene:
            self._shown_scene = scene
            state.touch()
        if state.changes != self.settings.version or self._workshop.busy != self.settings.rebuilding:
            self.settings = settings_of(state, scene, rebuilding=self._workshop.busy)
        self.status = self._line(self.status.heartbeat + 1)
        samples = sum(map(len, self._attempts.history))
        last, version = self._saved
        if version != state.changes and now - last >= SNAPSHOT_PERIOD * (1 + samples // LARGE):
            self._saved = now, state.changes
            self._attempts.snapshot()

    def _line(self, heartbeat: int) -> StatusLine:
        state, frame = self._state, self.frame
        solver, q = state.solver, frame.q
        report = solver.ik.report(
            q, target_of(state.problem, self._attempts.targets, frame.position, frame.orientation)
        )
        distances = solver.gauge.distances(q)
        safe = state.values.safe if solver.structure.clearance else 0.0
        said = state.jogged and f"along the self-motion: {state.jogged}"
        if frame.shown is not None:
            said = f"shows {frame.shown[0]!r}"
        said = said or measure.words(report, moving=self._moved, guided=self._guided)
        return StatusLine(
            words=said,
            heartbeat=heartbeat,
            clearance=solver.gauge.clearance(distances),
            violated=solver.gauge.nearer(distances, safe),
            step_time=self._step_time,
            rebuilding=self._workshop.busy,
            attempts=self._attempts.version,
            late=self._schedule.late,
            **measure.figures(report),
        )

    def start(self) -> None:
        """Run in a thread of its own until `close`."""
        if self._thread is None:
            if self._journal is not None:
                self._journal.start()
            self._thread = threading.Thread(target=self.run, name="jtik planner", daemon=True)
            self._thread.start()

    def run(self) -> None:
        """Run until `close`. An error in a period is reported, and the next one follows."""
        while not self._ends():
            try:
                self.tick(self._clock())
            except Exception as error:
                self._state.messages.tell("error", f"a period failed: {type(error).__name__}: {error}")
            self._schedule.done(self._clock())

    def _ends(self) -> bool:
        """Wait until the next period begins. Returns whether the loop ends instead."""
        if self._inbox.filled.wait(self._schedule.wait(self._clock())):
            return self._closed.wait(self._schedule.asked(self._clock()))
        return self._closed.is_set()

    def close(self) -> None:
        """End the loop; what is recorded is kept."""
        self._closed.set()
        self._inbox.filled.set()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join()
        self._attempts.stop()
        if self._journal is not None:
            self._journal.close(self._attempts.plan())


def _is_stop(edit: edits.Edit) -> bool:
    """Whether an edit releases a key or a stick."""
    if isinstance(edit, edits.Jog):
        return edit.rate == 0
    return isinstance(edit, edits.HoldTarget) and not any((*edit.velocity, *(edit.rotation or ())))

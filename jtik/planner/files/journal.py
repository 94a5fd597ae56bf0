"""The journal of a session: what is recorded, on disk within a second.

A session has a folder with two files. ``journal.jsonl`` only grows: one JSON object a line, in the order in which
things happened. ``plan.json`` is a snapshot of the whole plan (`jtik.planner.files.plan_file`), replaced atomically;
its key ``journal`` is the number of the line ``snapshot`` up to which it includes everything.
`jtik.planner.files.recovery` reads both. The lines are objects with one of these keys:

- ``journal``: "jtik plan", with ``version`` and ``robot``: the first line.
- ``begin``: the beginning of an attempt, as `Attempt.to_json` gives it; that of a branch without its samples, which are
  those of its parent.
- ``sample``: a list of the clock's time [s], the configuration and the target.
- ``scene``: the obstacles from the last sample on.
- ``end``: whether the attempt that began last is kept.
- ``edit``: an edit of the operator, with its ``time`` [s].
- ``snapshot``: the number of a snapshot of the plan as it is here.
- ``closed``: the session has ended, and all of it is in ``plan.json``.
"""

from __future__ import annotations

import json
import os
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from jtik.planner.attempts.attempt import Attempt
from jtik.planner.files.plan_file import FORMAT, VERSION, Plan
from jtik.planner.files.snapshots import Snapshots
from jtik.types import Array

JOURNAL = "journal.jsonl"
SNAPSHOT = "plan.json"

PERIOD = 0.9
"""Time from one write to the next [s]: together with the write itself it stays below a second."""

PAUSE = 5e-4
"""Pause between two pieces of a snapshot [s]."""

MOST_WAITING = 400_000
"""Largest number of lines that wait for a disk on which nothing can be written, almost two hours of samples."""

Tell = Callable[[str, str], None]
"""What the journal reports to: called with "info" or "error", and a sentence."""


class Journal:
    """The journal of a session. Its methods only take notes; `write` puts them on the disk, or threads after `start`.

    A disk that is full, a folder that is read-only and the like are reported once and never raise: what cannot be
    written waits in memory, and is written as soon as that is possible. One thread writes the lines, which a process
    that is killed cannot lose any more; another one does what may take long: it has the system put them onto the disk
    itself, and writes snapshots.

    Args:
        folder: the folder of the session, which is made where it does not exist.
        robot: the robot, of `Plan.robot_of`.
        tell: called with what goes wrong, perhaps from another thread.

    Attributes:
        folder: the folder.
    """

    def __init__(self, folder: Path, *, robot: Mapping[str, Any], tell: Tell | None = None) -> None:
        self.folder = folder
        self._tell: Tell = _say_nothing if tell is None else tell
        self._notes: deque[Mapping[str, Any] | tuple[Plan, int]] = deque()
        self._pending: list[bytes] = []
        self._unsaved: tuple[Plan, int] | None = None
        self._snapshots, self._saved = 0, Snapshots(folder / SNAPSHOT, self._pause)
        self._problems: dict[str, str] = {}
        self._file: int | None = None
        self._torn, self._dirty, self._used, self._lost = False, False, False, 0
        self._writing, self._saving = threading.Lock(), threading.Lock()
        self._stop = threading.Event()
        self._threads: list[threading.Thread] = []
        self._note({"journal": FORMAT, "version": VERSION, "robot": dict(robot)})

    @property
    def problem(self) -> str:
        """Why something cannot be written; empty while it can."""
        return next(iter(self._problems.values()), "")

    def begin(self, beginning: Attempt) -> None:
        """An attempt begins, see `Recording`."""
        branch = beginning.parent is not None and beginning.branched_at is not None
        data = beginning.cut(0.0).to_json() if branch else beginning.to_json()
        if branch:
            data |= {"times": [], "configurations": [], "targets": [], "scenes": []}
        self._used = True
        self._note({"begin": data})

    def sample(self, at: float, q: Array, target: Array) -> None:
        """A sample of the attempt that began last at a time of the clock [s], see `Recording.add`."""
        self._note({"sample": [float(at), np.asarray(q).tolist(), np.asarray(target).tolist()]})

    def scene(self, scene: Mapping[str, Any]) -> None:
        """The obstacles are others from the last sample on, see `Recording.change_scene`."""
        self._note({"scene": scene})

    def end(self, *, kept: bool = True) -> None:
        """The attempt that began last ends, and is kept or not."""
        self._note({"end": kept})

    def edit(self, at: float, edit: Mapping[str, Any]) -> None:
        """An edit of the operator at a time of the clock [s], as plain data."""
        self._used = True
        self._note({"edit": edit, "time": float(at)})

    def snapshot(self, plan: Plan) -> None:
        """The whole plan as it is after all that was noted so far; the latest one is written."""
        self._snapshots += 1
        self._note({"snapshot": self._snapshots})
        self._note((plan, self._snapshots))

    def start(self) -> None:
        """Write every second in threads of its own, until `close`."""
        for work in (self.write_lines, self.save) if not self._threads else ():
            thread = threading.Thread(target=self._repeat, args=(work,), name="jtik journal", daemon=True)
            self._threads.append(thread)
            thread.start()

    def close(self, plan: Plan | None = None) -> None:
        """Write what is noted, and end the session.

        Args:
            plan: the whole plan at the end; None leaves the session as one that was not ended. A session without an
                attempt and without an edit leaves nothing behind.
        """
        if plan is not None:
            self.snapshot(plan)
        self._stop.set()
        for thread in self._threads:
            thread.join()
        ended = self.write() and plan is not None
        if ended:
            self._note({"closed": True})
            self.write()
        with self._writing:
            if self._file is not None:
                os.close(self._file)
                self._file = None
        if ended and plan is not None and not self._used and not len(plan.history):
            with suppress(OSError):
                for name in (JOURNAL, SNAPSHOT):
                    (self.folder / name).unlink(missing_ok=True)
                self.folder.rmdir()

    def write(self) -> bool:
        """Write all that was noted, onto the disk itself. Returns whether it is there."""
        lines, rest = self.write_lines(), self.save()
        return lines and rest

    def write_lines(self) -> bool:
        """Write the lines that were noted: a process that is killed does not lose them. Returns whether that is so."""
        with self._writing:
            self._take_notes()
            return self._try("lines", self._write_lines)

    def save(self) -> bool:
        """Have the system put the lines onto the disk itself, and write the latest snapshot."""
        with self._saving:
            return self._try("snapshot", self._save)

    def _note(self, note: Mapping[str, Any] | tuple[Plan, int]) -> None:
        if len(self._notes) + len(self._pending) < MOST_WAITING or isinstance(note, tuple):
            self._notes.append(note)
            return
        self._lost += 1
        if self._lost == 1:
            self._tell("error", f"the journal cannot keep more than {MOST_WAITING} lines in memory: save the plan")

    def _take_notes(self) -> None:
        """Turn the notes into lines, and find the latest snapshot."""
        for _ in range(len(self._notes)):
            note = self._notes.popleft()
            if isinstance(note, tuple):
                self._unsaved = note
                continue
            try:
                self._pending.append((json.dumps(note, allow_nan=False) + "\n").encode())
            except (TypeError, ValueError, RecursionError) as error:
                self._tell("error", f"a line of the journal is left out: {error}")

    def _write_lines(self) -> None:
        if not self._pending:
            return
        if self._file is None:
            self._file = _opened(self.folder)
        if self._torn:  # the last write ended in the middle of a line, which recovery leaves out
            os.write(self._file, b"\n")
            self._torn = False
        data = memoryview(b"".join(self._pending))
        left = data
        try:
            while left:
                left = left[os.write(self._file, left) :]
        finally:
            self._written(len(data) - len(left))

    def _written(self, size: int) -> None:
        """Forget the lines that are written whole; what is left of the last one is torn."""
        count = 0
        while count < len(self._pending) and len(self._pending[count]) <= size:
            size -= len(self._pending[count])
            count += 1
        del self._pending[:count]
        self._torn, self._dirty = size > 0, True

    def _save(self) -> None:
        if self._dirty and self._file is not None:
            self._dirty = False
            os.fsync(self._file)
        unsaved = self._unsaved
        if unsaved is not None:
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            self._saved.write(*unsaved)
            if self._unsaved is unsaved:
                self._unsaved = None

    def _try(self, what: str, work: Callable[[], None]) -> bool:
        """Do something with the disk. Returns whether it is done; reports a problem unless that was reported."""
        try:
            work()
        except OSError as error:
            problem = f"{error.strerror or error}"
            known = problem in self._problems.values()
            self._problems[what] = problem
            if not known:
                advice = "what is recorded waits in memory until it can be written"
                self._tell("error", f"the journal in {self.folder} cannot be written: {problem}; {advice}")
            return False
        if self._problems.pop(what, None) is not None and not self._problems:
            lost, self._lost = f"{self._lost} lines were lost" if self._lost else "nothing was lost", 0
            self._tell("info", f"the journal in {self.folder} is written again; {lost}")
        return True

    def _pause(self) -> None:
        """Let the loop run: what holds the interpreter for long makes its periods long."""
        if not self._stop.is_set() and self._threads:
            time.sleep(PAUSE)

    def _repeat(self, work: Callable[[], bool]) -> None:
        while not self._stop.wait(PERIOD):
            work()


def _say_nothing(level: str, text: str) -> None:
    """What reports nowhere."""


def _opened(folder: Path) -> int:
    """The journal of a folder, open for this process alone. Raises OSError."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    file = os.open(folder / JOURNAL, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)
    try:
        lock(file)
    except OSError:
        os.close(file)
        raise
    return file


def lock(file: int) -> None:
    """Lock a journal until it is closed or its process ends. Raises BlockingIOError where another process has it."""
    try:
        import fcntl
    except ImportError:  # not on Windows: two sessions never have one folder there, as its name has the process
        return
    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)

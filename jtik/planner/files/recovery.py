"""Recovery of a session from its journal and its snapshot, whenever its process was killed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from jtik.arguments import finite_array
from jtik.arguments import number as read_number
from jtik.arguments import path as read_path
from jtik.errors import ArgumentError, JtikError
from jtik.planner.attempts.attempt import OPTIONAL, REQUIRED, Attempt
from jtik.planner.attempts.history import History
from jtik.planner.attempts.recording import Recording
from jtik.planner.files.journal import JOURNAL, SNAPSHOT
from jtik.planner.files.plain import entries
from jtik.planner.files.plan_file import FORMAT, VERSION, Plan, parsed, read
from jtik.types import Array

LONGEST_LINE = 64 * 2**20
"""Longest line of a journal that is read [bytes]."""

EDITS = {"choose": History.choose, "delete_attempt": History.delete}
"""Edits that change the tree of attempts, by their name."""


@dataclass(frozen=True, eq=False)
class Recovered:
    """What a session has left.

    Attributes:
        plan: the plan, with an attempt of its own for a recording that was not ended.
        unfinished: name of that attempt; None where the session ended between recordings.
        closed: whether the session was ended, not killed.
        notes: one sentence for each thing that could not be recovered.
    """

    plan: Plan
    unfinished: str | None
    closed: bool
    notes: tuple[str, ...]


def recover(folder: str | Path) -> Recovered:
    """Read whatever a session has left. A torn last line is dropped, and so is any damaged line before.

    Args:
        folder: the folder of the session.

    Raises:
        ArgumentError: for a folder that holds neither a journal nor a snapshot.
        OSError: when a file cannot be read.
    """
    folder = read_path("folder", folder, "the folder of a session")
    notes: list[str] = []
    plan, number = _snapshot(folder / SNAPSHOT, notes)
    reading = _Reading(plan.history if plan else History(), number, notes)
    if not any(line.get("snapshot") == number for line in _lines(folder / JOURNAL, [])):
        reading.beyond = True  # without its place, what the snapshot has is known by the names
    for line in _lines(folder / JOURNAL, notes):
        reading.follow(line)
    unfinished = reading.finish(kept=True, at_the_end=True)
    if plan is None:
        if reading.robot is None:
            raise ArgumentError("folder", str(folder), f"a folder with a {JOURNAL} or a {SNAPSHOT} of a session")
        plan = Plan(robot=reading.robot)
    try:
        plan = replace(plan, history=reading.history)
    except ArgumentError as error:
        notes.append(f"the attempts of the journal do not fit the robot: {error}")
    return Recovered(plan, unfinished, reading.closed, tuple(notes))


class _Reading:
    """Follows the lines of a journal.

    Args:
        history: the attempts of the snapshot.
        number: the number of the snapshot.
        notes: where to report.

    Attributes:
        history: the attempts so far.
        robot: the robot; None before the first line.
        closed: whether the session was ended.
        beyond: whether the lines from here on are not in the snapshot.
    """

    def __init__(self, history: History, number: int, notes: list[str]) -> None:
        self.history, self.robot, self.closed, self.beyond = history, None, False, False
        self._number, self._notes, self._count = number, notes, 0
        self._recorded: dict[str, Attempt] = {}
        self._recording: Recording | None = None
        self._orphan: dict[str, Any] | None = None

    robot: Mapping[str, Any] | None

    def follow(self, line: Mapping[str, Any]) -> None:
        """Follow a line; one that cannot be followed is reported."""
        self._count += 1
        try:
            self._follow(line)
        except (JtikError, AttributeError, KeyError, TypeError, ValueError) as error:
            self._notes.append(f"line {self._count} of the journal is left out: {str(error)[:200]}")

    def _follow(self, line: Mapping[str, Any]) -> None:
        if "sample" in line:
            time, q, target = line["sample"]
            if self._orphan is not None:
                own = {"times": [0.0], "configurations": [q], "targets": [target], "scenes": []}
                self._recording, self._orphan = Recording(Attempt(**(self._orphan | own))), None
            elif self._recording is not None:
                self._recording.add(*_sample(self._recording, time, q, target))
        elif "scene" in line:
            if self._recording is not None:
                self._recording.change_scene(line["scene"])
        elif "begin" in line:
            self.finish(kept=True)
            self._begin(line["begin"])
        elif "end" in line:
            self.finish(kept=line["end"] is True)
        elif "edit" in line:
            edit = line["edit"]
            change = EDITS.get(edit.get("edit"))
            if change is not None and self.beyond:
                self.history = change(self.history, edit["attempt"])
        elif line.get("journal") == FORMAT and line.get("version") == VERSION:
            self.robot = Plan(robot=line["robot"]).robot
        elif "snapshot" in line:
            self.beyond = self.beyond or line["snapshot"] == self._number
        elif "closed" in line:
            self.closed = True
        else:
            raise ArgumentError("line", sorted(line)[:5], "a line of a journal of this version")

    def finish(self, *, kept: bool, at_the_end: bool = False) -> str | None:
        """End the attempt that is being recorded. Returns its name where it is added to the history."""
        recording, self._recording, self._orphan = self._recording, None, None
        if recording is None or not kept:
            return None
        try:
            attempt = recording.attempt()
            self._recorded[attempt.name] = attempt
            if not (self.beyond or at_the_end):
                return None  # the snapshot has it, or it was deleted since
            return self._add(attempt)
        except (JtikError, ValueError) as error:
            self._notes.append(f"the attempt {recording.beginning.name!r} cannot be recovered: {str(error)[:200]}")
            return None

    def _add(self, attempt: Attempt) -> str | None:
        if attempt.name in self.history:
            if np.array_equal(self.history[attempt.name].configurations, attempt.configurations):
                return None  # the snapshot has it
            attempt = replace(attempt, name=self.history.free_name(attempt.parent))
        if attempt.parent is not None and attempt.parent not in self.history:
            attempt = replace(attempt, parent=None, branched_at=None)
        self.history = self.history.add(attempt)
        return attempt.name

    def _begin(self, data: object) -> None:
        """Begin a recording; that of a branch whose parent is not known begins with its first own sample."""
        found = entries("begin", data, REQUIRED, OPTIONAL)
        if found["times"]:
            self._recording = Recording(Attempt.from_json(found, "begin"))
            return
        name = found["parent"]
        known = {each.name: each for each in self.history} | self._recorded
        if name not in known:
            self._notes.append(f"{found['name']!r} begins at its branch: {name!r} was not found")
            self._orphan = found | {"parent": None, "branched_at": None}
            return
        beginning = known[name].cut(found["branched_at"])
        arrays = {key: getattr(beginning, key) for key in ("times", "configurations", "targets", "scenes")}
        self._recording = Recording(Attempt(**(found | arrays)))


def _sample(recording: Recording, time: object, q: object, target: object) -> tuple[float, Array, Array]:
    """A sample of numbers of the right count. Raises ArgumentError for another."""
    rows = recording.beginning
    width, size = rows.configurations.shape[1], rows.targets.shape[1]
    return read_number("time", time), finite_array("q", q, (width,)), finite_array("target", target, (size,))


def _snapshot(path: Path, notes: list[str]) -> tuple[Plan | None, int]:
    if not path.exists():
        return None, 0
    try:
        return read(path)
    except JtikError as error:
        notes.append(f"the snapshot is left out: {error}")
        return None, 0


def _lines(path: Path, notes: list[str]) -> Iterator[Mapping[str, Any]]:
    """The lines of a journal that are whole."""
    if not path.is_file():
        return
    with path.open("rb") as file:
        for number in range(1, 2**63):
            data = file.readline(LONGEST_LINE)
            if not data.endswith(b"\n"):  # the end, a torn last line, or one that no journal has
                if len(data) == LONGEST_LINE:
                    notes.append(f"the journal is read up to line {number}, which is too long")
                return
            if data == b"\n":
                continue
            try:
                line = parsed(data)
            except (ValueError, RecursionError):
                line = None
            if isinstance(line, Mapping):
                yield line
            else:
                notes.append(f"line {number} of the journal is damaged and left out")

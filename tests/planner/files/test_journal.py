"""The journal: what a killed process leaves, and what a full or read-only disk does."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import jtik
from jtik.errors import ArgumentError
from jtik.planner.attempts.history import History
from jtik.planner.attempts.recording import Recording
from jtik.planner.files import journal as journal_module
from jtik.planner.files import plan_file, snapshots
from jtik.planner.files.journal import JOURNAL, SNAPSHOT, Journal
from jtik.planner.files.plan_file import Plan
from jtik.planner.files.recovery import recover
from jtik.planner.files.sessions import new_folder, recoverable

from ..conftest import SCENE, make_attempt, same

ROBOT = {"name": "arm", "joint_names": ["a", "b", "c"], "nq": 3}
DT = 1 / 60


class Told(list):
    """Collects what is told."""

    def __call__(self, level: str, text: str) -> None:
        self.append((level, text))


def plan_of(history: History) -> Plan:
    return Plan(robot=ROBOT, scene=SCENE, settings={"strategy": "hybrid"}, history=history)


def record(journal: Journal, beginning, steps, seed=0, *, kept=True):
    """Record the same into a journal and into a Recording; returns the attempt."""
    rng = np.random.default_rng(seed)
    recording = Recording(beginning)
    journal.begin(beginning)
    for i in range(steps):
        if i % 7 == 3:
            post = {"shape": "circle", "center": rng.normal(size=2).tolist(), "radius": 0.1}
            scene = {"obstacles": {"post": post}}
            journal.scene(scene)
            recording.change_scene(scene)
        q, target = rng.normal(size=3), rng.normal(size=2)
        journal.sample(50 + i * DT, q, target)
        recording.add(50 + i * DT, q, target)
    journal.end(kept=kept)
    return recording.attempt()


def a_session(folder: Path, tell=None) -> tuple[Journal, History]:
    """Two attempts and a branch of the first, with a snapshot between; nothing is written yet."""
    journal = Journal(folder, robot=ROBOT, tell=tell)
    history = History().add(record(journal, make_attempt(k=1), 20))
    journal.snapshot(plan_of(history))
    history = history.add(record(journal, history.branch("attempt 1", 10 * DT), 12, seed=1))
    record(journal, make_attempt("discarded", k=1), 5, kept=False)
    journal.edit(60.0, {"edit": "choose", "attempt": "attempt 1.1"})
    return journal, history.choose("attempt 1.1")


def identical(a: History, b: History) -> bool:
    return a.names == b.names and a.chosen == b.chosen and all(map(same, a, b))


def test_recovery_gives_the_same_attempts_to_the_last_bit(tmp_path):
    journal, history = a_session(tmp_path)
    assert journal.write()
    found = recover(tmp_path)
    assert identical(found.plan.history, history)
    assert (found.unfinished, found.closed, found.notes) == (None, False, ())
    assert found.plan.scene == SCENE


def test_without_its_snapshot_the_journal_alone_has_every_attempt(tmp_path):
    journal, history = a_session(tmp_path)
    journal.write()
    (tmp_path / SNAPSHOT).unlink()
    assert identical(recover(tmp_path).plan.history, history)
    (tmp_path / SNAPSHOT).write_text("{torn")
    found = recover(tmp_path)
    assert identical(found.plan.history, history)
    assert "snapshot" in found.notes[0]


def test_without_its_journal_the_snapshot_is_what_is_left(tmp_path):
    journal, history = a_session(tmp_path)
    journal.snapshot(plan_of(history))
    journal.close()
    (tmp_path / JOURNAL).unlink()
    assert identical(recover(tmp_path).plan.history, history)
    with pytest.raises(ArgumentError, match=JOURNAL):
        recover(tmp_path / "other")


def test_a_deleted_attempt_stays_deleted(tmp_path):
    journal, history = a_session(tmp_path)
    history = history.delete("attempt 1")
    journal.edit(70.0, {"edit": "delete_attempt", "attempt": "attempt 1"})
    journal.write()
    assert recover(tmp_path).plan.history.names == ("attempt 1.1",)
    journal.snapshot(plan_of(history))
    journal.write()
    found = recover(tmp_path)
    assert identical(found.plan.history, history)
    assert found.notes == ()


@pytest.mark.quick(10)
@pytest.mark.parametrize("seed", range(40))
def test_a_journal_that_ends_anywhere_gives_every_whole_line(tmp_path, seed):
    """The oracle counts the whole lines with samples by itself."""
    journal, history = a_session(tmp_path)
    journal.write()
    (tmp_path / SNAPSHOT).unlink()
    data = (tmp_path / JOURNAL).read_bytes()
    first = data.index(b"\n") + 1
    end = random.Random(seed).randrange(first, len(data))
    (tmp_path / JOURNAL).write_bytes(data[:end])
    whole = [json.loads(line) for line in data[:end].split(b"\n")[:-1]]
    begun = [i for i, line in enumerate(whole) if "begin" in line]
    found = recover(tmp_path)
    assert found.notes == ()
    if not begun:
        assert len(found.plan.history) == 0
        return
    if begun[-1] == max(begun) and not any("end" in line for line in whole[begun[-1] :]):
        samples = sum("sample" in line for line in whole[begun[-1] :])
        attempt = found.plan.history[found.unfinished]
        own = len(attempt) - (11 if attempt.parent else 1)
        assert own == samples
        if attempt.name in history:
            assert (attempt.configurations == history[attempt.name].configurations[: len(attempt)]).all()


def test_damaged_lines_are_left_out_and_reported(tmp_path):
    journal, history = a_session(tmp_path)
    journal.write()
    (tmp_path / SNAPSHOT).unlink()
    lines = (tmp_path / JOURNAL).read_bytes().splitlines(keepends=True)
    lines[5:5] = [
        b"\x00\xff\n",
        b"[1]\n",
        b'{"sample": [1, [NaN, 0, 0], [0, 0]]}\n',
        b'{"sample": [1, [0, 0], [0, 0]]}\n',
        b'{"sample": 3}\n',
        b'{"edit": 3}\n',
        b'{"begin": {"times": []}}\n' * 0,
        b'{"unknown": 1}\n',
        b"[" * 100_000 + b"\n",
    ]
    (tmp_path / JOURNAL).write_bytes(b"".join(lines))
    found = recover(tmp_path)
    assert len(found.notes) == 8
    assert identical(found.plan.history, history)


class Disk:
    """Stands for the module os in the journal: a disk with room for so many bytes."""

    def __init__(self, room: int) -> None:
        self.room = room

    def __getattr__(self, name):
        return getattr(os, name)

    def write(self, file, data):
        if self.room <= 0:
            raise OSError(28, "No space left on device")
        written = os.write(file, bytes(data)[: min(self.room, 1000)])
        self.room -= written
        return written


@pytest.mark.parametrize("room", [0, 1, 50, 333, 1000, 1001, 2500, 4096])
def test_a_full_disk_is_told_once_and_nothing_is_lost_when_there_is_room(tmp_path, monkeypatch, room):
    told = Told()
    journal, history = a_session(tmp_path, told)
    disk = Disk(room)
    monkeypatch.setattr(journal_module, "os", disk)
    assert not journal.write()
    disk.room = room // 3
    assert not journal.write()
    assert [level for level, _ in told] == ["error"]
    assert "No space left on device" in told[0][1]
    disk.room = 10**9
    assert journal.write()
    assert told[-1][0] == "info"
    (tmp_path / SNAPSHOT).unlink()
    found = recover(tmp_path)
    assert identical(found.plan.history, history)


def test_a_folder_that_cannot_be_made_is_told_and_never_raises(tmp_path):
    told = Told()
    (tmp_path / "file").write_text("")
    journal, history = a_session(tmp_path / "file" / "session", told)
    assert not journal.write()
    assert not journal.write()
    assert len(told) == 1
    (tmp_path / "file").unlink()
    assert journal.write()
    assert identical(recover(tmp_path / "file" / "session").plan.history, history)


def test_memory_is_bounded_while_nothing_can_be_written(tmp_path, monkeypatch):
    monkeypatch.setattr(journal_module, "MOST_WAITING", 10)
    (tmp_path / "file").write_text("")
    told = Told()
    journal = Journal(tmp_path / "file" / "session", robot=ROBOT, tell=told)
    for i in range(30):
        journal.sample(float(i), np.zeros(3), np.zeros(2))
        journal.write()
    assert len(journal._notes) + len(journal._pending) == 10
    assert ["more than 10 lines" in text for _, text in told] == [False, True]


def test_what_is_no_json_is_left_out(tmp_path):
    told = Told()
    journal = Journal(tmp_path, robot=ROBOT, tell=told)
    journal.edit(0.0, {"edit": print})
    journal.sample(0.0, np.array([np.nan, 0, 0]), np.zeros(2))
    assert journal.write()
    assert len(told) == 2


def test_a_snapshot_that_fails_leaves_the_old_one(tmp_path, monkeypatch):
    path = tmp_path / "plan.json"
    plan_of(History()).save(path)
    before = path.read_bytes()

    def broken(*arguments):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(plan_file.os, "fsync", broken)
    with pytest.raises(OSError, match="No space left"):
        plan_of(History().add(make_attempt())).save(path)
    assert path.read_bytes() == before
    assert [each.name for each in tmp_path.iterdir()] == ["plan.json"]


def test_running_sessions_are_not_offered_and_those_that_were_killed_are(tmp_path):
    journal, history = a_session(new_folder(tmp_path))
    journal.write()
    assert recoverable(tmp_path) == ()
    journal.close()
    (session,) = recoverable(tmp_path)
    assert not session.closed
    assert session.folder == journal.folder
    assert new_folder(tmp_path) != session.folder
    ended, _ = a_session(new_folder(tmp_path))
    ended.close(plan_of(history))
    assert {each.folder: each.closed for each in recoverable(tmp_path)} == {journal.folder: False, ended.folder: True}
    assert recover(ended.folder).closed
    assert identical(recover(ended.folder).plan.history, history)
    assert recoverable(tmp_path / "nothing") == ()


def test_a_killed_session_in_which_nothing_was_done_is_not_offered(tmp_path):
    journal = Journal(new_folder(tmp_path), robot=ROBOT)
    journal.write()
    journal.close()
    assert recoverable(tmp_path) == ()
    again = Journal(new_folder(tmp_path), robot=ROBOT)
    again.edit(0.0, {"edit": "set_target_speed", "speed": 1.0})
    again.write()
    again.close()
    assert [session.folder for session in recoverable(tmp_path)] == [again.folder]


def test_a_session_in_which_nothing_was_done_leaves_nothing(tmp_path):
    journal = Journal(new_folder(tmp_path), robot=ROBOT)
    journal.start()
    journal.close(plan_of(History()))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="POSIX only")
def test_the_default_folder_is_private(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    folder = new_folder()
    assert folder.parent == tmp_path / "state" / "jtik"
    assert folder.parent.stat().st_mode & 0o777 == 0o700
    journal, _ = a_session(folder)
    journal.write()
    journal.close()
    assert folder.stat().st_mode & 0o077 == 0
    assert (folder / JOURNAL).stat().st_mode & 0o077 == 0
    assert [session.folder for session in recoverable()] == [folder]
    folder.parent.chmod(0o777)
    told = Told()
    assert tmp_path not in new_folder(tell=told).parents
    assert "can be changed by other users" in told[0][1]
    folder.parent.chmod(0o700)


RECORDER = """
import sys, time
import numpy as np
from pathlib import Path
from jtik.planner.files.journal import Journal
from jtik.planner.attempts.attempt import Attempt

journal = Journal(Path(sys.argv[1]), robot={"name": "arm", "joint_names": ["a"], "nq": 1})
journal.start()
begin = time.monotonic()
journal.begin(Attempt(name="attempt 1", dt=1e-3, times=[0.0], configurations=[[0.0]], targets=[[0.0, 0.0]]))
while True:
    now = time.monotonic()
    journal.sample(now, np.array([now]), np.zeros(2))
    print(repr(now), flush=True)
    time.sleep(1e-3)
"""


@pytest.mark.slow
def test_after_kill_9_everything_but_the_last_second_is_there(tmp_path):
    root = Path(jtik.__file__).parents[1]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(root), str(root / "formulations")])}
    command = [sys.executable, "-c", RECORDER, str(tmp_path / "session")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    seen = []
    for line in process.stdout:
        seen.append(float(line))
        if seen[-1] - seen[0] > 2.6:
            process.send_signal(signal.SIGKILL)
            break
    seen += [float(line) for line in process.stdout if line.endswith("\n")]
    process.wait()
    process.stdout.close()
    found = recover(tmp_path / "session")
    assert found.unfinished == "attempt 1"
    times = found.plan.history["attempt 1"].configurations[1:, 0]
    assert times.tolist() == seen[: len(times)]
    pauses = max(np.diff(seen))  # a machine that is busy elsewhere writes later by as much
    assert seen[-1] - times[-1] < 1.0 + 5 * pauses
    assert [session.folder for session in recoverable(tmp_path)] == [tmp_path / "session"]
    assert time.time() - recoverable(tmp_path)[0].ended < 3600


def test_snapshots_copy_attempts_that_were_written_before(tmp_path, monkeypatch):
    encoded = []
    pieces = snapshots.attempt_pieces
    monkeypatch.setattr(snapshots, "attempt_pieces", lambda attempt: encoded.append(attempt.name) or pieces(attempt))
    writer = snapshots.Snapshots(tmp_path / "plan.json", lambda: None)
    history = History()
    for i in range(4):
        history = history.add(make_attempt(f"attempt {i}", k=100 + 30 * i, scenes=[(0.0, SCENE)]))
        writer.write(plan_of(history), i)
    history = history.delete("attempt 1").choose("attempt 2")
    writer.write(plan_of(history), 9)
    assert encoded == [f"attempt {i}" for i in range(4)]
    plan, number = plan_file.read(tmp_path / "plan.json")
    assert number == 9
    assert identical(plan.history, history)
    assert (tmp_path / "plan.json").read_text() == "".join(plan_of(history).pieces(journal=9))
    (tmp_path / "plan.json").unlink()
    writer.write(plan_of(history), 10)
    assert identical(Plan.load(tmp_path / "plan.json").history, history)


def test_a_snapshot_that_somebody_cut_off_is_written_again(tmp_path):
    told = Told()
    journal, history = a_session(tmp_path, told)
    assert journal.write()
    (tmp_path / SNAPSHOT).write_text("")
    journal.snapshot(plan_of(history))
    journal.write()
    journal.write()
    assert identical(plan_file.read(tmp_path / SNAPSHOT)[0].history, history)

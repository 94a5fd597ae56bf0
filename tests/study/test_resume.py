"""Studies that are interrupted, saved and resumed."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import jtik
from jtik.study import result_file, unit_runner
from jtik_formulations import Damped, JointCentering, ObstacleAvoidance

TWO = ["hybrid", "damped"]


def options(**changed):
    return {"strategies": TWO, "criteria": JointCentering(), "count": 8, "block": 2, "repeats": 1, **changed}


def interrupt_after(count):
    def report(done, total):
        assert total == 4
        if done == count:
            raise KeyboardInterrupt

    return report


@pytest.fixture
def counted(monkeypatch):
    """The units in the order in which they are run."""
    done = []
    run = unit_runner.UnitRunner.run
    monkeypatch.setattr(unit_runner.UnitRunner, "run", lambda self, unit: done.append(unit) or run(self, unit))
    return done


@pytest.fixture(scope="module")
def before(arm, task, tmp_path_factory):
    """The file of a complete study."""
    path = tmp_path_factory.mktemp("before") / "study.npz"
    jtik.compare(arm, task, **options(), save=path)
    return path.read_bytes()


def test_an_interrupted_study_returns_completed_units(arm, task):
    study = jtik.compare(arm, task, **options(), progress=interrupt_after(3))
    assert not study.complete
    assert len(study) == 2 * 6
    assert "incomplete" in repr(study)


def test_an_interrupted_study_cancels_units_on_an_executor(arm, task, counted):
    def report(done, total):
        raise KeyboardInterrupt

    with ThreadPoolExecutor(1) as pool:
        study = jtik.compare(arm, task, **options(count=100), executor=pool, progress=report)
    assert not study.complete
    assert 2 * 2 <= len(study) <= 2 * 2 * len(counted)
    assert len(counted) < 50


def test_a_study_resumes_from_its_file(arm, task, tmp_path, counted, assert_same):
    path, reported = tmp_path / "study.npz", []
    complete = jtik.compare(arm, task, **options())
    jtik.compare(arm, task, **options(), save=path, progress=interrupt_after(3))
    assert not jtik.Comparison.load(path).complete
    counted.clear()
    study = jtik.compare(arm, task, **options(), save=path, progress=lambda *now: reported.append(now))
    assert [(unit.start, unit.stop) for unit in counted] == [(6, 8)]
    assert reported == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert study.complete
    assert_same(complete, study)
    assert_same(complete, jtik.Comparison.load(path))
    counted.clear()
    assert_same(complete, jtik.compare(arm, task, **options(), save=path))
    assert not counted


@pytest.mark.slow
def test_a_study_resumes_with_units_of_another_size(arm, task, tmp_path, assert_same):
    path = tmp_path / "study.npz"
    jtik.compare(arm, task, **options(), save=path, progress=interrupt_after(3))
    with pytest.raises(jtik.ArgumentError, match="save"):
        jtik.compare(arm, task, **options(repeats=2), save=path)
    study = jtik.compare(arm, task, **options(block=3), save=path)
    assert_same(jtik.compare(arm, task, **options()), study)


def test_completed_units_are_saved_after_an_error(arm, task, tmp_path):
    def report(done, total):
        if done == 2:
            raise ZeroDivisionError

    path = tmp_path / "study.npz"
    with pytest.raises(ZeroDivisionError):
        jtik.compare(arm, task, **options(), save=path, progress=report)
    assert len(jtik.Comparison.load(path)) == 2 * 4


@pytest.mark.quick(3)
@pytest.mark.parametrize(
    "changed",
    [
        {"seed": 1},
        {"count": 9},
        {"strategies": ["hybrid", Damped(damping=0.3)]},
        {"criteria": 2.0 * JointCentering()},
        {"criteria": ObstacleAvoidance([jtik.Circle(center=(1.0, 1.0), radius=0.1)])},
        {"max_iterations": 999},
        {"until": "stationary"},
        {"limits": False},
    ],
)
def test_the_file_of_another_study_is_refused(arm, task, tmp_path, changed, counted, before):
    path = tmp_path / "study.npz"
    path.write_bytes(before)
    with pytest.raises(jtik.ArgumentError, match=r"save: given .*another study"):
        jtik.compare(arm, task, **options(**changed), save=path)
    assert not counted
    assert path.read_bytes() == before


def test_a_file_without_a_study_is_refused_and_unchanged(arm, task, tmp_path):
    path = tmp_path / "notes.npz"
    path.write_text("groceries")
    with pytest.raises(jtik.ArgumentError):
        jtik.compare(arm, task, **options(), save=path)
    assert path.read_text() == "groceries"
    for invalid in (tmp_path / "study.csv", tmp_path / "nowhere" / "study.npz"):
        with pytest.raises(jtik.ArgumentError, match="save"):
            jtik.compare(arm, task, **options(), save=invalid)


@pytest.mark.quick(1)
@pytest.mark.parametrize("pause", [0.0, 5.0])
def test_a_full_disk_does_not_cost_the_study(arm, task, tmp_path, monkeypatch, assert_same, pause):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    complete = jtik.compare(arm, task, **options())
    monkeypatch.setattr(result_file, "write_archive", full)
    monkeypatch.setattr(result_file, "PAUSE", pause)
    with pytest.warns(RuntimeWarning, match="the study was not saved: .*No space left.*Comparison.save") as warned:
        study = jtik.compare(arm, task, **options(), save=tmp_path / "study.npz")
    assert [each.filename for each in warned] == [__file__]
    assert_same(study, complete)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="mounts need root")
def test_a_disk_that_is_full_keeps_no_part_of_a_file(arm, task, tmp_path, assert_same):
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=16k", "tmpfs", str(tmp_path)], capture_output=True, check=False
    )
    if mounted.returncode:
        pytest.skip(f"no mount: {mounted.stderr.decode(errors='replace')}")
    try:
        with pytest.warns(RuntimeWarning, match="No space left"):
            study = jtik.compare(arm, task, **options(), save=tmp_path / "study.npz")
        assert list(tmp_path.iterdir()) == []
        with pytest.raises(OSError, match="No space left"):
            study.save(tmp_path / "study.npz")
        assert list(tmp_path.iterdir()) == []
    finally:
        subprocess.run(["umount", "-l", str(tmp_path)], check=True)
    assert_same(study, jtik.compare(arm, task, **options()))


KILLED = """
import sys
import jtik
from jtik.study import result_file
result_file.PAUSE, result_file.SHARE = 0.0, 1e9
arm = jtik.Robot.planar(4)
print("ready", flush=True)
jtik.compare(
    arm, jtik.FrameTask("tip", kind="position"), strategies=["hybrid", "damped"], count=40, block=1, repeats=1,
    save=sys.argv[1],
)
"""


@pytest.mark.slow
def test_a_study_that_is_killed_again_and_again_is_found_again(tmp_path):
    path, found = tmp_path / "study.npz", [0]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(each for each in sys.path if each)}
    setting = {"strategies": TWO, "count": 40, "block": 1, "repeats": 1}
    arm, task = jtik.Robot.planar(4), jtik.FrameTask("tip", kind="position")
    expected = jtik.compare(arm, task, **setting)
    for patience, moment in ((0.0, 0.0), (0.0, 0.2), (0.0, 0.5), (60.0, 0.1)):  # the last one has stored something
        call = [sys.executable, "-c", KILLED, str(path)]
        with subprocess.Popen(call, stdout=subprocess.PIPE, env=environment) as process:
            process.stdout.readline()
            end = time.monotonic() + patience
            while not path.exists() and time.monotonic() < end:
                time.sleep(0.01)
            time.sleep(moment)
            process.send_signal(signal.SIGKILL)
        if path.exists():
            kept = jtik.Comparison.load(path)
            found.append(len(kept))
            for contender in kept.contenders:
                rows = expected.rows(contender=contender)
                index = {name: row for row, name in zip(rows, expected.columns["case"][rows], strict=True)}
                own = kept.rows(contender=contender)
                wanted = [index[name] for name in kept.columns["case"][own]]
                np.testing.assert_array_equal(kept.answers[own], expected.answers[wanted])
    assert found == sorted(found)
    assert found[-1] > 0
    again = jtik.compare(arm, task, **setting, save=path)
    assert again.complete
    np.testing.assert_array_equal(again.answers, expected.answers)

"""Result files of studies."""

from __future__ import annotations

import json

import numpy as np
import pytest

import jtik
from jtik._loop.fingerprint import fingerprint
from jtik.task import Task, TaskRows
from jtik_formulations import JointCentering


@pytest.fixture(scope="module")
def study(arm, task):
    return jtik.compare(
        arm,
        task,
        strategies=["hybrid", "nonsense"],
        criteria={"none": None, "centred": JointCentering()},
        problems={"reachable": 3, "circle": 1, "unreachable": 1},
        repeats=1,
        traces=2,
    )


def test_a_loaded_study_equals_the_saved_one(study, tmp_path, assert_same):
    study.save(tmp_path / "study.npz")
    loaded = jtik.Comparison.load(tmp_path / "study.npz")
    assert_same(study, loaded)
    for name, column in study.columns.items():
        np.testing.assert_array_equal(column, loaded.columns[name])
    assert loaded.problems == study.problems
    assert (loaded.settings, loaded.machine) == (study.settings, study.machine)
    assert (loaded.complete, loaded.fingerprint) == (study.complete, study.fingerprint)
    assert fingerprint(loaded.robot, loaded.task) == fingerprint(study.robot, study.task)
    assert repr(loaded) == repr(study)


def test_a_loaded_study_can_be_solved_again(study, tmp_path):
    study.save(tmp_path / "study.npz")
    loaded = jtik.Comparison.load(tmp_path / "study.npz")
    again = jtik.compare(loaded.robot, loaded.task, strategies="hybrid", problems=loaded.problems, repeats=1)
    rows = loaded.rows(contender="hybrid", criteria="none")
    np.testing.assert_array_equal(again.answers, loaded.answers[rows])


def test_the_file_format_keeps_its_names(study, tmp_path):
    """A renamed key or column would make existing files unreadable."""
    study.save(tmp_path / "study.npz")
    with np.load(tmp_path / "study.npz", allow_pickle=False) as archive:
        header, names = json.loads(str(archive["header"])), set(archive.files)
    assert header["format"] == 1
    keys = "format robot tasks problems obstacles settings machine complete fingerprint traces paths"
    assert set(header) == set(keys.split())
    columns = """
        contender criteria case kind success status note iterations seconds seconds_low seconds_high
        seconds_per_iteration position_error orientation_error H regret monotone clearance limit_margin leakage
        path_length smoothness drift condition
    """
    assert {name for name in names if name.startswith("column/")} == {f"column/{name}" for name in columns.split()}
    assert {"answers", "trace/0", "path/0"} <= names


def test_no_temporary_file_remains(study, tmp_path):
    for _ in range(2):
        study.save(tmp_path / "study.npz")
    assert [path.name for path in tmp_path.iterdir()] == ["study.npz"]


def test_invalid_files_are_refused(tmp_path):
    path = tmp_path / "other.npz"
    np.savez(path, a=np.zeros(3))
    with pytest.raises(jtik.ArgumentError, match="path"):
        jtik.Comparison.load(path)
    path.write_bytes(b"PK\x03\x04 but no zip")
    with pytest.raises(jtik.ArgumentError, match="path"):
        jtik.Comparison.load(path)
    with pytest.raises(jtik.ArgumentError, match=r"\.npz"):
        jtik.Comparison.load(tmp_path / "other.csv")
    with pytest.raises(jtik.ArgumentError, match="absent.npz; accepted: the path of a file that exists"):
        jtik.Comparison.load(tmp_path / "absent.npz")


def test_a_file_with_a_pickle_is_refused(tmp_path):
    path = tmp_path / "study.npz"
    np.savez(path, header=np.array([{"format": 1}], dtype=object))
    with pytest.raises(jtik.ArgumentError, match="path"):
        jtik.Comparison.load(path)


class Level(Task):
    """A task of your own: the height of the tip."""

    name, priority = "level", 0

    def target_size(self, robot):
        return 1

    def read_target(self, robot, target):
        return np.array(target, dtype=float).reshape(1)

    def rows(self, kinematics, target):
        return TaskRows(kinematics.position("tip")[1] - target, (True,))

    def weight(self, rows):
        return np.eye(rows)


def test_a_custom_task_is_not_stored(arm, tmp_path):
    here = jtik.problems.Case(name="level", kind="level", q0=[0.1, 0.2, 0.3, 0.4], targets=[[1.5]])
    study = jtik.compare(arm, Level(), strategies="damped", problems=here)
    assert study.columns["success"].all()
    study.save(tmp_path / "study.npz")
    loaded = jtik.Comparison.load(tmp_path / "study.npz")
    assert loaded.tasks == ()
    assert "Level" in loaded.settings["task"]

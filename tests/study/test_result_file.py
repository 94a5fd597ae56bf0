"""Studies in files."""

from __future__ import annotations

import json

import numpy as np
import pytest

import jtik
from jtik.robot.body import Mass
from jtik.study.description import DescriptionError, as_data, from_data
from jtik.study.fingerprint import fingerprint
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


def test_what_is_loaded_is_what_was_saved(study, tmp_path, assert_same):
    study.save(tmp_path / "study.npz")
    twin = jtik.Comparison.load(tmp_path / "study.npz")
    assert_same(study, twin)
    for name, column in study.columns.items():
        np.testing.assert_array_equal(column, twin.columns[name])
    assert twin.problems == study.problems
    assert (twin.settings, twin.machine) == (study.settings, study.machine)
    assert (twin.complete, twin.fingerprint) == (study.complete, study.fingerprint)
    assert fingerprint(twin.robot, twin.task) == fingerprint(study.robot, study.task)
    assert repr(twin) == repr(study)


def test_a_loaded_study_can_be_solved_again(study, tmp_path):
    study.save(tmp_path / "study.npz")
    twin = jtik.Comparison.load(tmp_path / "study.npz")
    again = jtik.compare(twin.robot, twin.task, strategies="hybrid", problems=twin.problems, repeats=1)
    rows = twin.rows(contender="hybrid", criteria="none")
    np.testing.assert_array_equal(again.answers, twin.answers[rows])


def test_nothing_is_left_beside_it(study, tmp_path):
    for _ in range(2):
        study.save(tmp_path / "study.npz")
    assert [path.name for path in tmp_path.iterdir()] == ["study.npz"]


def test_files_that_are_none_are_refused(tmp_path):
    path = tmp_path / "other.npz"
    np.savez(path, a=np.zeros(3))
    with pytest.raises(jtik.ArgumentError, match="path"):
        jtik.Comparison.load(path)
    path.write_bytes(b"PK\x03\x04 but no zip")
    with pytest.raises(jtik.ArgumentError, match="path"):
        jtik.Comparison.load(path)
    with pytest.raises(jtik.ArgumentError, match=r"\.npz"):
        jtik.Comparison.load(tmp_path / "other.csv")
    with pytest.raises(OSError, match="absent"):
        jtik.Comparison.load(tmp_path / "absent.npz")


def test_a_file_with_a_pickle_in_it_is_refused(tmp_path):
    path = tmp_path / "study.npz"
    np.savez(path, header=np.array([{"format": 1}], dtype=object))
    with pytest.raises(jtik.ArgumentError, match="path"):
        jtik.Comparison.load(path)


class Level(Task):
    """A task of somebody's own: the height of the tip."""

    name, priority = "level", 0

    def target_size(self, robot):
        return 1

    def read_target(self, robot, target):
        return np.array(target, dtype=float).reshape(1)

    def rows(self, kinematics, target):
        return TaskRows(kinematics.position("tip")[1] - target, (True,))

    def weight(self, rows):
        return np.eye(rows)


def test_a_task_of_somebody_s_own_is_not_in_the_file(arm, tmp_path):
    here = jtik.problems.Case(name="level", kind="level", q0=[0.1, 0.2, 0.3, 0.4], targets=[[1.5]])
    study = jtik.compare(arm, Level(), strategies="damped", problems=here)
    assert study.columns["success"].all()
    study.save(tmp_path / "study.npz")
    twin = jtik.Comparison.load(tmp_path / "study.npz")
    assert twin.tasks == ()
    assert "Level" in twin.settings["task"]


class TestDescriptions:
    @pytest.mark.parametrize(
        "value",
        [
            jtik.Robot.planar([1.0, 0.1 + 0.2], lower=-1.0, upper=2.0),
            jtik.Robot.builtin("panda"),
            jtik.Robot([jtik.Joint("float", jtik.JointType.FREE, "base", "body")], masses={"body": Mass(2.0)}),
            jtik.FrameTask("tip", "pose", axes=("x", "rz"), stiffness=[1.0, 2.0], priority=1, name="hand"),
            (jtik.AxisTask("tip", axis=(0, 1, 1)), jtik.LookAtTask("tip"), jtik.RelativeFrameTask("a", "b")),
            jtik.CenterOfMassTask(),
        ],
        ids=repr,
    )
    def test_they_survive_json(self, value):
        twin = from_data(json.loads(json.dumps(as_data(value))))
        assert fingerprint(twin) == fingerprint(value)

    def test_other_classes_are_neither_described_nor_made(self):
        with pytest.raises(DescriptionError):
            as_data(Level())
        with pytest.raises(DescriptionError):
            from_data({"class": "Popen", "state": {"args": "true"}})

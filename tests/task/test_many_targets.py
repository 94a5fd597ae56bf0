"""Many targets that are read at once have the numbers of each that is read by itself, and the same are refused."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik._loop.arguments import read_targets
from jtik.task import TaskStack

from ..conftest import dh_arm, planar

ARM = dh_arm(7, 3)


@pytest.mark.parametrize("kind", ["position", "orientation", "pose"])
@pytest.mark.parametrize("many", [np.array, list], ids=["array", "list"])
def test_matrices(kind, many, rng):
    tasks = TaskStack.of(ARM, jtik.FrameTask("tip", kind))
    poses = np.array([ARM.pose(ARM.random_configuration(rng)) for _ in range(20)])
    _, table = read_targets(tasks, many(poses))
    assert np.array_equal(table, [tasks.read_target(pose) for pose in poses])
    assert tasks.read_table(poses) is not None


def test_vectors(rng):
    tasks = TaskStack.of(planar(3), jtik.FrameTask("tip", "position"))
    targets = rng.uniform(-1, 1, (20, 2))
    given, table = read_targets(tasks, targets)
    assert np.array_equal(table, targets)
    assert len(given) == 20
    targets[0] = 9.0
    assert table[0, 0] != 9.0


FAULTS = {
    "NaN": (slice(None), 3, np.nan),
    "scaled": (slice(0, 3), slice(0, 3), 2.0),
    "no last row": (3, 0, 0.5),
    "infinity": (1, 3, np.inf),
}


@pytest.mark.parametrize("kind", ["position", "orientation", "pose"])
@pytest.mark.parametrize("fault", FAULTS)
def test_one_that_is_wrong_is_named(fault, kind, rng):
    tasks = TaskStack.of(ARM, jtik.FrameTask("tip", kind))
    poses = np.array([ARM.pose(ARM.random_configuration(rng)) for _ in range(20)])
    rows, columns, value = FAULTS[fault]
    poses[7, rows, columns] = value
    with pytest.raises(jtik.ArgumentError, match=r"targets\[7\]"):
        read_targets(tasks, poses)


def test_a_mirrored_rotation_is_refused(rng):
    tasks = TaskStack.of(ARM, jtik.FrameTask("tip", "pose"))
    poses = np.array([ARM.pose(ARM.random_configuration(rng)) for _ in range(20)])
    poses[3, :3, 0] *= -1
    with pytest.raises(jtik.ArgumentError, match=r"targets\[3\]"):
        read_targets(tasks, poses)


def test_other_forms_are_read_one_by_one(rng):
    tasks = TaskStack.of(ARM, jtik.FrameTask("tip", "pose"))
    poses = [ARM.pose(ARM.random_configuration(rng)) for _ in range(3)]
    mixed = [poses[0], poses[1].tolist(), (poses[2][:3, 3], poses[2][:3, :3])]
    assert np.array_equal(read_targets(tasks, mixed)[1], read_targets(tasks, poses)[1])

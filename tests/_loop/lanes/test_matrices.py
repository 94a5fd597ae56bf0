"""Matrices that are read in lanes have the numbers of each that is read by itself, and the same are refused."""

from __future__ import annotations

import numpy as np
import pytest

import jtik

from ...conftest import dh_arm
from ...task.test_many_targets import FAULTS

ARM = dh_arm(7, 3)


@pytest.fixture(scope="module", params=["position", "orientation", "pose"])
def compiled(request):
    """A solver whose searches in lanes are compiled."""
    ik = jtik.InverseKinematics(ARM, jtik.FrameTask("tip", request.param), strategy="damped")
    ik.solve_batch([ARM.pose(ARM.home)], restarts=2, lanes=True)
    return ik


def poses(count, seed=0):
    generator = np.random.default_rng(seed)
    return np.array([ARM.pose(ARM.random_configuration(generator)) for _ in range(count)])


@pytest.mark.parametrize("count", [1, 3, 4, 5, 8, 21])
def test_they_are_read_as_each_by_itself(count, compiled):
    targets = poses(count)
    numbers = compiled._solving._lanes.read_matrices(targets)
    assert np.array_equal(numbers, [compiled.tasks.read_target(target) for target in targets])


def test_parts_of_a_larger_array_are_left_to_the_task(compiled):
    targets = poses(12)[::3]
    assert compiled._solving._lanes.read_matrices(targets) is None
    found = compiled.solve_batch(targets, restarts=10, lanes=True)
    assert np.array_equal(found.targets, [compiled.tasks.read_target(target) for target in targets])


def test_no_search_is_compiled_yet():
    ik = jtik.InverseKinematics(ARM, jtik.FrameTask("tip", "pose"), strategy="damped")
    assert ik._solving._lanes.read_matrices(poses(3)) is None


@pytest.mark.parametrize("strategy", ["damped", "hybrid"])
def test_they_are_read_after_a_solve_in_lanes_as_well(strategy):
    """One library may serve the attempts for one target and batches."""
    ik = jtik.InverseKinematics(ARM, jtik.FrameTask("tip", "pose"), strategy=strategy)
    targets = poses(9)
    ik.solve(targets[0], restarts=5, lanes=True)
    ik.solve_batch(targets[:1], restarts=5, lanes=True)
    assert ik._solving._lanes.read_matrices(targets) is not None


@pytest.mark.parametrize("at", [0, 3, 16])
@pytest.mark.parametrize("fault", [*FAULTS, "mirrored", "sheared"])
def test_one_that_is_wrong_is_named(fault, at, compiled):
    targets = poses(17)
    if fault in FAULTS:
        rows, columns, value = FAULTS[fault]
        targets[at, rows, columns] = value
    else:
        targets[at, :3, 0] = -targets[at, :3, 0] if fault == "mirrored" else targets[at, :3, 0] + 0.1
    assert compiled._solving._lanes.read_matrices(targets) is None
    with pytest.raises(jtik.ArgumentError, match=rf"targets\[{at}\]"):
        compiled.solve_batch(targets, restarts=10, lanes=True)

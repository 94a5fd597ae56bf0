"""The task whose position a generator moves."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.problems.position_task import PositionTask
from jtik.problems.problem_setup import ProblemSetup

from ..conftest import planar
from .conftest import gallery


def position_task(robot, *tasks, **options):
    return PositionTask.of(ProblemSetup(robot, tasks), **options)


def test_the_first_task_with_a_position_is_used():
    turn = jtik.FrameTask("link2", kind="orientation", name="turn")
    assert position_task(planar(3), turn, jtik.FrameTask("tip")).task.frame == "tip"
    with pytest.raises(jtik.ArgumentError, match="kind 'position' or 'pose'"):
        position_task(planar(3), turn)


@pytest.mark.parametrize("axes", ["xyz", "xz", "y"])
def test_directions_are_orthonormal_in_the_kept_coordinates(axes):
    task = position_task(gallery("panda"), jtik.FrameTask(axes=axes))
    basis = task.basis(np.random.default_rng(0), len(axes))
    np.testing.assert_allclose(basis.T @ basis, np.eye(len(axes)), atol=1e-12)
    others = [i for i, name in enumerate("xyz") if name not in axes]
    assert not basis[others].any()
    assert task.only(np.ones(3)).tolist() == [float(name in axes) for name in "xyz"]


def test_a_target_moves_in_position_only():
    task = position_task(gallery("panda"), jtik.FrameTask(kind="pose"))
    pose = np.eye(4)
    moved = task.moved(pose, np.array([0.1, 0.2, 0.3]))
    np.testing.assert_allclose(moved[:3, 3], [0.1, 0.2, 0.3])
    np.testing.assert_allclose(moved[:3, :3], np.eye(3))
    assert pose[0, 3] == 0


def test_only_a_position_on_an_unlimited_planar_arm_has_an_exact_reach():
    assert position_task(planar(3), jtik.FrameTask()).is_exact
    assert not position_task(planar(3), jtik.FrameTask(kind="pose")).is_exact
    assert not position_task(planar(4, lower=-2.0, upper=2.0), jtik.FrameTask()).is_exact

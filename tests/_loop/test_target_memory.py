"""Targets into the memory of a step: a function reads what the tasks read, and refuses what these refuse."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jtik
from jtik._loop.target_memory import TargetMemory
from jtik.task import TaskStack
from jtik.task.targets import ROTATION_TOLERANCE

from ..conftest import dh_arm, planar, shared_solver

KINDS = ("pose", "position", "orientation")


def poses(count, seed):
    rng = np.random.default_rng(seed)
    for R in Rotation.random(count, random_state=seed).as_matrix():
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = R, rng.normal(size=3) * 10.0 ** rng.integers(-9, 9)
        yield T


def made(kind, robot=None):
    stack = TaskStack(robot or dh_arm(), [jtik.FrameTask("tip", kind=kind)])
    memory = np.full(stack.target_size, -7.0)
    return TargetMemory(stack, memory), memory, stack


@pytest.mark.parametrize("kind", KINDS)
def test_matrices_are_read_as_the_tasks_read_them(kind):
    targets, memory, stack = made(kind)
    for T in poses(50, 1):
        targets.read(T)
        assert memory.tolist() == stack.read_target(T).tolist()


@pytest.mark.parametrize("order", ["F", "every second"])
def test_matrices_of_any_layout(order):
    targets, memory, stack = made("pose")
    for T in poses(5, 2):
        other = np.asfortranarray(T) if order == "F" else np.repeat(np.repeat(T, 2, 0), 2, 1)[::2, ::2]
        targets.copy(other)
        assert memory.tolist() == stack.read_target(T).tolist()


def harmed(T, how):
    bad = T.copy()
    if how == "scaled":
        bad[:3, :3] *= 1 + 2e-6
    elif how == "mirrored":
        bad[:3, 0] *= -1
    elif how == "last row":
        bad[3] = [0, 0, 1e-9, 1]
    elif how == "not orthogonal":
        bad[:3, 0] += 5 * ROTATION_TOLERANCE * bad[:3, 1]
    else:
        row, column, value = how
        bad[row, column] = value
    return bad


NOT_FINITE = [(row, column, value) for row in range(4) for column in range(4) for value in (np.nan, np.inf, -np.inf)]


@pytest.mark.thinned
@pytest.mark.parametrize("how", ["scaled", "mirrored", "last row", "not orthogonal", *NOT_FINITE], ids=str)
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_no_pose_is_left_to_the_tasks(kind, how):
    targets, memory, stack = made(kind)
    bad = harmed(next(poses(1, 3)), how)
    refusal = refused(stack.read_target, bad)
    assert refused(targets.read, bad) == refusal
    # nothing of a refused target is left
    assert memory.tolist() == ([-7.0] * memory.size if refusal else stack.read_target(bad).tolist())


def refused(read, target):
    """The message with which a target is refused; None where it is read."""
    try:
        read(target)
    except jtik.ArgumentError as error:
        return str(error)
    return None


def test_a_vector_is_checked_by_read_only():
    targets, memory, _ = made("position", planar(3))
    with pytest.raises(jtik.ArgumentError):
        targets.read(np.array([np.nan, 1.0]))
    assert memory.tolist() == [-7.0, -7.0]
    targets.copy(np.array([np.nan, 1.0]))
    assert np.isnan(memory[0])


def test_a_solver_refuses_a_pose_with_nan_and_keeps_its_target():
    arm = dh_arm()
    ik = shared_solver(arm, jtik.FrameTask("tip", kind="pose"))
    T, q = arm.pose(arm.neutral + 0.3, "tip"), arm.neutral + 0.2
    first = ik.step(q, T)
    bad = T.copy()
    bad[1, 3] = np.nan
    for call in (lambda: ik.step(q, bad), lambda: ik.solve(bad, q0=q)):
        with pytest.raises(jtik.ArgumentError, match="target"):
            call()
    ik.reset()
    assert ik.step(q, T).q.tolist() == first.q.tolist()

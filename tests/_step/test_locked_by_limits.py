"""A joint whose lower limit is its upper limit: a step is made as if it were not there."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.constraints import Limits
from jtik_formulations import JointCentering

from ..conftest import large_ones_slow, planar, shared_solver

pytestmark = pytest.mark.thinned(together=True)

LOCKED, AT = 2, 0.4
LOWER, UPPER = np.full(5, -2.0), np.full(5, 2.0)
LOWER[LOCKED] = UPPER[LOCKED] = AT
STRATEGIES = ["hybrid", "damped", "newton", "newton+qp", "hybrid+qp", "newton+second_order", "task_priority", "sns_qp"]


def arms():
    """A planar arm with a locked joint, and one that has two links in one instead."""
    joined = planar(5, lower=-2.0, upper=2.0).subset(
        [f"joint{i + 1}" for i in range(5) if i != LOCKED], at=np.full(5, AT)
    )
    return jtik.Robot.planar(5, lower=LOWER, upper=UPPER), joined


@pytest.mark.parametrize("strategy", large_ones_slow(STRATEGIES))
@pytest.mark.parametrize("criteria", [None, JointCentering()], ids=["task", "criterion"])
def test_solves_converge_in_few_steps(strategy, criteria):
    robot, rng = arms()[0], np.random.default_rng(0)
    ik = shared_solver(robot, jtik.FrameTask("tip", "position"), criteria=criteria, strategy=strategy)
    steps = 0
    for _ in range(12):
        q0 = rng.uniform(-1, 1, 5)
        q0[LOCKED] = AT
        there = np.clip(q0 + 0.6, LOWER, UPPER)
        solution = ik.solve(robot.position(there, "tip"), q0=q0)
        assert solution.converged
        assert solution.q[LOCKED] == AT
        steps += solution.iterations
    assert steps < 250  # 157 to 1,185 before, 69 to 191 now


@pytest.mark.parametrize("strategy", ["hybrid", "newton+qp"])
def test_it_ends_where_the_arm_without_the_joint_ends(strategy):
    locked, joined = arms()
    task = jtik.FrameTask("tip", "position")

    @jtik.criterion
    def small(q, robot):
        return sum((robot.position(q, frame)[1] - 0.3) ** 2 for frame in ("link1", "link2", "tip"))

    q0 = np.array([0.5, 0.6, AT, -0.8, 0.4])
    one = shared_solver(locked, task, criteria=small, strategy=strategy, limits=True)
    other = shared_solver(joined, task, criteria=small, strategy=strategy, joints="all")
    found = one.solve([3.0, 1.0], q0=q0), other.solve([3.0, 1.0], q0=np.delete(q0, LOCKED))
    assert all(found)
    assert np.delete(found[0].q, LOCKED) == pytest.approx(found[1].q, abs=1e-4)
    assert found[0].cost == pytest.approx(found[1].cost, abs=1e-8)


def test_step_and_track_leave_it_where_it_is():
    robot = arms()[0]
    ik = shared_solver(robot, jtik.FrameTask("tip", "position"), limits=Limits(velocity=1.0))
    q = np.array([0.5, 0.6, AT, -0.8, 0.4])
    for dt in (None, 0.1):
        assert ik.step(q, [3.0, 1.0], dt=dt).q[LOCKED] == AT
    assert (ik.track([[3.0, 1.0], [3.0, 1.1]], q0=q).q[:, LOCKED] == AT).all()


def test_without_position_limits_it_moves():
    robot = arms()[0]
    ik = shared_solver(robot, jtik.FrameTask("tip", "position"), limits=False)
    assert ik.solve([3.0, 1.0], q0=np.array([0.5, 0.6, AT, -0.8, 0.4])).q[LOCKED] != AT


def test_other_robots_have_no_more_instructions():
    assert Limits().of(planar(4, lower=-2, upper=2)).locked == ()
    assert Limits().of(arms()[0]).locked == (LOCKED,)

"""Targets, starts and parameters as large as numbers can be: a status, and no warning, which is an error in tests."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering

from ..conftest import planar
from .conftest import solver

HUGE = [1e20, 1e100, 1e155, 1e200, 1e307]


def read(solution):
    """Everything that a Solution computes."""
    repr(solution)
    _ = solution.condition, solution.null_space_residual, solution.second_order, solution.relaxed
    assert np.isfinite(solution.q).all()
    return solution


@pytest.mark.parametrize("size", HUGE)
@pytest.mark.parametrize("criteria", [None, JointCentering()], ids=["task", "criterion"])
class TestTargets:
    q0 = (0.3, 0.2, 0.4)

    def test_solve(self, criteria, size):
        ik = solver(planar(3), criteria=criteria)
        for options in ({}, {"restarts": 2}, {"trace": True}, {"max_iterations": 0}):
            solution = read(ik.solve([size, 0.3 * size], q0=self.q0, **options))
            assert not solution
            assert solution.position_error == pytest.approx(np.hypot(1, 0.3) * size)
            assert np.isfinite(solution.report.relative_gradient).all()

    def test_step_track_and_batch(self, criteria, size):
        ik, targets = solver(planar(3), criteria=criteria), [[size, 0.0], [1.0, 1.0]]
        assert np.isfinite(ik.step(self.q0, targets[0]).q).all()
        assert np.isfinite(ik.step(self.q0, targets[0], dt=0.01).q).all()
        assert np.isfinite(ik.track(targets, q0=self.q0).q).all()
        batch = ik.solve_batch(targets, q0=self.q0)
        assert not batch[0]
        assert read(batch[1]).status is jtik.Status.CONVERGED

    def test_a_pose(self, criteria, size):
        target = np.eye(4)
        target[:2, 3] = size
        assert not read(solver(planar(3), kind="pose", criteria=criteria).solve(target, q0=self.q0))


@pytest.mark.parametrize("size", HUGE)
def test_starts_and_parameters(size):
    ik = solver(planar(3, lower=-2, upper=2), criteria=JointCentering())
    read(ik.solve([1.0, 1.0], q0=[size, 0.1, -size]))
    ik.parameters["joint_centering.weight"] = size
    read(ik.solve([1.0, 1.0], q0=[0.3, 0.2, 0.4]))


@pytest.mark.parametrize("size", [1e7, 1e10, *HUGE])
def test_a_restart_that_arrives_is_not_turned_so_far_that_rounding_moves_the_arm(size):
    arm = planar(3)
    ik, arrived = solver(arm), 0
    for seed in range(3):
        solution = read(ik.solve([1.5, 1.0], q0=[size, 0.3, -size], restarts=5, seed=seed))
        arrived += bool(solution)
        assert not solution or np.hypot(*(arm.position(solution.q, "tip")[:2] - [1.5, 1.0])) <= 1e-6
    assert arrived

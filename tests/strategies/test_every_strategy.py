"""The public contract, for every registered strategy: a new plugin is tested without editing tests."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.testing import check_strategy
from jtik_formulations import JointCentering

from ..conftest import families_first, shared_solver, slow

QUICK = ("hybrid", "transpose")


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", [*QUICK, *slow(*(name for name in jtik.strategies if name not in QUICK))])
def test_contract(name):
    check_strategy(name, samples=1)


@pytest.mark.quick(2)
@pytest.mark.parametrize("name", families_first([*sorted(jtik.strategies), "hybrid+qp"], large=False))
def test_an_arm_at_rest_at_the_minimum_of_H_follows_a_moving_target(name):
    """There grad H and all multipliers are zero, and every step to the target raises H."""
    arm = jtik.Robot.builtin("panda")
    ik = shared_solver(arm, jtik.FrameTask(arm.tip, kind="pose"), criteria=JointCentering(), strategy=name)
    q = home = np.array([0.0, -0.8, 0.0, -2.4, 0.0, 1.6, 0.8])
    ik.parameters["joint_centering.preferred"] = home
    target = arm.pose(home)
    for _ in range(3):
        assert np.abs(ik.step(q, target, dt=0.02).q - home).max() <= 1e-12
    for _ in range(20):
        target[0, 3] -= 0.002
        step = ik.step(q, target, dt=0.02)
        assert step.accepted
        q = step.q
    assert step.position_error <= 1e-2  # after 40 mm; the transpose step lags behind most

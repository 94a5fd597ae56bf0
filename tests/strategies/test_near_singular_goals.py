"""Targets whose posture has the wrist or the elbow nearly straight: what every default reaches, and what does not."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import ConstantDamped, JParse, Sugihara

from ..conftest import large_ones_slow, shared_solver

GOALS = 16
REACH_ALL = ("hybrid", "damped", "newton", "sugihara", "jparse", "selectively_damped", "weighted_least_norm")
"""Strategies of a single task, with the defaults."""


def goals():
    """An arm of seven joints, the middle of its limits, and poses with joint 4 or 6 between 0 and 0.01 rad."""
    robot, rng = jtik.Robot.builtin("iiwa14"), np.random.default_rng(0)
    found = []
    for k in range(GOALS):
        q = robot.random_configuration(rng)
        q[(3, 5)[k % 2]] = rng.choice([-1, 1]) * rng.uniform(0, 1e-2)
        found.append(robot.pose(q))
    return robot, (robot.lower + robot.upper) / 2, found


def arrivals(strategy):
    robot, start, targets = goals()
    ik = shared_solver(robot, jtik.FrameTask(robot.tip, kind="pose"), strategy=strategy)
    solutions = [ik.solve(target, q0=start, restarts=20, max_iterations=400) for target in targets]
    for solution, target in zip(solutions, targets, strict=True):
        if solution.converged:
            assert np.abs(robot.pose(solution.q) - target).max() < 3e-6
    return sum(each.converged for each in solutions)


@pytest.mark.quick(2)
@pytest.mark.parametrize("strategy", large_ones_slow(REACH_ALL))
def test_the_default_reaches_all_of_them(strategy):
    assert arrivals(strategy) == GOALS


@pytest.mark.parametrize("strategy", [Sugihara(bias=1e-3), ConstantDamped()])
def test_more_damping_does_not(strategy):
    """With more damping along the weak direction than its singular value squared, an attempt ends before it arrives."""
    assert arrivals(strategy) < 0.8 * GOALS


@pytest.mark.slow
def test_a_large_threshold_does_not():
    assert arrivals(JParse(threshold=0.1)) < 0.8 * GOALS

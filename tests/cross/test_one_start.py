"""How often a solve reaches its goal from one start, beside plain damped loops that wrap."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jtik

from ..conftest import dh_arm, shared_solver

TOLERANCE = 1e-6
ITERATIONS = 200
GOALS = 100
QUARTER = math.pi / 2
UNIVERSAL = {
    "ur5": ([0, -0.425, -0.39225, 0, 0, 0], [0.089159, 0, 0, 0.10915, 0.09465, 0.0823]),
    "ur10": ([0, -0.612, -0.5723, 0, 0, 0], [0.1273, 0, 0, 0.163941, 0.1157, 0.0922]),
}
"""Link lengths and offsets a and d of the Denavit-Hartenberg tables of the manufacturer [m]."""

DAMPINGS = (0.1, 0.01)
"""Damping of the plain loops relative to V [1 / rad^2]."""


def universal(name, limit):
    """An arm of Universal Robots with limits of plus and minus ``limit`` [rad]."""
    rows = zip(*UNIVERSAL[name], [QUARTER, 0, 0, QUARTER, -QUARTER, 0], strict=True)
    limits = {"theta": 0.0, "lower": -limit, "upper": limit}
    return jtik.Robot.from_dh([{"a": a, "d": d, "alpha": alpha, **limits} for a, d, alpha in rows], name=name)


ARMS = {
    "ur5, one turn": functools.partial(universal, "ur5", math.pi),
    "ur10, two turns": functools.partial(universal, "ur10", 2 * math.pi),
    **{f"random {seed}": functools.partial(dh_arm, 6, seed, limit=math.pi) for seed in range(2)},
}


def error(pose, target):
    """Position and rotation vector of a pose from its target, in the base frame."""
    turn = Rotation.from_matrix(pose[:3, :3] @ target[:3, :3].T).as_rotvec()
    return np.concatenate([pose[:3, 3] - target[:3, 3], turn])


def reached(e):
    return max(np.linalg.norm(e[:3]), np.linalg.norm(e[3:])) <= TOLERANCE


def plain_loop(robot, q, target, damping):
    """Damped least squares without limits, every step taken: whether it arrives. Whole turns make no difference."""
    for _ in range(ITERATIONS):
        e, J = error(robot.pose(q), target), robot.jacobian(q)
        if reached(e):
            return True
        q = q - J.T @ np.linalg.solve(J @ J.T + (damping * (e @ e) / 2 + 1e-16) * np.eye(6), e)
    return False


def arrives(ik, q0, target):
    """Whether a solve arrives, within the limits."""
    robot = ik.robot
    solution = ik.solve(target, q0=q0, max_iterations=ITERATIONS)
    within = (solution.q >= robot.lower).all() and (solution.q <= robot.upper).all()
    assert solution.converged == (within and reached(error(robot.pose(solution.q), target)))
    return solution.converged


def problems(robot, count):
    """Uniform starts within the limits, and the poses of such configurations."""
    rng = np.random.default_rng(1)
    pairs = rng.uniform(robot.lower, robot.upper, (count, 2, robot.n))
    return [(start, robot.pose(goal)) for start, goal in pairs]


@pytest.mark.quick(0, slow=2)
@pytest.mark.parametrize("arm", ARMS)
def test_at_least_as_often_as_a_plain_damped_loop_that_wraps(arm):
    robot = ARMS[arm]()
    given = problems(robot, GOALS)
    plain = max(sum(plain_loop(robot, *each, damping) for each in given) for damping in DAMPINGS)
    for strategy in ("hybrid", "damped"):
        ik = shared_solver(robot, jtik.FrameTask(kind="pose"), strategy=strategy)
        assert sum(arrives(ik, *each) for each in given) >= plain, strategy


@pytest.mark.slow
@pytest.mark.parametrize("strategy", ["hybrid", "damped"])
def test_a_ur5_needs_five_searches_for_four_goals_at_most(strategy):
    """From one list of starts for all goals; with ``restarts=`` attempts are shorter, and a few more of them begin."""
    robot = universal("ur5", math.pi)
    ik = shared_solver(robot, jtik.FrameTask(kind="pose"), strategy=strategy)
    starts, searches, iterations = [q for q, _ in problems(robot, 100)], 0, 0
    attempts = 0
    goals = [target for _, target in problems(robot, 200)]
    for target in goals:
        for q0 in starts:
            searches += 1
            if arrives(ik, q0, target):
                break
        else:
            pytest.fail("no start leads to the goal")
        solution = ik.solve(target, q0=starts[0], restarts=99)
        iterations, attempts = iterations + solution.iterations, attempts + solution.restarts + 1
    assert searches <= 1.25 * len(goals)
    assert attempts <= 1.5 * len(goals)
    assert iterations <= 27 * len(goals)

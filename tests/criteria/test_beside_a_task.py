"""Each criterion beside a task: derivatives, and solves from a feasible start with the main strategies.

Each criterion on one robot with one strategy, in turn: ``--full`` runs it on every robot.
"""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import jtik

from .cases import CASES
from .derivatives import ROBOTS, assert_derivatives

STRATEGIES = ("hybrid", "hybrid+qp", "hybrid+second_order")
TOLERANCE = 1e-6
"""Default tolerance of the solver [m] and [rad]."""

RISE = 1e-6
"""Relative rise of H that the tolerance of the task permits."""

STARTS = 2

SQUARE = [
    (name, robot, STRATEGIES[(row + column) % len(STRATEGIES)])
    for row, name in enumerate(CASES)
    for column, robot in enumerate(ROBOTS)
]
"""A Latin square: each criterion on every robot and with every strategy, and each strategy on every robot. All triples,
and all strategies: benchmarks/criteria_matrix.py."""


QUICK = ("manipulability volume", "support_polygon")


@pytest.mark.quick(1)
@pytest.mark.thinned
@pytest.mark.parametrize(
    ("name", "robot"),
    [
        pytest.param(name, robot, marks=[] if robot == "ten" and name in QUICK else pytest.mark.slow)
        for name in CASES
        for robot in ("ten", "vehicle")  # a Panda on a vehicle
    ],
)
def test_derivatives(name, robot):
    body = ROBOTS[robot]()
    assert_derivatives(CASES[name](body), body)


@pytest.mark.quick(8)
@pytest.mark.parametrize("name", CASES)
def test_it_is_pickled(name):
    body = ROBOTS["panda"]()
    criterion = CASES[name](body)
    copied = pickle.loads(pickle.dumps(criterion))
    q = body.random_configuration(1)
    assert copied(q, body) == criterion(q, body)
    assert repr(copied) == repr(criterion)


@pytest.mark.slow
@pytest.mark.thinned
@pytest.mark.parametrize(("name", "robot", "strategy"), SQUARE)
def test_a_solve_from_a_feasible_start_ends_stationary_on_the_target(name, robot, strategy):
    body = ROBOTS[robot]()
    task = jtik.FrameTask(body.tip, "position" if robot == "ten" else "pose")
    ik = jtik.InverseKinematics(body, task, criteria=CASES[name](body), strategy=strategy)
    for seed in range(STARTS):
        q0 = body.random_configuration(seed)
        target = body.pose(q0)
        before = ik.solve(target, q0=q0, max_iterations=0).cost
        solution = ik.solve(target, q0=q0, until="stationary", max_iterations=5000)
        assert solution.position_error <= TOLERANCE
        assert robot == "ten" or solution.orientation_error <= TOLERANCE
        assert np.all((solution.q >= body.lower - 1e-12) & (solution.q <= body.upper + 1e-12))
        assert solution.cost <= before + RISE * max(1.0, abs(before))
        assert solution.status is jtik.Status.CONVERGED, (seed, solution)

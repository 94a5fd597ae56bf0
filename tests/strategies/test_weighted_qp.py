"""One quadratic program a step: its solution in closed form and by SciPy, the final compromise, refused options."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import lsq_linear

import jtik
from jtik_formulations import JointCentering, WeightedQP

from ..conftest import ball_arm, dh_arm, planar, report_at

BARE = {"backtracking": False, "q_limit": math.inf}

SOLVED = 1e-9
"""Accuracy of DAQP divided by the smallest curvature of these quadratic programs."""


def solver(robot, strategy, kind="position", criteria=None, **options):
    return jtik.InverseKinematics(robot, jtik.FrameTask("tip", kind), criteria=criteria, strategy=strategy, **options)


def oracle(strategy, seen, gradient, low, high):
    """The same QP as bounded linear least squares: rows of the task, of the damping and of the criterion."""
    J, r = seen.jacobian, seen.error
    mu = strategy.damping + strategy.lm_damping * strategy.gain**2 * r @ r
    P = J.T @ J + mu * np.eye(J.shape[1])
    q = strategy.gain * J.T @ r
    if gradient is not None:
        P, q = P + strategy.weight * strategy.curvature * np.eye(len(q)), q + strategy.weight * gradient
    root = np.linalg.cholesky(P).T
    return lsq_linear(root, -np.linalg.solve(root.T, q), (low, high), tol=1e-15, lsmr_tol=1e-15).x


@pytest.mark.parametrize("gain", [1.0, 0.4])
@pytest.mark.parametrize("with_criterion", [False, True])
def test_a_step_is_the_minimum_of_the_weighted_sum(gain, with_criterion, rng):
    strategy = WeightedQP(gain=gain, lm_damping=0.3, damping=1e-3, weight=0.02, curvature=1.7, **BARE)
    criteria = JointCentering() if with_criterion else None
    for robot, kind in ((planar(6), "position"), (dh_arm(7, 2), "pose"), (dh_arm(4, 1), "pose")):
        ik = solver(robot, strategy, kind, criteria=criteria)
        for _ in range(5):
            q = rng.uniform(-1, 1, robot.n)
            target = robot.pose(q + rng.uniform(-0.2, 0.2, robot.n))
            seen = report_at(ik, q, target)
            J, e = seen.jacobian, seen.error
            damping = (
                strategy.damping
                + strategy.lm_damping * gain**2 * e @ e
                + with_criterion * strategy.weight * strategy.curvature
            )
            gradient = gain * J.T @ e + with_criterion * strategy.weight * seen.gradient
            ik.reset()
            dq = ik.step(q, target).q - q
            assert dq == pytest.approx(-np.linalg.solve(J.T @ J + damping * np.eye(robot.n), gradient), abs=SOLVED)


@pytest.mark.parametrize("pose", ["generic", "at a limit", "straight at a limit"])
def test_limits_are_its_box(pose, rng):
    """Compared with SciPy's bounded least squares; the step limit is part of the same box."""
    robot = planar(6, lower=-0.5, upper=0.5)
    strategy = WeightedQP(lm_damping=0.1, damping=1e-3, weight=0.05, q_limit=0.2, backtracking=False)
    ik = solver(robot, strategy, criteria=JointCentering(preferred=np.full(6, 0.3)))
    active = 0
    for _ in range(10):
        q = {
            "generic": lambda: rng.uniform(-0.5, 0.5, 6),
            "at a limit": lambda: rng.choice([-0.5, 0.1, 0.5], 6),
            "straight at a limit": lambda: np.append(0.5, np.zeros(5)),
        }[pose]()
        target = rng.uniform(-4, 4, 2)
        seen = report_at(ik, q, target)
        low, high = np.maximum(-0.5 - q, -0.2), np.minimum(0.5 - q, 0.2)
        apart = np.where(high - low < 1e-12, 1e-12, 0)
        ik.reset()
        dq = ik.step(q, target).q - q
        assert dq == pytest.approx(oracle(strategy, seen, seen.gradient, low - apart, high + apart), abs=1e-7)
        assert (dq >= low - 1e-15).all()
        assert (dq <= high + 1e-15).all()
        active += int(((dq < low + 1e-12) | (dq > high - 1e-12)).sum())
    assert active  # the box mattered


@pytest.mark.parametrize("weight", [1e-2, 1e-3, 1e-4])
def test_it_ends_where_task_and_criterion_pull_equally(weight):
    """J' r + weight grad H = 0: the error is weight times the multiplier of the task, and the solve fails."""
    strategy = WeightedQP(weight=weight)
    ik = solver(planar(5), strategy, criteria=JointCentering())
    solution = ik.solve([2.0, 1.5], q0=[0.3] * 5)
    balance = solution.jacobian.T @ solution.error + weight * solution.gradient
    assert np.linalg.norm(balance) <= 1e-4 * weight * np.linalg.norm(solution.gradient)
    multiplier = np.linalg.lstsq(solution.jacobian.T, solution.gradient, rcond=None)[0]
    assert solution.error == pytest.approx(-weight * multiplier, rel=1e-3)
    assert solution.status is jtik.Status.STALLED
    assert not solution.converged


def test_the_weighted_sum_falls_at_every_step_taken(rng):
    strategy = WeightedQP(weight=1e-3, curvature=0.2)
    for robot, kind in ((planar(8), "position"), (dh_arm(7, 1), "pose"), (ball_arm(), "position")):
        ik = solver(robot, strategy, kind, criteria=JointCentering())
        for _ in range(5):
            q = robot.random_configuration(rng)
            target = robot.pose(robot.random_configuration(rng))
            trace = ik.solve(target, q0=q, max_iterations=60, trace=True).trace
            total = trace.V + strategy.weight * trace.H
            assert (np.diff(total) <= 1e-13 * total[:-1]).all()


@pytest.mark.parametrize("bend", [0.0, 1e-9, 1e-6, 1e-3])
def test_a_straight_arm_is_pulled_inwards(bend):
    solution = solver(planar(5), "weighted_qp").solve([3.0, 0.0], q0=bend * np.array([0.0, 1.0, -1.0, 1.0, 1.0]))
    assert solution.converged


@pytest.mark.parametrize(
    "options",
    [
        {"gain": 0.0},
        {"gain": 1.5},
        {"lm_damping": -1.0},
        {"damping": 0.0},
        {"weight": -1.0},
        {"weight": math.inf},
        {"curvature": 0.0},
        {"q_limit": math.nan},
    ],
)
def test_options_out_of_range_are_refused(options):
    with pytest.raises(jtik.ArgumentError, match=next(iter(options))):
        WeightedQP(**options)

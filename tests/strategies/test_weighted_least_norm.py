"""Weighted least norm: its steps compared with NumPy, its memory of the direction of motion, and its purpose."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik_formulations import Newton, WeightedLeastNorm

from ..conftest import planar, planar_jacobian, planar_points, shared_solver

BARE = {"backtracking": False, "q_limit": math.inf}


def gradients(q, lower, upper):
    """|dH/dq| by Chan and Dubey's (14), for joints with two limits."""
    with np.errstate(divide="ignore", invalid="ignore"):
        gradient = np.abs((upper - lower) ** 2 * (2 * q - upper - lower) / (4 * (upper - q) ** 2 * (q - lower) ** 2))
    return np.where(np.isfinite(upper - lower), gradient, 0)


def expected(J, e, weights):
    """argmin dq' W dq of J dq = -e, by its optimality conditions."""
    n, m = J.shape[1], len(e)
    system = np.block([[np.diag(weights), J.T], [J, np.zeros((m, m))]])
    return np.linalg.solve(system, np.concatenate([np.zeros(n), -e]))[:n]


def replayed(q, target, lower, upper, count, most=1e4):
    before, visited = np.zeros(len(q)), [q]
    for _ in range(count):
        gradient = gradients(q, lower, upper)
        weights = np.where(gradient >= before, np.minimum(1 + gradient, most), 1)
        before = gradient
        q = q + expected(planar_jacobian(q), planar_points(q)[-1] - target, weights)
        visited.append(q)
    return np.array(visited)


@pytest.mark.parametrize("most", [1e4, 3.0])
def test_the_steps_of_a_whole_solve(most, rng):
    """Weights change with the direction of motion: each step is compared, the last ones to the growth of rounding."""
    robot = planar(5, lower=-2.0, upper=2.0)
    strategy = WeightedLeastNorm(max_weight=most, **BARE)
    ik = shared_solver(robot, jtik.FrameTask("tip"), strategy=strategy)
    freed = 0
    for _ in range(20):
        q0 = rng.uniform(-0.9, 0.9, 5)
        target = planar_points(q0 + rng.uniform(-0.5, 0.5, 5))[-1]
        visited = ik.solve(target, q0=q0, max_iterations=4, position_tolerance=1e-14, trace=True).trace.q
        wanted = replayed(q0, target, -2.0, 2.0, len(visited) - 1, most)
        assert np.abs(wanted).max() < 2.0
        assert visited == pytest.approx(wanted, abs=1e-7)
        growth = np.diff([gradients(q, -2.0, 2.0) for q in visited], axis=0)
        freed += (growth < 0).sum()
    assert freed > 20


@pytest.mark.parametrize("inside", [0.0, 1e-9, 1e-6, 1e-3, 5e-3])
def test_a_joint_that_leaves_its_limit_is_free_in_the_second_step(inside, rng):
    """Its derivative is still above the largest weight."""
    robot = planar(5, lower=-2.0, upper=2.0)
    ik = shared_solver(robot, jtik.FrameTask("tip"), strategy=WeightedLeastNorm(**BARE))
    q = np.array([0.3, 2.0 - inside, -0.6, 0.4, 0.5])
    # the tip moves as by this joint alone, inwards: with its weight it takes a small share of that
    slow = planar_points(q)[-1] + planar_jacobian(q) @ np.array([0.0, -50.0, 0.0, 0.0, 0.0]) * 1e-4
    ik.reset()
    first = ik.step(q, slow).q
    assert 2.0 - inside > first[1] > 2.0 - 1e-2
    far = planar_points(first)[-1] + 0.2 * rng.standard_normal(2)
    gradient, before = gradients(first, -2.0, 2.0), gradients(q, -2.0, 2.0)
    assert gradient[1] > 1e4
    weights = 1 + np.where(gradient >= before, gradient, 0)
    wanted = expected(planar_jacobian(first), planar_points(first)[-1] - far, weights)
    assert ik.step(first, far).q == pytest.approx(np.clip(first + wanted, -2.0, 2.0), abs=1e-9)


@pytest.mark.parametrize("bend", [1.0, 1e-3, 1e-6])
def test_near_singular_poses_the_weighted_pseudo_inverse_is_the_same(bend, rng):
    robot = planar(4, lower=-1.5, upper=1.5)
    ik = shared_solver(robot, jtik.FrameTask("tip"), strategy=WeightedLeastNorm(**BARE))
    q = np.append(0.4, bend * np.array([1.0, -0.6, 0.8]))
    J, p = planar_jacobian(q), planar_points(q)[-1]
    target = p + J @ (1e-2 * rng.uniform(-1, 1, 4))
    wanted = expected(J, p - target, 1 + gradients(q, -1.5, 1.5))
    ik.reset()
    assert ik.step(q, target).q - q == pytest.approx(wanted, rel=1e-5, abs=1e-9)


def test_a_straight_arm_makes_the_motion_that_is_possible():
    """Only motion across the arm is possible: the step makes it, weighted, and the rest of the error remains."""
    robot = planar(3, lower=-1.5, upper=1.5)
    ik = shared_solver(robot, jtik.FrameTask("tip"), strategy=WeightedLeastNorm(**BARE))
    q = np.array([1.0, 0.0, 0.0])
    along, across = np.array([np.cos(1.0), np.sin(1.0)]), np.array([-np.sin(1.0), np.cos(1.0)])
    target = planar_points(q)[-1] + 0.3 * across - 0.2 * along
    weights = 1 + gradients(q, -1.5, 1.5)
    reach = across @ planar_jacobian(q)
    wanted = 0.3 * (reach / weights) / (reach @ (reach / weights))
    assert ik.step(q, target).q - q == pytest.approx(wanted, abs=1e-12)


def test_joints_without_two_limits_weigh_one(rng):
    """Without limits it is Newton's method; one-sided limits count as none."""
    q, target = rng.uniform(0.2, 0.8, 4), np.array([2.0, 1.5])
    steps = [
        shared_solver(robot, jtik.FrameTask("tip"), strategy=strategy).step(q, target).q
        for robot, strategy in [
            (planar(4), Newton(**BARE)),
            (planar(4), WeightedLeastNorm(**BARE)),
            (jtik.Robot.planar(4, lower=-2.0, upper=np.inf), WeightedLeastNorm(**BARE)),
        ]
    ]
    assert steps[1] == pytest.approx(steps[0], abs=1e-12)
    assert steps[2] == pytest.approx(steps[0], abs=1e-12)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("inside", [0.0, 1e-12, 1e-6])
def test_a_joint_at_or_next_to_its_limit_can_leave_it(side, inside):
    """Also where the task cannot do without it: two joints, one target."""
    robot = planar(2, lower=-1.5, upper=1.5)
    ik = shared_solver(robot, jtik.FrameTask("tip"), strategy="weighted_least_norm")
    goal = side * np.array([0.3, 0.7])
    solution = ik.solve(robot.pose(goal), q0=side * np.array([0.1, 1.5 - inside]), max_iterations=100)
    assert solution.converged
    assert solution.q == pytest.approx(goal, abs=1e-5)


def test_it_mostly_keeps_joints_further_from_their_limits_than_newton(rng):
    robot, margins = planar(6, lower=-1.2, upper=1.2), {}
    problems = [(rng.uniform(-0.4, 0.4, 6), robot.pose(rng.uniform(-1, 1, 6))) for _ in range(60)]
    for name in ("newton", "weighted_least_norm"):
        ik = shared_solver(robot, jtik.FrameTask("tip"), strategy=name)
        solutions = [ik.solve(target, q0=q0) for q0, target in problems]
        assert sum(s.converged for s in solutions) >= 55
        margins[name] = np.array([1.2 - np.abs(s.q).max() for s in solutions])
    further = margins["weighted_least_norm"] > margins["newton"] + 1e-6
    assert further.mean() > 0.7
    assert margins["weighted_least_norm"].mean() > 1.05 * margins["newton"].mean()


@pytest.mark.parametrize(("option", "value"), [("max_weight", 0.5), ("max_weight", math.inf), ("q_limit", 0.0)])
def test_options_are_checked(option, value):
    with pytest.raises(jtik.ArgumentError, match=option):
        WeightedLeastNorm(**{option: value})


@pytest.mark.parametrize("limits", [True, jtik.Limits(velocity=5.0, acceleration=500.0)])
def test_a_timed_step_weighs_by_the_position_limits(limits, rng):
    """The limits of the step itself, about a thousandth of a radian around it, say nothing about where a joint is."""
    ik = shared_solver(
        planar(5, lower=-2.0, upper=2.0), jtik.FrameTask("tip"), strategy="weighted_least_norm", limits=limits
    )
    for _ in range(5):
        q = rng.uniform(-1.9, 1.9, 5)
        motion = 1e-6 * rng.standard_normal(2)
        ik.reset()
        wanted = expected(planar_jacobian(q), -motion, 1 + gradients(q, -2.0, 2.0))
        found = ik.step(q, planar_points(q)[-1] + motion, dt=0.002).q - q
        assert found == pytest.approx(wanted, abs=1e-3 * np.abs(wanted).max())

"""Joint limits: kept at every iterate, no obstacle to the other joints, and named where they prevent a target.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import ACCEPTED_RISE, families_first, planar, planar_points, rises, shared_solver, under_limits

pytestmark = pytest.mark.thinned(together=True, times=3)

NAMES = sorted(jtik.strategies)
STRATEGIES = families_first(NAMES)


def solver(robot, strategy="hybrid", kind="position", **options):
    return shared_solver(robot, jtik.FrameTask("tip", kind), strategy=strategy, **options)


def limited_dh(rng, n):
    rows = [
        {
            "a": rng.uniform(0.1, 0.4),
            "alpha": rng.uniform(-1.6, 1.6),
            "d": rng.uniform(0, 0.3),
            "joint": "prismatic" if rng.random() < 0.2 else "revolute",
            "lower": -rng.uniform(0.1, 1.5),
            "upper": rng.uniform(0.1, 1.5),
        }
        for _ in range(n)
    ]
    return jtik.Robot.from_dh(rows)


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize(
    ("seed", "criteria"),
    [(1, True), *(pytest.param(*case, marks=pytest.mark.slow) for case in [(0, False), (3, True)])],
)
def test_no_iterate_is_outside(strategy, criteria, seed):
    """Starts inside, at and outside the limits; targets within reach and out of it; some joints without limits."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 8))
    if seed % 2:
        robot, kind = limited_dh(rng, n), ("position", "pose")[seed // 2]
    else:
        lower, upper = -rng.uniform(0.05, 1, n), rng.uniform(0.05, 1, n)
        lower[rng.random(n) < 0.2] = -np.inf
        upper[rng.random(n) < 0.2] = np.inf
        robot, kind = jtik.Robot.planar(n, lower=lower, upper=upper), "position"
    obstacle = jtik.Point(rng.uniform(-2, 2, robot.dimension))
    terms = JointCentering() + 0.1 * ObstacleAvoidance(obstacle) if criteria else None
    ik = solver(robot, strategy, kind, criteria=terms)
    for trial in range(12):
        q0 = robot.random_configuration(rng)
        if trial % 3 == 1:
            at = rng.random(n) < 0.5
            q0[at] = np.where(np.isfinite(robot.upper[at]), robot.upper[at], q0[at])
            at = rng.random(n) < 0.3
            q0[at] = np.where(np.isfinite(robot.lower[at]), robot.lower[at], q0[at])
        elif trial % 3 == 2:
            q0 = q0 + rng.uniform(-3, 3, n)
        target = robot.pose(robot.random_configuration(rng))
        if trial % 4 == 3:
            target[:2, 3] += 3.0
        trace = ik.solve(target, q0=q0, max_iterations=150, trace=True).trace
        rows = under_limits(robot, trace.q)[1:]
        assert (rows >= robot.lower).all()
        assert (rows <= robot.upper).all()


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_a_start_outside_is_clamped_to_the_limits(strategy):
    robot = jtik.Robot.planar(4, lower=-1.0, upper=1.0)
    q0 = np.array([1.7, -0.2, 0.4, -2.5])
    target = robot.position([0.8, 0.3, 0.2, -0.5])
    ik = solver(robot, strategy)
    options = {"max_iterations": 5000, "position_tolerance": 1e-4}
    outside = ik.solve(target, q0=q0, **options)
    inside = ik.solve(target, q0=np.clip(q0, -1, 1), **options)
    assert outside.converged
    assert outside.q.tolist() == inside.q.tolist()
    assert (np.abs(ik.step(q0, target).q) <= 1).all()


@pytest.mark.parametrize("options", [{"max_iterations": 0}, {"until": "reached"}, {}])
def test_even_a_solve_without_a_step_ends_inside(options):
    """Its solution can be sent to a robot."""
    robot = jtik.Robot.planar(3, lower=-1.0, upper=1.0)
    solution = solver(robot).solve(robot.position([1.0, 0.5, 0.2]), q0=[1.4, 0.5, 0.2], **options)
    assert solution.q.tolist() == [1.0, 0.5, 0.2]


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize(
    ("blocked", "side"), [(1, -1), *(pytest.param(*case, marks=pytest.mark.slow) for case in [(0, 1), (3, 1)])]
)
def test_a_joint_at_its_limit_does_not_freeze_the_others(strategy, blocked, side):
    """The first step would push the joint out; the target is within reach of the others alone."""
    start = np.array([0.3, 0.5, 0.4, 0.6]) * -side
    free = np.delete(np.arange(4), blocked)
    J = planar(4).jacobian(start)[:2]
    wanted = np.zeros(4)
    wanted[free] = 0.15 * side
    target = planar_points(start + wanted)[-1]
    push = -J.T @ (planar_points(start)[-1] - target)
    lower, upper = np.full(4, -3.0), np.full(4, 3.0)
    (upper if push[blocked] > 0 else lower)[blocked] = start[blocked]
    robot = jtik.Robot.planar(4, lower=lower, upper=upper)
    solution = solver(robot, strategy).solve(target, q0=start, max_iterations=5000, position_tolerance=1e-4, trace=True)
    assert solution.converged
    assert (solution.trace.q[1:] >= lower).all()
    assert (solution.trace.q[1:] <= upper).all()


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_a_joint_can_move_away_from_its_limit(strategy):
    """At its limit at first, needed inside it later: the last joint has to fold back."""
    robot = jtik.Robot.planar(3, lower=-1.5, upper=1.5)
    q0 = np.array([0.2, 0.3, 1.5])
    goal = np.array([0.9, -0.4, 0.3])
    solution = solver(robot, strategy).solve(robot.position(goal), q0=q0, max_iterations=5000, position_tolerance=1e-4)
    assert solution.converged


def check_V_falls(seed, strategy):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 7))
    robot = jtik.Robot.planar(n, lower=-rng.uniform(0.1, 1, n), upper=rng.uniform(0.1, 1, n))
    q0 = robot.random_configuration(rng)
    at = rng.random(n) < 0.4
    q0[at] = robot.upper[at]
    target = robot.position(robot.random_configuration(rng)) + rng.uniform(-0.5, 0.5, 2)
    trace = solver(robot, strategy).solve(target, q0=q0, max_iterations=100, trace=True).trace
    if len(trace):
        assert rises(trace).max(initial=-1) <= ACCEPTED_RISE


MONOTONE = [name for name in NAMES if name != "mink"]


@pytest.mark.slow
@settings(deadline=None, max_examples=8)
@given(st.integers(0, 2**32 - 1), st.sampled_from(MONOTONE))
def test_V_falls_at_every_accepted_step_between_limits(seed, strategy):
    check_V_falls(seed, strategy)


@pytest.mark.slow
@settings(deadline=None, max_examples=20)
@given(st.integers(0, 2**32 - 1), st.sampled_from(MONOTONE))
def test_V_falls_at_every_accepted_step_between_many_limits(seed, strategy):
    check_V_falls(seed, strategy)


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_limits_that_prevent_the_target_are_named(strategy):
    robot = jtik.Robot.planar(2, lower=[-0.2, 0.1], upper=[0.2, 0.4])
    solution = solver(robot, strategy).solve([0.5, 1.5], q0=[0.0, 0.2], max_iterations=5000)
    assert solution.status is jtik.Status.LIMITS
    assert not solution.converged
    assert solution.active_limits == ("joint1", "joint2")
    assert solution.q == pytest.approx([0.2, 0.4], abs=1e-9)
    assert "limit" in repr(solution)
    assert "joint1, joint2" in repr(solution)


def test_the_error_at_limits_is_that_of_a_bounded_optimiser(rng):
    limited = 0
    for _ in range(15):
        robot = jtik.Robot.planar(3, lower=-0.4, upper=0.4)
        target = planar_points(rng.uniform(-1.5, 1.5, 3))[-1]
        q0 = rng.uniform(-0.3, 0.3, 3)
        solution = solver(robot).solve(target, q0=q0)
        best = min(
            minimize(
                lambda q, t=target: np.sum((planar_points(q)[-1] - t) ** 2) / 2,
                start,
                bounds=[(-0.4, 0.4)] * 3,
                method="L-BFGS-B",
                options={"ftol": 1e-15, "gtol": 1e-10},
            ).fun
            for start in (q0, solution.q)
        )
        assert solution.position_error**2 / 2 <= best + 1e-6
        if solution.position_error > 1e-3:
            limited += 1
            assert solution.status in (jtik.Status.LIMITS, jtik.Status.LOCAL_MINIMUM)
            assert solution.active_limits
    assert limited >= 3


def test_joints_at_a_limit_are_named_on_success_too():
    robot = jtik.Robot.planar(3, lower=-0.5, upper=0.5)
    aim = np.array([0.5, -0.2, 0.3])
    solution = solver(robot, criteria=JointCentering(preferred=[2.0, -0.2, 0.3])).solve(robot.position(aim), q0=aim)
    assert solution.status is jtik.Status.CONVERGED
    assert solution.active_limits == ("joint1",)


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_a_joint_with_equal_limits_stays_and_the_others_move(strategy):
    robot = jtik.Robot.planar(4, lower=[-2.0, 0.3, -2.0, -2.0], upper=[2.0, 0.3, 2.0, 2.0])
    solution = solver(robot, strategy).solve(
        [2.0, 1.5], q0=[0.2, 0.3, 0.4, 0.1], max_iterations=5000, position_tolerance=1e-4
    )
    assert solution.converged
    assert solution.q[1] == 0.3


def test_equal_limits_of_all_joints_end_at_once():
    robot = jtik.Robot.planar(2, lower=[0.2, 0.3], upper=[0.2, 0.3])
    solution = solver(robot, criteria=JointCentering()).solve([1.0, 1.0])
    assert solution.q.tolist() == [0.2, 0.3]
    assert solution.status is jtik.Status.LIMITS

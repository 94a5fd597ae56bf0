"""Damped least squares: the step as defined, its bound near singular poses, and the mode without backtracking."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik_formulations import Damped, JointCentering

from ..conftest import EXACT, ball_arm, dh_arm, floating_arm, planar, planar_jacobian, planar_points, shared_solver

BARE = {"backtracking": False, "q_limit": math.inf}


def solver(robot, strategy, kind="position", **options):
    return shared_solver(robot, jtik.FrameTask("tip", kind), strategy=strategy, limits=False, **options)


@pytest.mark.thinned
@pytest.mark.parametrize("damping", [1e-3, 0.1, 10.0])
@pytest.mark.parametrize("n", [2, 3, 10])
def test_the_step_minimises_error_and_length_together(n, damping, rng):
    """Against ordinary least squares of the stacked system [J; sqrt(mu) I] p = [r; 0]."""
    ik = solver(planar(n), Damped(damping=damping, **BARE))
    for _ in range(20):
        q, target = rng.uniform(-1, 1, n), rng.uniform(-2, 2, 2)
        J, e = planar_jacobian(q), planar_points(q)[-1] - target
        stacked = np.vstack([J, math.sqrt(damping * e @ e / 2) * np.eye(n)])
        p = np.linalg.lstsq(stacked, np.concatenate([e, np.zeros(n)]), rcond=None)[0]
        assert ik.step(q, target).q - q == pytest.approx(-p, rel=1e-9, abs=1e-11)


@pytest.mark.thinned
@pytest.mark.parametrize("name", ["dh6", "dh9", "ball", "floating"])
@pytest.mark.parametrize("kind", ["position", "orientation", "pose"])
def test_in_space_and_on_manifolds_too(name, kind, rng):
    robot = {
        "dh6": lambda: dh_arm(6, 1),
        "dh9": lambda: dh_arm(9, 1),
        "ball": ball_arm,
        "floating": floating_arm,
    }[name]()
    ik = solver(robot, Damped(**BARE), kind)
    for _ in range(5):
        q = robot.random_configuration(rng)
        target = robot.pose(robot.integrate(q, rng.uniform(-0.05, 0.05, robot.n)))
        seen = ik.solve(target, q0=q, max_iterations=0)
        J, e = seen.jacobian, seen.error
        dq = -J.T @ np.linalg.solve(J @ J.T + 0.1 * (e @ e / 2) * np.eye(len(e)), e)
        assert robot.difference(q, ik.step(q, target).q) == pytest.approx(dq, rel=1e-7, abs=1e-10)


@pytest.mark.parametrize("bend", [0.0, 1e-12, 1e-8, 1e-4])
def test_steps_are_bounded_at_and_near_singular_poses(bend):
    """|p| <= |r| / (2 sqrt(mu)), where Newton's step grows like 1 / bend."""
    ik, q = solver(planar(4), Damped(damping=0.1, **BARE)), np.array([0.0, bend, -bend, bend])
    target = np.array([3.5, 0.3])
    e = planar_points(q)[-1] - target
    length = np.linalg.norm(ik.step(q, target).q - q)
    assert 0 < length <= np.linalg.norm(e) / (2 * math.sqrt(0.1 * e @ e / 2)) * (1 + 1e-9)


def test_the_q_limit_shortens_the_whole_step():
    q, target = np.array([0.3, 0.4, 0.5]), np.array([-1.0, -1.0])
    full = solver(planar(3), Damped(**BARE)).step(q, target).q - q
    short = solver(planar(3), Damped(backtracking=False, q_limit=0.2)).step(q, target).q - q
    assert np.linalg.norm(short) == pytest.approx(0.2)
    assert short / 0.2 == pytest.approx(full / np.linalg.norm(full), abs=EXACT)


@pytest.mark.parametrize("backtracking", [True, False])
def test_convergence_is_quadratic_at_the_target(backtracking):
    robot = dh_arm(7, 2)
    q = np.full(7, 0.4)
    trace = (
        solver(robot, Damped(backtracking=backtracking), "pose")
        .solve(robot.pose(q), q0=q + 0.1, position_tolerance=1e-13, orientation_tolerance=1e-13, trace=True)
        .trace
    )
    ahead, behind = trace.error[1:], trace.error[:-1]
    close = (behind < 1e-1) & (behind > 1e-6)
    assert close.sum() >= 2
    assert (ahead[close] < 10 * behind[close] ** 2).all()


@pytest.mark.parametrize("criteria", [None, JointCentering()], ids=["alone", "centring"])
def test_step_reports_the_error_after_the_step(criteria):
    """Also for a strategy that does not evaluate its candidate itself."""
    robot = planar(4)
    ik, q, target = solver(robot, Damped(backtracking=False), criteria=criteria), np.full(4, 0.3), np.array([2.5, 1.5])
    for _ in range(4):
        step = ik.step(q, target)
        assert step.position_error == pytest.approx(np.linalg.norm(planar_points(step.q)[-1] - target), abs=EXACT)
        q = step.q


def test_without_evaluation_of_the_candidate_steps_are_the_same():
    """The iterates of solve, which does not evaluate where they lead, are those of step, which does."""
    robot = dh_arm(7, 2, limit=2.0)
    ik = shared_solver(robot, jtik.FrameTask("tip", "pose"), strategy=Damped(backtracking=False))
    target, q = robot.pose(np.full(7, 0.9)), np.full(7, -0.3)
    trace = ik.solve(target, q0=q, max_iterations=12, trace=True).trace
    for row in trace.q[1:]:
        q = ik.step(q, target).q
        assert q == pytest.approx(row, abs=EXACT)


def test_a_lost_solve_ends_at_the_limit_with_its_last_error():
    ik = solver(planar(3), Damped(backtracking=False))
    solution = ik.solve([1.0, 0.0], q0=np.zeros(3), max_iterations=1)
    assert not solution.converged
    assert solution.position_error == pytest.approx(np.linalg.norm(planar_points(solution.q)[-1] - (1, 0)), abs=EXACT)


@pytest.mark.parametrize(("option", "value"), [("damping", 0.0), ("damping", math.inf), ("q_limit", -1.0)])
def test_options_are_checked(option, value):
    with pytest.raises(jtik.ArgumentError, match=option):
        Damped(**{option: value})


def test_a_step_in_lanes_is_that_without_backtracking_and_as_short_as_its_damping_makes_it(rng):
    """|dq| is at most sqrt(V / 2 mu) = sqrt(1 / 2 damping), however far the target and near a singular pose."""
    strategy = Damped(damping=0.2).in_lanes()
    assert strategy == Damped(damping=0.2, backtracking=False, q_limit=math.inf)
    ik = solver(planar(5), strategy)
    for q, target in ((rng.uniform(-2, 2, 5), rng.uniform(-50, 50, 2)), (np.full(5, 1e-6), np.array([4.9, 0.0]))):
        assert np.linalg.norm(ik.step(q, target).q - q) <= math.sqrt(1 / 0.4) + 1e-9


def test_other_strategies_are_their_own_in_lanes():
    for name in ("hybrid", "newton", "transpose"):
        strategy = jtik.strategies[name]()
        assert strategy.in_lanes() is strategy

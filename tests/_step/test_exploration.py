"""Exploration: a solve from one start leaves local minima, V at q never rises, and a step never explores."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jtik
from jtik_formulations import Damped, Hybrid, JointCentering, Newton, ProjectedGradient

from ..conftest import DIFFERENCES, dh_arm, planar, rises, shared_solver, slow

pytestmark = pytest.mark.thinned(together=True)

TOLERANCE = 1e-6
GOALS = 40
STRATEGIES = {"hybrid": Hybrid, "damped": Damped}


@functools.cache
def solver(strategy, seed=0, *, limits=False, **options):
    return shared_solver(
        dh_arm(6, seed, limit=2.5), jtik.FrameTask(kind="pose"), strategy=strategy, limits=limits, **options
    )


@functools.cache
def goals(seed=0):
    """A start, and poses of uniform configurations."""
    rng = np.random.default_rng(seed)
    start, *others = rng.uniform(-math.pi, math.pi, (GOALS + 1, 6))
    return start, [dh_arm(6, seed, limit=2.5).pose(q) for q in others]


def error(robot, q, target):
    """Position and rotation vector from the target, and the geometric Jacobian."""
    T, J = robot.pose(q), robot.jacobian(q)
    turn = Rotation.from_matrix(target[:3, :3].T @ T[:3, :3]).as_rotvec()
    return np.concatenate([T[:3, 3] - target[:3, 3], turn]), np.vstack([J[:3], target[:3, :3].T @ J[3:]])


def reached(e):
    return np.linalg.norm(e[:3]) <= TOLERANCE and np.linalg.norm(e[3:]) <= TOLERANCE


def plain_loop(robot, q, target, calls=100):
    """Damped least squares, damped by a tenth of V, every step taken: whether it arrives."""
    for _ in range(calls):
        e, J = error(robot, q, target)
        if reached(e):
            return True
        q = q - J.T @ np.linalg.solve(J @ J.T + (0.05 * e @ e + 1e-16) * np.eye(6), e)
    return False


def stuck_case():
    """A solver of each strategy without exploration does not reach this target."""
    start, targets = goals()
    return start, next(
        t
        for t in targets
        if not any(solver(s(explore=False)).solve(t, q0=start).converged for s in STRATEGIES.values())
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, *slow(1, 2)])
def test_from_one_start_it_arrives_at_least_as_often_as_a_plain_damped_loop(seed):
    robot, (start, targets) = dh_arm(6, seed, limit=2.5), goals(seed)
    plain = sum(plain_loop(robot, start, target) for target in targets)
    assert plain < GOALS - 5  # otherwise the test says nothing
    for name in STRATEGIES:
        found = [solver(name, seed).solve(target, q0=start, max_iterations=200) for target in targets]
        arrived = sum(reached(error(robot, each.q, target)[0]) for each, target in zip(found, targets, strict=True))
        assert arrived == sum(each.converged for each in found)
        assert arrived > plain, name


@pytest.mark.parametrize("name", STRATEGIES)
def test_the_configuration_returned_never_gets_worse_wherever_the_solve_is_cut_off(name):
    """While it explores, q waits, and the errors that are reported are those at q."""
    start, target = stuck_case()
    ik, ends = solver(name), []
    for limit in range(1, 140):
        solution = ik.solve(target, q0=start, max_iterations=limit)
        e, _ = error(ik.robot, solution.q, target)
        assert solution.position_error == pytest.approx(np.linalg.norm(e[:3]), abs=1e-9)
        assert solution.orientation_error == pytest.approx(np.linalg.norm(e[3:]), abs=DIFFERENCES)
        ends.append(np.linalg.norm(e))
    assert (np.diff(ends) <= 1e-12).all()
    waits = np.diff(ends) == 0
    assert waits.sum() > 5


@pytest.mark.parametrize("name", STRATEGIES)
def test_a_trace_has_V_at_q_which_never_rises(name):
    start, target = stuck_case()
    solution = solver(name).solve(target, q0=start, trace=True)
    trace = solution.trace
    assert pytest.approx(trace.error[:-1] ** 2 / 2, rel=1e-9) == trace.V
    assert rises(trace).max() <= 1e-13
    assert np.array_equal(solution.q, solver(name).solve(target, q0=start).q)


@pytest.mark.parametrize("name", STRATEGIES)
def test_step_does_not_explore(name):
    start, target = stuck_case()
    with_it, without = solver(name), solver(STRATEGIES[name](explore=False))
    q, p = start, start
    with_it.reset()
    without.reset()
    for _ in range(60):
        q, p = with_it.step(q, target).q, without.step(p, target).q
        assert np.array_equal(q, p)


@pytest.mark.parametrize("name", STRATEGIES)
def test_within_limits(name):
    start, targets = goals()
    ik = solver(name, limits=True)
    start = np.clip(start, ik.robot.lower, ik.robot.upper)
    for target in targets[:15]:
        trace = ik.solve(target, q0=start, trace=True, max_iterations=150).trace
        assert (trace.q >= ik.robot.lower - 1e-12).all()
        assert (trace.q <= ik.robot.upper + 1e-12).all()
        assert rises(trace).max(initial=-1) <= 1e-13


@pytest.mark.parametrize("name", STRATEGIES)
@pytest.mark.parametrize("reach", [1.001, 2.0])
def test_out_of_reach_it_ends_where_it_ends_without(name, reach):
    robot, target = planar(4), np.array([4 * reach, 0.0])
    q0 = np.array([0.3, 0.5, -0.4, 0.2])
    with_it, without = (
        shared_solver(robot, jtik.FrameTask(), strategy=s).solve(target, q0=q0, max_iterations=3000)
        for s in (name, STRATEGIES[name](explore=False))
    )
    assert with_it.position_error == pytest.approx(4 * reach - 4, abs=1e-7)
    assert with_it.position_error == pytest.approx(without.position_error, abs=1e-7)
    assert with_it.iterations <= without.iterations + 150


@pytest.mark.parametrize("name", STRATEGIES)
def test_beside_a_criterion(name):
    """Far from the target V alone counts, for the explorer, too; then the criterion is brought to its optimum."""
    robot, (start, targets), counts = dh_arm(6, 0), goals(), []
    task = jtik.FrameTask(axes=("x", "y", "z", "rx", "ry"), kind="pose")
    for explore in (True, False):
        strategy = STRATEGIES[name](explore=explore)
        ik = shared_solver(robot, task, strategy=strategy, criteria=JointCentering(), limits=False)
        solutions = [ik.solve(target, q0=start, max_iterations=400) for target in targets]
        counts.append(sum(each.converged for each in solutions))
    assert counts[0] > counts[1]


def test_only_where_the_merit_function_tests_the_step():
    assert Hybrid().explores(True)
    assert Damped().explores(True)
    assert not Damped(backtracking=False).explores(False)
    paper = ProjectedGradient(rule="paper")
    assert not Hybrid(secondary=paper).explores(True)
    assert Hybrid(secondary=paper).explores(False)
    assert not Newton().explores(False)


@pytest.mark.slow
@pytest.mark.parametrize("strategy", ["hybrid", "damped"])
def test_the_same_in_generated_C(strategy):
    start, targets = goals(1)
    compiled, other = solver(strategy, 1, compiled=True), solver(strategy, 1)
    for target in targets[:20]:
        ours, theirs = (ik.solve(target, q0=start) for ik in (compiled, other))
        assert (ours.status, ours.iterations) == (theirs.status, theirs.iterations)
        assert ours.q == pytest.approx(theirs.q, abs=1e-6)
    assert compiled._engine.runners.explores
    assert compiled._engine.runners.exploring.fused.library is not None

"""Several distinct configurations: the best by the criterion, or the nearest to the start; and the jump limit."""

from __future__ import annotations

import itertools
import pickle

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering

from ...conftest import planar, planar_points, shared_solver

PANDA = jtik.Robot.builtin("panda")
HOME = PANDA.keyframes["home"]


def solver(robot, kind="pose", **options):
    return shared_solver(robot, jtik.FrameTask("tip", kind), **options)


@pytest.mark.parametrize("compiled", [False, True], ids=["interpreted", "compiled"])
def test_both_elbows_of_a_planar_arm(compiled):
    """Two links: the closed form has two configurations, mirrored at the line to the target."""
    arm, q0 = planar(2), np.array([0.2, 0.4])
    solution = solver(arm, "position", compiled=compiled).solve([1.0, 1.0], q0=q0, restarts=40, best_of=2)
    assert solution.q == pytest.approx([0.0, np.pi / 2], abs=1e-5)
    (other,) = solution.alternatives
    assert other.q == pytest.approx([np.pi / 2, -np.pi / 2], abs=1e-5)
    assert other.converged
    assert other.alternatives == ()
    assert "1 more" in repr(solution)
    again = pickle.loads(pickle.dumps(solution))
    assert np.array_equal(again.alternatives[0].q, other.q)


def test_fewer_are_returned_where_there_are_no_more():
    solution = solver(planar(2), "position").solve([1.0, 1.0], q0=[0.2, 0.4], restarts=20, best_of=5)
    assert len(solution.alternatives) == 1
    assert solution.restarts == 20


@pytest.mark.quick(1)
@pytest.mark.parametrize("compiled", [False, True], ids=["interpreted", "compiled"])
def test_ordered_by_the_criterion(compiled, rng):
    ik = solver(PANDA, criteria=JointCentering(), compiled=compiled)
    for _ in range(3):
        target = PANDA.pose(PANDA.random_configuration(rng))
        solution = ik.solve(target, q0=HOME, restarts=60, best_of=4)
        found = [solution, *solution.alternatives]
        assert len(found) == 4
        costs = [each.cost for each in found]
        assert costs == sorted(costs)
        assert costs[0] == pytest.approx(np.sum((solution.q - HOME) ** 2) / 2, rel=1e-9) or costs[0] > 0
        for one, other in itertools.combinations(found, 2):
            assert np.abs(one.q - other.q).max() > 1e-2
        for each in found:
            assert np.abs(PANDA.pose(each.q) - target).max() < 1e-5
        assert solution.cost <= ik.solve(target, q0=HOME, restarts=60).cost + 1e-9


def test_without_a_criterion_by_the_distance_from_the_start(rng):
    target = PANDA.pose(PANDA.random_configuration(rng))
    solution = solver(PANDA).solve(target, q0=HOME, restarts=60, best_of=5)
    distances = [np.linalg.norm(each.q - HOME) for each in (solution, *solution.alternatives)]
    assert len(distances) == 5
    assert distances == sorted(distances)


def test_one_is_the_default_and_the_search_is_the_same(rng):
    ik = solver(PANDA)
    target = PANDA.pose(PANDA.random_configuration(rng))
    assert np.array_equal(ik.solve(target, restarts=30).q, ik.solve(target, restarts=30, best_of=1).q)


@pytest.mark.quick(1)
@pytest.mark.parametrize("compiled", [False, True], ids=["interpreted", "compiled"])
def test_no_joint_goes_further_than_the_jump_limit(compiled, rng):
    ik = solver(PANDA, compiled=compiled)
    reached = 0
    for _ in range(12):
        q0 = PANDA.random_configuration(rng)
        near = np.clip(q0 + rng.uniform(-0.2, 0.2, 7), PANDA.lower, PANDA.upper)
        solution = ik.solve(PANDA.pose(near), q0=q0, jump_limit=0.25, restarts=5)
        assert np.abs(solution.q - q0).max() <= 0.25 + 1e-9
        reached += solution.converged
        far = ik.solve(PANDA.pose(PANDA.random_configuration(rng)), q0=q0, jump_limit=0.25)
        assert np.abs(far.q - q0).max() <= 0.25 + 1e-9
        if not far:
            assert far.status in (jtik.Status.JUMP_LIMIT, jtik.Status.LIMITS)
    assert reached >= 11
    free = ik.solve(PANDA.pose(HOME), q0=q0, restarts=20)  # the limit was that solve's own
    assert free.converged


def test_what_keeps_a_solve_within_its_jump_limit_is_said():
    solution = solver(planar(2), "position").solve([1.0, 1.0], q0=[1.5, -0.2], jump_limit=0.1)
    assert solution.status is jtik.Status.JUMP_LIMIT
    assert "jump_limit" in str(solution)
    assert not solution.converged


@pytest.mark.thinned
@pytest.mark.parametrize("trace", [False, True])
@pytest.mark.parametrize("strategy", ["hybrid", "damped", "newton+qp", "weighted_qp", "sns"])
def test_joints_without_limits_keep_it_too(strategy, trace, rng):
    ik = solver(planar(3), "position", strategy=strategy, criteria=JointCentering())
    for target in ([2.0, 0.0], [1.0, 1.5], [-1.0, 0.5]):  # the first from the straight arm, which an escape leaves
        for q0 in (np.zeros(3), rng.uniform(-2, 2, 3)):
            solution = ik.solve(target, q0=q0, jump_limit=0.2, trace=trace, max_iterations=200)
            assert np.abs(solution.q - q0).max() <= 0.2 + 1e-9
            far = np.linalg.norm(planar_points(q0)[-1] - target) > 1.3  # further than they get by 0.2 rad
            assert not (far and solution.status is not jtik.Status.JUMP_LIMIT)


def test_a_ball_joint_keeps_it_too():
    ball = jtik.Joint("shoulder", jtik.JointType.BALL, "base", "arm")
    reach = np.eye(4)
    reach[0, 3] = 1.0
    robot = jtik.Robot([ball, jtik.Joint("hand", jtik.JointType.FIXED, "arm", "tip", origin=reach)], tip="tip")
    ik = solver(robot, "position")
    assert ik.solve([np.cos(0.2), np.sin(0.2), 0.0], jump_limit=0.3).converged
    far = ik.solve([0.0, 1.0, 0.0], jump_limit=0.3)
    assert not far.converged
    assert far.status is jtik.Status.JUMP_LIMIT


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"best_of": 0}, "positive integer"),
        ({"best_of": 1.5, "restarts": 5}, "positive integer"),
        ({"best_of": True, "restarts": 5}, "positive integer"),
        ({"best_of": 10**30, "restarts": 5}, "at most"),
        ({"jump_limit": np.inf}, "None for no limit"),
        ({"best_of": 2}, "restarts=100"),
        ({"jump_limit": 0.0}, "positive"),
        ({"jump_limit": "x"}, "positive"),
        ({"jump_limit": np.nan}, "positive"),
        ({"jump_limit": 0.1, "q0": np.full(7, 3.0)}, "within the limits"),
    ],
)
def test_wrong_input(options, words):
    argument = "q0" if "q0" in options else next(iter(options))
    with pytest.raises(jtik.ArgumentError, match=words) as caught:
        solver(PANDA).solve(np.eye(4), **options)
    assert caught.value.argument == argument

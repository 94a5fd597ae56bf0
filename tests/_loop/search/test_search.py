"""Restarts: found where one start fails, the same for the same seed, and within the limits."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

import jtik
from jtik_formulations import Damped, JointCentering

from ...conftest import dh_arm, planar, shared_solver
from ..conftest import EVERY_STRATEGY


@pytest.fixture(scope="module")
def arm():
    return dh_arm(7, 3, limit=1.5)


@pytest.fixture(scope="module")
def targets(arm):
    rng = np.random.default_rng(4)
    return [arm.pose(arm.random_configuration(rng)) for _ in range(30)]


def solver(robot, strategy="hybrid", kind="pose", **options):
    return shared_solver(robot, jtik.FrameTask("tip", kind), strategy=strategy, **options)


@pytest.mark.quick(2)
@pytest.mark.parametrize("strategy", ["damped", "hybrid", "newton", Damped(backtracking=False)], ids=str)
def test_they_find_what_one_start_does_not(arm, targets, strategy):
    ik = solver(arm, strategy)
    alone = [ik.solve(target, max_iterations=100).converged for target in targets]
    assert not all(alone)  # else this test could not fail
    for target in targets:
        solution = ik.solve(target, restarts=100)
        assert solution.converged
        assert np.abs(arm.pose(solution.q) - target).max() < 1e-5
        assert (arm.lower <= solution.q).all()
        assert (solution.q <= arm.upper).all()


def test_the_same_seed_gives_the_same_answer_in_any_order(arm, targets):
    forth, back = solver(arm, "damped"), solver(arm, "damped")
    first = [forth.solve(target, restarts=20, seed=5).q for target in targets]
    second = [back.solve(target, restarts=20, seed=5).q for target in reversed(targets)]
    assert np.array_equal(first, second[::-1])
    other = [forth.solve(target, restarts=20, seed=6) for target in targets]
    differ = [not np.array_equal(q, there.q) for q, there in zip(first, other, strict=True)]
    assert differ == [there.restarts > 0 for there in other]
    assert any(differ)


def test_a_start_that_leads_to_the_target_is_kept(arm):
    q = np.full(7, 0.3)
    alone, ready = solver(arm).solve(arm.pose(q), q0=q + 0.1), solver(arm).solve(arm.pose(q), q0=q + 0.1, restarts=10)
    assert ready.restarts == 0
    assert np.array_equal(alone.q, ready.q)
    assert alone.iterations == ready.iterations


def test_out_of_reach_ends_at_the_closest_posture_found():
    ik = solver(planar(3), kind="position")
    solution = ik.solve([5.0, 1.0], q0=[0.3, 0.4, 0.5], restarts=8)
    assert solution.status is jtik.Status.LOCAL_MINIMUM
    assert solution.restarts == 8
    assert solution.position_error == pytest.approx(math.hypot(5, 1) - 3, abs=1e-6)


def test_an_attempt_without_progress_is_given_up_early(arm):
    lost = np.eye(4)
    lost[:3, 3] = 40.0, 0.0, 0.0
    ik = solver(arm, "damped")
    one = ik.solve(lost, max_iterations=1000)
    many = ik.solve(lost, max_iterations=1000, restarts=10)
    assert many.iterations < 11 * 60 + 2 * one.iterations
    assert many.position_error <= one.position_error * (1 + 1e-6)


def test_a_singular_start_is_left_before_others_are_tried():
    """A straight arm with its target on its line needs a second-order step, not another start."""
    solution = solver(planar(4), kind="position").solve([2.0, 0.0], q0=np.zeros(4), restarts=5)
    assert (solution.converged, solution.escapes, solution.restarts) == (True, 1, 0)


def test_the_criterion_settles_where_the_target_was_reached(arm, targets):
    ik = solver(arm, criteria=JointCentering())
    for target in targets[:8]:
        solution = ik.solve(target, restarts=50)
        assert solution.position_error < 1e-6
        assert solution.status in (jtik.Status.CONVERGED, jtik.Status.REACHED)


def test_a_trace_has_the_rows_of_all_attempts(arm, targets):
    ik = solver(arm, "damped")
    target = next(t for t in targets if ik.solve(t, restarts=50).restarts > 1)
    plain, traced = ik.solve(target, restarts=50), ik.solve(target, restarts=50, trace=True)
    assert np.array_equal(plain.q, traced.q)
    assert len(traced.trace) == traced.iterations == plain.iterations
    assert "restarts" in repr(plain)


@pytest.mark.quick(2)
@pytest.mark.parametrize("strategy", EVERY_STRATEGY)
def test_patience_changes_nothing_for_one_start(strategy):
    ik, q0 = solver(planar(5), strategy, "position"), np.full(5, 0.3)
    before = ik.solve([3.0, 1.0], q0=q0)
    ik.solve([9.0, 1.0], q0=q0, restarts=2)
    assert np.array_equal(before.q, ik.solve([3.0, 1.0], q0=q0).q)


@pytest.mark.parametrize(("option", "value"), [("restarts", -1), ("restarts", 1.5), ("seed", -3), ("seed", "a")])
def test_counts_are_counts(option, value):
    with pytest.raises(jtik.ArgumentError, match=option):
        solver(planar(3), kind="position").solve([1.0, 1.0], **{option: value})


def test_a_solution_keeps_the_errors_of_its_own_target(arm, targets):
    ik = solver(arm, criteria=JointCentering())
    first = ik.solve(targets[0], restarts=20)
    ik.parameters["joint_centering.weight"] = 7.0
    ik.solve(targets[1], restarts=20)
    assert first.position_error < 1e-6
    copied = pickle.loads(pickle.dumps(first))
    assert copied.cost == first.cost
    assert repr(copied) == repr(first)

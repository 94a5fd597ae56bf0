"""Limits: what is accepted, and what holds along a path of steps by any strategy.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import dataclass, replace

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, Newton

from ..conftest import EXACT, ball_arm, families_first, floating_arm, planar, shared_solver, slow

pytestmark = pytest.mark.thinned(together=True, times=2)

STRATEGIES = [
    *families_first([*sorted(jtik.strategies), "hybrid+qp"]),
    *slow("newton+qp", "transpose+qp", "newton+second_order"),
]
DT = 0.02
RELATIVE = 1e-9
"""Rounding of positions of order one, divided by dt twice, relative to the smallest acceleration limit here."""


@pytest.fixture(scope="module")
def arm():
    """Four joints with limits of their own, so that some bind before others."""
    return jtik.Robot.planar(4, lower=[-0.7, -1.5, -0.3, -2.0], upper=[0.6, 1.5, 1.2, 2.0], velocity_limit=[1, 2, 3, 4])


def solver(robot, **options):
    return shared_solver(robot, jtik.FrameTask("tip"), **options)


def checked_speeds(robot, q0, path, acceleration, dt=DT, velocity=None):
    """Whether positions, speeds and their changes along (k, nq) are within limits, by differences, from rest at q0."""
    rows = [q0, *path]
    steps = np.array([robot.difference(a, b) for a, b in itertools.pairwise(rows)])
    speeds = np.vstack([np.zeros(robot.n), steps]) / dt
    limit = robot.velocity_limit if velocity is None else velocity
    assert (np.abs(speeds) <= limit * (1 + RELATIVE)).all()
    assert (np.abs(np.diff(speeds, axis=0)) / dt <= acceleration * (1 + RELATIVE)).all()
    assert (robot.lower <= path).all()
    assert (np.asarray(path) <= robot.upper).all()
    return speeds[1:]


def restless(k):
    """A target that jumps between places within reach and out of it, each for a while."""
    places = [[2.0, 2.0], [3.0, -1.0], [5.0, 3.0], [0.5, -0.5], [1.0, -3.0]]
    return np.array(places[k // 25 % len(places)])


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_every_strategy_keeps_all_three_limits_step_by_step(strategy, arm):
    ik = solver(arm, criteria=JointCentering(), strategy=strategy, limits=jtik.Limits(acceleration=[3, 6, 9, 12]))
    q0 = q = np.array([0.5, -0.4, 0.9, 0.3])
    path = []
    for k in range(250):
        step = ik.step(q, restless(k), dt=DT)
        q = step.q
        path.append(q)
        assert step.position_error == pytest.approx(np.linalg.norm(arm.position(q) - restless(k)), rel=1e-6, abs=1e-9)
    speeds = checked_speeds(arm, q0, path, np.array([3, 6, 9, 12]))
    assert (np.abs(speeds).max(axis=0) > 0.2).all()  # it moved, all of it
    assert (np.abs(np.diff(speeds, axis=0)) / DT > 0.99 * np.array([3, 6, 9, 12])).any()  # and the limits did bind


@pytest.mark.quick(1)
@pytest.mark.parametrize("strategy", ["hybrid", "newton+qp", "weighted_qp", "mink"])
def test_track_keeps_all_three_limits_from_rest(strategy, arm):
    q0, acceleration = np.array([0.5, -0.4, 0.9, 0.3]), 5.0
    ik = solver(arm, criteria=JointCentering(), strategy=strategy, limits=jtik.Limits(acceleration=acceleration))
    path = ik.track([restless(k) for k in range(125)], q0=q0, dt=DT, max_iterations=30)
    checked_speeds(arm, q0, path.q, acceleration)
    assert np.abs(path.dq[0]).max() == pytest.approx(acceleration * DT)  # as fast as it may, from rest
    again = ik.track([restless(k) for k in range(3)], q0=q0, dt=DT, max_iterations=30)
    assert again.q == pytest.approx(path.q[:3], abs=1e-12)  # at rest again


def test_a_path_that_the_robot_can_follow_is_followed():
    robot, q0 = planar(3, velocity_limit=2.0), np.array([0.4, 0.6, 0.5])
    turns = [0.3 * (1 - math.cos(2 * DT * k)) for k in range(1, 200)]
    targets = [robot.position(q0 + turn * np.array([1.0, -0.5, 0.7])) for turn in turns]
    path = solver(robot, limits=jtik.Limits(acceleration=4.0)).track(targets, q0=q0, dt=DT)
    assert path.converged
    checked_speeds(robot, q0, path.q, 4.0)


@dataclass(frozen=True, kw_only=True)
class Stubborn(Newton):
    """Newton's method that takes a step only while the error is above 0.4 m."""

    def update(self, model, state):
        return replace(super().update(model, state), accepted=model.here.length > 0.4)


def test_a_refused_step_brakes_as_hard_as_the_joints_can(arm):
    """The step of the box that is closest to a stop."""
    ik = solver(arm, strategy=Stubborn(), limits=jtik.Limits(velocity=False, acceleration=10.0))
    q, target = np.array([0.0, 0.5, 0.3, 0.2]), arm.position([0.9, 1.1, 0.6, 0.4])
    while (step := ik.step(q, target, dt=DT)).accepted:
        start, q = q, step.q
    speed = (q - start) / DT
    braked = q + DT * np.sign(speed) * np.maximum(np.abs(speed) - 10.0 * DT, 0)
    assert np.abs(braked - q).max() > 0.003
    assert step.q == pytest.approx(braked, abs=EXACT)
    assert step.position_error == pytest.approx(np.linalg.norm(arm.position(braked) - target))


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_every_strategy_uses_a_share_of_the_distance_to_a_limit(strategy, arm):
    check_shares(strategy, 20.0, arm)


@pytest.mark.parametrize("strategy", ["hybrid", *slow("weighted_qp", "sns_qp")])
def test_without_limits_of_acceleration_it_is_used_too(strategy, arm):
    check_shares(strategy, None, arm)


def check_shares(strategy, acceleration, arm):
    """Of the distance before each step; a joint was stopped by it, and limits of velocity and acceleration hold."""
    gain, q = 0.5, np.array([0.5, -0.4, 0.9, 0.3])
    limits = jtik.Limits(position_gain=gain, acceleration=acceleration)
    ik, path = solver(arm, strategy=strategy, limits=limits), [q]
    for k in range(150):
        q = ik.step(q, restless(k), dt=DT).q
        path.append(q)
    steps, before = np.diff(path, axis=0), np.array(path[:-1])
    distance = np.where(steps > 0, arm.upper - before, before - arm.lower)
    assert (np.abs(steps) <= gain * distance + EXACT).all()
    assert (np.abs(steps) > 0.99 * gain * distance)[np.abs(steps) > 1e-6].any()
    checked_speeds(arm, path[0], path[1:], np.inf if acceleration is None else acceleration)


def test_the_share_applies_to_a_path_and_not_to_a_solve_nor_to_a_step_without_a_time():
    robot, limits = planar(2, lower=-0.5, upper=0.5, velocity_limit=1e3), jtik.Limits(position_gain=0.5)
    ik, plain = solver(robot, limits=limits), solver(robot)
    q0, target = np.array([0.3, 0.3]), robot.position([0.5, 0.4])
    assert ik.solve(target, q0=q0).q.tolist() == plain.solve(target, q0=q0).q.tolist()
    assert ik.step(q0, target).q.tolist() == plain.step(q0, target).q.tolist()
    path = ik.track([target] * 60, q0=q0, dt=DT)
    left = 0.5 - np.concatenate([[0.3], path.q[:, 0]])
    assert (left[1:] >= 0.5 * left[:-1] - EXACT).all()
    assert left[-1] == pytest.approx(0, abs=1e-5)  # the tolerance of the target is 1e-6 m


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_a_start_outside_returns_at_the_allowed_rate(strategy):
    robot = jtik.Robot.planar(3, lower=-0.5, upper=0.5, velocity_limit=1.0)
    acceleration = 5.0
    ik = solver(robot, strategy=strategy, limits=jtik.Limits(acceleration=acceleration))
    q0 = q = np.array([0.9, 0.2, -0.1])
    first = [q0[0]]
    for _ in range(60):
        q = ik.step(q, [1.0, 2.5], dt=DT).q
        first.append(q[0])
    first = np.array(first)
    returning = first[1:][first[1:] > 0.5]
    assert (np.diff(first[: len(returning) + 1]) <= 0).all()
    assert (first[len(returning) + 1 :] <= 0.5).all()
    # the way back under a constant acceleration up to the speed limit, in closed form
    k = np.arange(1, len(returning) + 1)
    ramp = round(1.0 / (acceleration * DT))
    fastest = acceleration * DT**2 * np.where(k <= ramp, k * (k + 1) / 2, ramp * (ramp + 1) / 2 + ramp * (k - ramp))
    assert returning == pytest.approx(0.9 - fastest, abs=1e-9)


class TestStep:
    def test_without_a_time_it_knows_no_speed(self, arm):
        q, target = np.array([0.5, -0.4, 0.9, 0.3]), [2.0, 2.0]
        plain, limited = solver(arm), solver(arm, limits=jtik.Limits(velocity=1e-3, acceleration=1e-3))
        limited.step(q, target, dt=DT)
        assert limited.step(q, target).q.tolist() == plain.step(q, target).q.tolist()
        assert limited.solve(target, q0=q).q.tolist() == plain.solve(target, q0=q).q.tolist()

    def test_speeds_count_from_the_configuration_that_is_given(self, arm):
        ik = solver(arm)
        for _ in range(5):
            q = np.array([0.5, -0.4, 0.9, 0.3])
            step = ik.step(q, [2.0, 2.0], dt=DT).q - q
            assert (np.abs(step) <= arm.velocity_limit * DT + EXACT).all()

    def test_the_first_step_is_from_rest_and_so_is_the_one_after_a_reset(self, arm):
        ik = solver(arm, limits=jtik.Limits(acceleration=5.0))
        q = np.array([0.5, -0.4, 0.9, 0.3])
        steps = []
        for k in range(4):
            if k == 3:
                ik.reset()
            steps.append(np.abs(ik.step(q, [2.0, 2.0], dt=DT).q - q).max())
        assert steps == pytest.approx([5.0 * DT**2 * k for k in (1, 2, 3, 1)])

    def test_times_may_change_from_step_to_step(self, arm, rng):
        ik = solver(arm, criteria=JointCentering(), strategy="weighted_qp", limits=jtik.Limits(acceleration=8.0))
        q, speed = np.array([0.5, -0.4, 0.9, 0.3]), np.zeros(4)
        for k in range(300):
            dt = float(rng.choice([0.001, 0.01, 0.03]))
            step = ik.step(q, restless(k), dt=dt)
            after = (step.q - q) / dt
            assert (np.abs(after) <= arm.velocity_limit * (1 + RELATIVE)).all()
            assert (np.abs(after - speed) <= 8.0 * dt * (1 + 1e-7)).all()
            assert ((arm.lower <= step.q) & (step.q <= arm.upper)).all()
            q, speed = step.q, after

    @pytest.mark.slow
    def test_generated_c_is_the_same(self, arm):
        options = {"criteria": JointCentering(), "limits": jtik.Limits(acceleration=5.0)}
        ways = [solver(arm, **options), solver(arm, compiled=True, **options)]
        q = [np.array([0.5, -0.4, 0.9, 0.3])] * 2
        for k in range(40):
            q = [ik.step(each, restless(k), dt=DT).q for ik, each in zip(ways, q, strict=True)]
            assert q[1] == pytest.approx(q[0], abs=1e-9)

    @pytest.mark.parametrize("dt", [0.0, -0.01, math.nan, math.inf, "0.1", [0.1, 0.2], np.array([0.02, 0.03]), True])
    def test_a_time_is_a_positive_number(self, dt, arm):
        with pytest.raises(jtik.ArgumentError, match="dt: given"):
            solver(arm).step(np.zeros(4), [2.0, 2.0], dt=dt)

    def test_wrong_numbers_leave_the_speed_as_it_was(self, arm):
        ways = [solver(arm, limits=jtik.Limits(acceleration=5.0)) for _ in range(2)]
        q = np.array([0.5, -0.4, 0.9, 0.3])
        for ik in ways:
            ik.step(q, [2.0, 2.0], dt=DT)
        for wrong, dt in itertools.product(([math.nan, 0.0, 0.0, 0.0], [0.0] * 3), (DT, None)):
            with pytest.raises(jtik.ArgumentError, match="q"):
                ways[0].step(np.array(wrong), [2.0, 2.0], dt=dt)
        with pytest.raises(jtik.ArgumentError, match="target"):
            ways[0].step(q, np.array([math.nan, 2.0]), dt=DT)
        assert ways[0].step(q, [2.0, 2.0], dt=DT).q.tolist() == ways[1].step(q, [2.0, 2.0], dt=DT).q.tolist()


@pytest.mark.quick(1)
@pytest.mark.parametrize("robot", [ball_arm, floating_arm])
@pytest.mark.parametrize("strategy", ["hybrid", "weighted_qp"])
def test_ball_and_free_joints_keep_speed_and_acceleration_too(robot, strategy, rng):
    robot = robot()
    limits = jtik.Limits(velocity=0.8, acceleration=6.0)
    ik = shared_solver(robot, jtik.FrameTask("tip"), strategy=strategy, criteria=None, limits=limits)
    start = robot.integrate(robot.neutral, rng.uniform(-0.2, 0.2, robot.n))
    q0 = np.clip(start, robot.lower, robot.upper)
    goals = [robot.position(robot.integrate(q0, rng.uniform(-0.5, 0.5, robot.n))) for _ in range(4)]
    targets = [goals[k // 20 % 4] for k in range(80)]
    q, path = q0, []
    for target in targets:
        step = ik.step(q, target, dt=DT)
        q = step.q
        assert step.position_error == pytest.approx(np.linalg.norm(robot.position(q) - target), abs=1e-9)
        path.append(q)
    speeds = checked_speeds(robot, q0, path, 6.0, velocity=0.8)
    assert np.abs(speeds).max() > 0.5
    checked_speeds(robot, q0, ik.track(targets, q0=q0, dt=DT).q, 6.0, velocity=0.8)


class TestArguments:
    def test_true_and_false_are_shorthands(self, arm):
        assert solver(arm).limits == solver(arm, limits=True).limits == jtik.Limits()
        assert solver(arm, limits=False).limits == jtik.Limits(position=False)
        outside = np.array([1.0, -0.4, 0.9, 0.3])
        assert solver(arm, limits=False).step(outside, arm.position(outside), dt=DT).q.tolist() == outside.tolist()
        assert solver(arm).step(outside, arm.position(outside), dt=DT).q[0] == pytest.approx(1.0 - DT)

    @pytest.mark.parametrize("velocity", [0.7, [0.7] * 4, np.full(4, 0.7), (0.7, 0.7, 0.7, 0.7)])
    def test_a_speed_is_one_for_all_or_one_each(self, velocity, arm):
        q = np.array([0.5, -0.4, 0.9, 0.3])
        step = solver(arm, limits=jtik.Limits(velocity=velocity)).step(q, [0.5, -0.5], dt=DT)
        assert np.abs(step.q - q).max() == pytest.approx(0.7 * DT)

    @pytest.mark.parametrize("velocity", [False, math.inf, [math.inf] * 4])
    def test_none_and_infinite_are_the_same(self, velocity, arm):
        q, limits = np.array([0.5, -0.4, 0.9, 0.3]), jtik.Limits(velocity=velocity, acceleration=math.inf)
        step = solver(arm, limits=limits).step(q, [0.5, -0.5], dt=1e-6)
        assert step.q == pytest.approx(solver(arm).step(q, [0.5, -0.5]).q, abs=1e-10)

    def test_numbers_are_those_of_the_joints_that_move(self):
        panda = jtik.Robot.builtin("panda")
        ik = shared_solver(panda, jtik.FrameTask("tip"), limits=jtik.Limits(acceleration=[10.0] * 7))
        assert ik.robot.n == 7
        with pytest.raises(jtik.ArgumentError, match=re.escape("limits.acceleration: given 9 numbers; accepted: one")):
            jtik.InverseKinematics(panda, jtik.FrameTask("tip"), limits=jtik.Limits(acceleration=[10.0] * 9))
        with pytest.raises(jtik.ArgumentError, match=re.escape("limits.velocity: given 1 numbers")):
            jtik.InverseKinematics(panda, jtik.FrameTask("tip"), limits=jtik.Limits(velocity=[1.0]))

    @pytest.mark.parametrize("wrong", [0.0, -1.0, math.nan, "fast", [1.0, -1.0], [1.0, [2.0]], [[1.0]], None, 1j])
    def test_a_speed_is_positive(self, wrong):
        with pytest.raises(jtik.ArgumentError, match="velocity: given .*; accepted: True for the robot's own, False"):
            jtik.Limits(velocity=wrong)

    @pytest.mark.parametrize("wrong", [0.0, -1.0, math.nan, "fast", [1.0, -1.0], True, False])
    def test_an_acceleration_is_positive(self, wrong):
        with pytest.raises(jtik.ArgumentError, match="acceleration: given .*; accepted: None for none, or positive"):
            jtik.Limits(acceleration=wrong)

    @pytest.mark.parametrize("wrong", [0.0, -0.5, 1.1, math.nan, math.inf, "half", None, True, [0.5, 0.5]])
    def test_a_share_of_the_distance_is_above_0_and_at_most_1(self, wrong):
        with pytest.raises(jtik.ArgumentError, match="position_gain: given"):
            jtik.Limits(position_gain=wrong)

    def test_position_limits_hold_or_do_not(self):
        with pytest.raises(jtik.ArgumentError, match="position: given .*; accepted: True or False"):
            jtik.Limits(position=1.5)

    @pytest.mark.parametrize("wrong", [None, 1, "velocity", {"velocity": 1.0}])
    def test_anything_else_is_refused(self, wrong, arm):
        with pytest.raises(jtik.ArgumentError, match="limits: given .*; accepted: True or False: .*jtik.Limits"):
            solver(arm, limits=wrong)

    def test_they_are_values(self):
        assert jtik.Limits(velocity=np.array([1.0, 2.0])) == jtik.Limits(velocity=(1, 2))
        assert "velocity=(1.0, 2.0)" in repr(jtik.Limits(velocity=[1, 2]))

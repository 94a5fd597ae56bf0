"""The hybrid as a dogleg: Newton where it is trusted, the transpose step where it is not, the segment between."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

import jtik
from jtik_formulations import Hybrid, Newton, Transpose

from ..conftest import EXACT, dh_arm, planar, planar_jacobian, planar_points, rises, shared_solver, slow

BARE = {"backtracking": False, "q_limit": math.inf}


@functools.lru_cache(maxsize=20)
def solver(robot, strategy):
    return shared_solver(robot, jtik.FrameTask(), strategy=strategy, limits=False)


def step(robot, strategy, q, target):
    """The first step, and whether it was taken."""
    ik = solver(robot, strategy)
    ik.reset()
    found = ik.step(q, target)
    return found.q - q, found.accepted


def cauchy_and_newton(robot, q, target):
    return step(robot, Transpose(**BARE), q, target)[0], step(robot, Newton(**BARE), q, target)[0]


def cases(rng, count=8):
    for robot in (planar(3), planar(10), dh_arm(6, 1)):
        for _ in range(count):
            q = rng.uniform(-1, 1, robot.n)
            yield robot, q, robot.position(q + rng.uniform(-0.5, 0.5, robot.n))


@pytest.mark.slow
def test_within_the_limit_it_is_newtons_step(rng):
    seen = 0
    for robot, q, target in cases(rng):
        _, newton = cauchy_and_newton(robot, q, target)
        dq, accepted = step(robot, Hybrid(q_limit=1.01 * np.linalg.norm(newton)), q, target)
        if accepted:
            seen += 1
            assert dq == pytest.approx(newton, abs=EXACT * (1 + np.abs(newton).max()))
    assert seen > 15


@pytest.mark.parametrize("radius", [1e-6, 1e-3])
def test_at_a_tiny_radius_it_is_the_transpose_step_shortened_to_it(radius, rng):
    for robot, q, target in cases(rng):
        cauchy, _ = cauchy_and_newton(robot, q, target)
        assert np.linalg.norm(cauchy) > radius
        dq, accepted = step(robot, Hybrid(q_limit=radius), q, target)
        assert accepted
        assert np.linalg.norm(dq) == pytest.approx(radius, rel=1e-8)
        assert dq == pytest.approx(radius * cauchy / np.linalg.norm(cauchy), abs=1e-8 * radius)


@pytest.mark.quick(1, slow=1)
@pytest.mark.parametrize("fraction", [0.3, *slow(0.01, 0.7, 0.99)])
def test_between_it_lies_on_the_segment_and_on_the_radius(fraction, rng):
    seen = 0
    for robot, q, target in cases(rng):
        cauchy, newton = cauchy_and_newton(robot, q, target)
        short, long = np.linalg.norm(cauchy), np.linalg.norm(newton)
        if long < 1.01 * short:
            continue
        radius = short + fraction * (long - short)
        dq, accepted = step(robot, Hybrid(q_limit=radius), q, target)
        if not accepted:
            continue
        seen += 1
        along = newton - cauchy
        part = (dq - cauchy) @ along / (along @ along)
        assert 0 < part < 1
        assert dq == pytest.approx(cauchy + part * along, abs=1e-10 * long)
        assert np.linalg.norm(dq) == pytest.approx(radius, rel=1e-9)
    assert seen > 5


def test_the_radius_shrinks_after_a_refusal_and_V_never_rises(rng):
    ik = shared_solver(planar(10), jtik.FrameTask(), strategy=Hybrid(q_limit=3.0))
    refusals = 0
    for _ in range(20):
        trace = ik.solve(planar_points(rng.uniform(-3, 3, 10))[-1], q0=rng.uniform(-1e-3, 1e-3, 10), trace=True).trace
        lengths = trace.step_length
        for k in np.flatnonzero(trace.accepted == 0):
            refusals += 1
            assert lengths[k + 1] <= 0.26 * lengths[k]  # a quarter of the step refused
        assert rises(trace).max() <= 0
    assert refusals > 5


def test_no_step_is_longer_than_the_limit(rng):
    ik = shared_solver(planar(6), jtik.FrameTask(), strategy=Hybrid(q_limit=0.2))
    for _ in range(10):
        trace = ik.solve(planar_points(rng.uniform(-2, 2, 6))[-1], q0=rng.uniform(-1, 1, 6), trace=True).trace
        assert np.linalg.norm(np.diff(trace.q, axis=0), axis=1).max() <= 0.2 + EXACT


def test_on_a_vehicle_the_limit_counts_the_turning_joints_only():
    robot = jtik.Robot.vehicle(3)
    q0 = np.array([0.0, 0.0, 0.4, 0.5, 0.6])
    ik = shared_solver(robot, jtik.FrameTask())
    trace = ik.solve((40.0, 30.0), q0=q0, trace=True).trace
    steps = np.diff(trace.q, axis=0)
    assert np.linalg.norm(steps[:, 2:], axis=1).max() <= 0.5 + EXACT
    assert np.linalg.norm(steps[:, :2], axis=1).max() > 5.0
    assert trace.error[-1] <= 1e-6


def test_it_needs_as_many_iterations_as_newton_near_the_target(rng):
    for _ in range(10):
        q = rng.uniform(0.2, 1, 5)
        target = planar_points(q + rng.uniform(-0.05, 0.05, 5))[-1]
        counts = [
            shared_solver(planar(5), jtik.FrameTask(), strategy=strategy).solve(target, q0=q).iterations
            for strategy in ("hybrid", Newton(**BARE))
        ]
        assert counts[0] == counts[1]


def test_alpha_in_the_trace_is_the_transpose_gain():
    q = np.array([0.4, 0.5, 0.6])
    target = planar_points(q)[-1] + (0.2, -0.1)
    ik = shared_solver(planar(3), jtik.FrameTask())
    trace = ik.solve(target, q0=q, max_iterations=1, trace=True).trace
    J, e = planar_jacobian(q), planar_points(q)[-1] - target
    g = J.T @ e
    assert trace.alpha[0] == pytest.approx((g @ g) / np.sum((J @ g) ** 2), rel=1e-10)


@pytest.mark.parametrize("limit", [0.0, -0.1, math.nan, math.inf])
def test_options_out_of_range_are_refused(limit):
    with pytest.raises(jtik.ArgumentError, match="q_limit"):
        Hybrid(q_limit=limit)

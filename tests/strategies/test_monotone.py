"""V never rises at an accepted step, whatever the arm, the pose and the target."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import jtik

from ..conftest import ACCEPTED_RISE, dh_arm, families_first, planar, planar_points, rises

MONOTONE = [
    name
    for name in sorted(jtik.strategies)
    if getattr(jtik.strategies[name](), "acceptance", lambda: "always")() != "always"
]
SOLVERS = {}


def solver(strategy, robot, kind="position"):
    key = (strategy, robot, kind)
    if key not in SOLVERS:
        SOLVERS[key] = jtik.InverseKinematics(robot, jtik.FrameTask("tip", kind), strategy=strategy)
    return SOLVERS[key]


def starts(rng, n, pose):
    return {
        "generic": lambda: rng.uniform(-1, 1, n),
        "far": lambda: rng.uniform(-np.pi, np.pi, n),
        "near-straight 1e-3": lambda: np.append(rng.uniform(-3, 3), 1e-3 * rng.uniform(-1, 1, n - 1)),
        "near-straight 1e-6": lambda: np.append(rng.uniform(-3, 3), 1e-6 * rng.uniform(-1, 1, n - 1)),
        "straight": lambda: np.append(rng.choice([0.0, 0.3]), np.zeros(n - 1)),
        "folded": lambda: np.append(0.0, rng.choice([0.0, np.pi, -np.pi], n - 1)),
    }[pose]()


POSES = ("generic", "far", "near-straight 1e-3", "near-straight 1e-6", "straight", "folded")
PLANAR = {
    "pose": st.sampled_from(POSES),
    "reach": st.floats(0.0, 1.1),
    "on_line": st.booleans(),
    "seed": st.integers(0, 2**32 - 1),
}


def check_planar_arm(strategy, n, pose, reach, on_line, seed):
    rng = np.random.default_rng(seed)
    q0 = starts(rng, n, pose)
    angle = q0[0] if on_line else rng.uniform(-np.pi, np.pi)
    target = reach * n * np.array([np.cos(angle), np.sin(angle)])
    solution = solver(strategy, planar(n)).solve(target, q0=q0, max_iterations=150, trace=True)
    if len(solution.trace):
        assert rises(solution.trace).max(initial=-1) <= ACCEPTED_RISE
        assert np.isfinite(solution.trace.q).all()
    # independently of what the trace says: the error of the iterates themselves
    errors = [np.linalg.norm(planar_points(q)[-1] - target) for q in solution.trace.q]
    assert (np.diff(errors) <= 1e-13 * n).all()


@pytest.mark.quick(5)
@pytest.mark.parametrize("strategy", MONOTONE)
@settings(deadline=None, max_examples=20)
@given(n=st.sampled_from([2, 5]), **PLANAR)
def test_planar_arms(strategy, n, pose, reach, on_line, seed):
    check_planar_arm(strategy, n, pose, reach, on_line, seed)


@pytest.mark.slow
@pytest.mark.parametrize("strategy", MONOTONE)
@settings(deadline=None, max_examples=80)
@given(n=st.sampled_from([3, 7, 12]), **PLANAR)
def test_longer_planar_arms(strategy, n, pose, reach, on_line, seed):
    check_planar_arm(strategy, n, pose, reach, on_line, seed)


def check_spatial_arm(strategy, n, seed, kind):
    robot = dh_arm(n, seed % 5)
    rng = np.random.default_rng(seed)
    target = robot.pose(robot.random_configuration(rng))
    q0 = robot.random_configuration(rng) if seed % 3 else np.zeros(n)
    trace = solver(strategy, robot, kind).solve(target, q0=q0, max_iterations=100, trace=True).trace
    if len(trace):
        assert rises(trace).max(initial=-1) <= ACCEPTED_RISE


SPATIAL = {"kind": st.sampled_from(["position", "pose"])}


@pytest.mark.quick(2)
@pytest.mark.parametrize("strategy", families_first(MONOTONE))
@settings(deadline=None, max_examples=10)
@given(seed=st.integers(0, 2**13).map(lambda k: 5 * k), **SPATIAL)
def test_a_spatial_arm(strategy, seed, kind):
    check_spatial_arm(strategy, 4, seed, kind)


@pytest.mark.slow
@pytest.mark.parametrize("strategy", MONOTONE)
@settings(deadline=None, max_examples=25)
@given(n=st.sampled_from([3, 6, 8]), seed=st.integers(0, 2**13).map(lambda k: 5 * k + 1), **SPATIAL)
def test_longer_spatial_arms(strategy, n, seed, kind):
    check_spatial_arm(strategy, n, seed, kind)


def test_V_rises_without_damping_and_backtracking():
    """The tests above can fail."""
    undamped = jtik.strategies["newton"](q_limit=np.inf, backtracking=False)
    rng = np.random.default_rng(1)
    ik = solver(undamped, planar(10))
    traces = [
        ik.solve((5.0, 0.0), q0=starts(rng, 10, "near-straight 1e-3"), max_iterations=50, trace=True).trace
        for _ in range(10)
    ]
    assert max(rises(trace).max() for trace in traces) > 0.01

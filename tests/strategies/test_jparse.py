"""J-PARSE: the step from the paper's three matrices, its limit cases, and continuity where the formula changes."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik_formulations import JParse

from ..conftest import dh_arm, planar, planar_jacobian, planar_points, shared_solver

BARE = {"backtracking": False, "q_limit": math.inf}


def expected(J, e, threshold=0.1, singular_gain=1.0):
    """J_s+ J_p J_p+ + J_s+ Phi of the paper, matrix by matrix; minus the step."""
    U, sigma, Vt = np.linalg.svd(J, full_matrices=False)
    least = threshold * sigma[0]
    strong = sigma > least
    safe = U @ np.diag(np.maximum(sigma, least)) @ Vt
    projected = U[:, strong] @ np.diag(sigma[strong]) @ Vt[strong]
    weak = U[:, ~strong]
    feedback = weak @ np.diag(singular_gain * sigma[~strong] / least) @ weak.T
    inverse = np.linalg.pinv(safe)
    return (inverse @ projected @ np.linalg.pinv(projected) + inverse @ feedback) @ e


@pytest.mark.thinned
@pytest.mark.parametrize("bend", [1.0, 0.1, 1e-3, 1e-8, 1e-12, 0.0])
@pytest.mark.parametrize("options", [{"threshold": 0.1}, {"threshold": 0.5}, {"threshold": 0.3, "singular_gain": 1.7}])
def test_the_step_of_a_planar_arm(options, bend, rng):
    ik = shared_solver(planar(5), jtik.FrameTask("tip"), strategy=JParse(**options, **BARE))
    for _ in range(10):
        q, target = np.append(0.4, bend * rng.uniform(-1, 1, 4)), rng.uniform(-5, 5, 2)
        wanted = -expected(planar_jacobian(q), planar_points(q)[-1] - target, **options)
        assert ik.step(q, target).q - q == pytest.approx(wanted, rel=1e-8, abs=1e-10)


def test_the_step_in_space(rng):
    robot = dh_arm(7, 3)
    ik = shared_solver(robot, jtik.FrameTask("tip", "pose"), strategy=JParse(threshold=0.3, **BARE))
    for _ in range(10):
        q, goal = robot.random_configuration(rng), robot.random_configuration(rng)
        seen = ik.solve(robot.pose(goal), q0=q, max_iterations=0)
        wanted = -expected(seen.jacobian, seen.error, 0.3)
        assert ik.step(q, robot.pose(goal)).q - q == pytest.approx(wanted, rel=1e-7, abs=1e-9)


def test_at_a_joint_limit_the_joint_pressed_against_it_has_no_column():
    robot = planar(3, lower=-1.0, upper=1.0)
    q, target = np.array([0.2, 0.3, 1.0]), np.array([1.0, 2.5])
    J, e = planar_jacobian(q), planar_points(q)[-1] - target
    assert J[:, 2] @ e < 0
    J[:, 2] = 0
    ik = shared_solver(robot, jtik.FrameTask("tip"), strategy=JParse(threshold=0.1, **BARE))
    assert ik.step(q, target).q == pytest.approx(np.clip(q - expected(J, e, 0.1), -1, 1), abs=1e-9)


def test_a_vanishing_threshold_gives_newtons_step_and_a_threshold_of_one_the_transpose(rng):
    q, target = rng.uniform(-1, 1, 4), np.array([1.0, 2.0])
    J, e = planar_jacobian(q), planar_points(q)[-1] - target
    for threshold, wanted in [(1e-9, np.linalg.pinv(J) @ e), (1.0, J.T @ e / np.linalg.norm(J, 2) ** 2)]:
        ik = shared_solver(planar(4), jtik.FrameTask("tip"), strategy=JParse(threshold=threshold, **BARE))
        assert ik.step(q, target).q - q == pytest.approx(-wanted, abs=1e-10)


def test_it_is_continuous_where_a_direction_becomes_weak():
    """On the two sides of the threshold the step differs by as little as the poses do; with another gain it jumps."""
    q, target, jumps = np.array([0.3, 0.5, 0.4, 0.2]), np.array([2.0, 2.0]), {}
    sigma = np.linalg.svd(planar_jacobian(q), compute_uv=False)
    for gain in (1.0, 0.5):
        steps = []
        for side in (1 - 1e-9, 1 + 1e-9):
            strategy = JParse(threshold=side * sigma[1] / sigma[0], singular_gain=gain, **BARE)
            steps.append(shared_solver(planar(4), jtik.FrameTask("tip"), strategy=strategy).step(q, target).q)
        jumps[gain] = np.abs(steps[1] - steps[0]).max()
    assert jumps[1.0] < 1e-7
    assert jumps[0.5] > 1e-2


@pytest.mark.parametrize("bend", [1e-2, 1e-4, 1e-6, 1e-8])
def test_the_step_along_a_weak_direction_vanishes_with_it(bend):
    """Where Newton's grows like 1 / bend. The error points along the straight arm, its weak direction."""
    ik = shared_solver(planar(3), jtik.FrameTask("tip"), strategy=JParse(threshold=0.1, **BARE))
    q = np.array([0.0, bend, -bend])
    target = planar_points(q)[-1] - (0.5, 0.0)
    assert np.abs(ik.step(q, target).q - q).max() < 20 * bend


@pytest.mark.parametrize(
    ("option", "value"), [("threshold", 0.0), ("threshold", 1.5), ("singular_gain", 0.0), ("q_limit", -1.0)]
)
def test_options_are_checked(option, value):
    with pytest.raises(jtik.ArgumentError, match=option):
        JParse(**{option: value})

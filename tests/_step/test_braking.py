"""What a step with limits of acceleration leaves for later ones: the root of the braking law, and an SVD."""

from __future__ import annotations

import math

import casadi
import numpy as np
import pytest

from jtik._step.braking import IN_TIME, LOST, Braking, initial_braking

from ..conftest import planar, planar_jacobian
from .conftest import numbers, problem_of

Q = np.array([0.4, -0.3, 0.8])
LEFT = np.array([0.2, -0.1])
MOMENTUM = np.array([0.02, 0.01, -0.03])
ACCELERATION = np.array([3.0, math.inf, 8.0])
TIME, CURVATURE = 0.01, 0.3


def braking(q=Q, left=LEFT, time=TIME, curvature=CURVATURE):
    J = planar_jacobian(q)
    state = {"left": casadi.SX(left), "momentum": casadi.SX(MOMENTUM)}
    return J, Braking.of(
        problem_of(planar(3)),
        state,
        casadi.SX(J),
        curvature=casadi.SX(curvature),
        singular=casadi.SX(1e-12 * np.sum(J**2)),
        acceleration=ACCELERATION,
        time=casadi.SX(time),
    )


def test_the_slowest_joint_can_stop_and_uses_its_share_of_the_acceleration():
    J, found = braking()
    share = 1 - numbers(found.shift) @ LEFT / (LEFT @ LEFT)
    assert numbers(found.shift) == pytest.approx((1 - share) * LEFT)
    way = np.abs(np.linalg.solve(J.T @ J + CURVATURE * np.eye(3), J.T @ LEFT))
    change = IN_TIME * ACCELERATION * TIME**2
    rest = share * way + (share * way) ** 2 / (2 * change) - way  # of the way of each joint, beyond its braking
    assert rest.max() == pytest.approx(0, abs=1e-12)
    assert np.argmax(rest) in (0, 2)


@pytest.mark.parametrize(("left", "time"), [(np.zeros(2), TIME), (LEFT, math.inf)])
def test_nothing_is_left_without_an_error_or_a_time(left, time):
    _, found = braking(left=left, time=time)
    assert (numbers(found.shift) == 0).all()


@pytest.mark.parametrize("q", [Q, [0.4, 0.05, 0.0], [0.4, 0.0, 0.0]])
@pytest.mark.parametrize("curvature", [1e-12, 0.01, 0.5])
def test_motion_is_taken_back_in_the_directions_that_the_damping_affects(q, curvature):
    J, found = braking(q=np.array(q), curvature=curvature)
    _, sizes, rows = np.linalg.svd(J, full_matrices=False)
    kept = sizes**2 / (sizes**2 + curvature)
    expected = LOST * rows.T @ ((sizes > 1e-6) * (1 - kept) * (rows @ MOMENTUM))
    assert numbers(found.weak_motion) == pytest.approx(expected, abs=1e-7)


def test_a_robot_begins_at_rest_without_an_error():
    first = initial_braking(problem_of(planar(3)))
    assert {name: value.tolist() for name, value in first.items()} == {"left": [0, 0], "momentum": [0, 0, 0]}

"""The Hessian of the Lagrangian, against differences on angles and on manifolds."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik.strategy.curvature import lagrangian_hessian
from jtik.symbolic import function, symbol, zeros

from ..conftest import ball_arm, dh_arm, floating_arm, planar

STEP, SECOND_DIFFERENCES = 1e-4, 1e-6
"""Truncation 1e-8 times fourth derivatives, and rounding 1e-16 / 1e-8 times values up to 10."""

ROBOTS = {"planar": lambda: planar(4), "dh": dh_arm, "ball": ball_arm, "floating": floating_arm}


def hessian(robot, task):
    """(q, lambda) -> L along v at v = 0 by a function of (q, v, lambda), and its Hessian; with and without the task."""
    q, v, multipliers = symbol("q", robot.nq), symbol("v", robot.n), symbol("multipliers", 3)
    at = symbol("at", robot.nq)
    there = robot.at(at)
    frames = robot.moving_frames
    height = there.position(frames[-1])[0] * there.position(frames[0])[1] + casadi.sumsqr(there.position(frames[1]))
    H = function("H", [at, zeros(0)], [height])
    place = casadi.vertcat(there.position("tip"), 0)[:3]
    r = function("r", [at, zeros(0)], [place])
    lagrangian = H(robot.integrate(q, v), zeros(0))
    if task:
        lagrangian += casadi.dot(multipliers, r(robot.integrate(q, v), zeros(0)))
    hessian = lagrangian_hessian(
        robot, H, r, q=q, target=zeros(0), parameters=zeros(0), multipliers=multipliers if task else None
    )
    return function("L", [q, v, multipliers], [lagrangian]), function("W", [q, multipliers], [hessian])


@pytest.mark.thinned
@pytest.mark.parametrize("task", [True, False])
@pytest.mark.parametrize("name", ROBOTS)
def test_it_is_the_second_difference_of_the_lagrangian(name, task, rng):
    robot = ROBOTS[name]()
    L, W = hessian(robot, task)
    for q in (robot.neutral, robot.random_configuration(rng)):
        multipliers = rng.normal(size=3)
        found = np.array(W(q, multipliers))
        expected = np.zeros((robot.n, robot.n))
        for i, a in enumerate(STEP * np.eye(robot.n)):
            for j, b in enumerate(STEP * np.eye(robot.n)):
                corners = [s * t * float(L(q, s * a + t * b, multipliers)) for s in (1, -1) for t in (1, -1)]
                expected[i, j] = sum(corners) / (4 * STEP**2)
        assert found == pytest.approx(expected, abs=SECOND_DIFFERENCES)
        assert np.array_equal(found, found.T) or np.abs(found - found.T).max() < 1e-12


def test_it_takes_the_multipliers_as_constants_where_they_depend_on_q(rng):
    """Given as expressions of q they are not differentiated."""
    robot = planar(3)
    q = symbol("q", 3)
    there = robot.at(q)
    H = function("H", [q, zeros(0)], [casadi.sumsqr(q)])
    r = function("r", [q, zeros(0)], [there.position("tip")[:2]])
    at = {"q": q, "target": zeros(0), "parameters": zeros(0)}
    varying = function("a", [q], [lagrangian_hessian(robot, H, r, multipliers=casadi.vertcat(q[0] ** 2, q[1]), **at)])
    multipliers = symbol("p", 2)
    constant = function("b", [q, multipliers], [lagrangian_hessian(robot, H, r, multipliers=multipliers, **at)])
    q0 = rng.uniform(-1, 1, 3)
    assert np.array(varying(q0)) == pytest.approx(np.array(constant(q0, [q0[0] ** 2, q0[1]])), abs=1e-14)


def test_a_solution_has_it_with_every_strategy():
    """H = y of the middle joint, tip fixed: the eigenvalue of the one self-motion is the second derivative along it."""

    @jtik.criterion
    def elbow(q, robot):
        return -robot.position(q, "link2")[1]

    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(), criteria=elbow)
    assert ik.solve((2.0, 0.5), q0=[0.5, -0.5, 0.2], optimality_tolerance=1e-8).second_order == "minimum"

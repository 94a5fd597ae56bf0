"""Gradient and Hessian of a criterion against differences, at poses of every kind."""

from __future__ import annotations

import functools

import numpy as np

import jtik
from jtik.robot import Mass
from jtik.symbolic import function, gradient, hessian, symbol

HESSIAN_STEPS = (1e-4, 1e-5, 1e-6)
"""Steps of the central differences of the gradient [rad] or [m]; a correct Hessian agrees at one of them."""

HESSIAN_TOLERANCE = 1e-4
"""Disagreement relative to the largest entry of the Hessian, or to 1."""


@functools.cache
def ten_links():
    """Ten unit links with limits, rods of 1 kg."""
    rod = Mass(1.0, [0.5, 0.0, 0.0], np.diag([0.0, 1 / 12, 1 / 12]))
    robot = jtik.Robot.planar(10, lower=-2.0, upper=1.5)
    return robot.with_masses({f"link{k}": rod for k in range(1, 11)})


@functools.cache
def panda():
    return jtik.Robot.builtin("panda")


@functools.cache
def vehicle():
    """A Panda on a vehicle without limits."""
    return jtik.Robot.builtin("vehicle_panda")


ROBOTS = {"ten": ten_links, "panda": panda, "vehicle": vehicle}


def poses(robot):
    """Poses by kind: generic, at limits, singular (all joints at zero, or nearest to it) and near that."""
    rng = np.random.default_rng(5)
    singular = np.clip(np.zeros(robot.nq), robot.lower, robot.upper)
    lower, upper = (np.where(np.isfinite(limit), limit, 0.0) for limit in (robot.lower, robot.upper))
    at_limits = np.where(rng.random(robot.nq) < 0.5, lower, upper)
    return {
        "generic": robot.random_configuration(rng),
        "another": robot.random_configuration(rng),
        "at limits": at_limits,
        "lower limits": lower,
        "singular": singular,
        "near singular": singular + 1e-4 * rng.standard_normal(robot.nq),
    }


def derivatives(criterion, robot):
    """(q) -> gradient (n,), Hessian (n, n), of a robot with nq = n."""
    q = symbol("q", robot.nq)
    H = criterion(q, robot)
    compiled = function("derivatives", [q], [gradient(H, q), hessian(H, q)])

    def evaluate(at):
        first, second = compiled(at)
        return np.array(first)[:, 0], np.array(second)

    return evaluate


def assert_derivatives(criterion, robot):
    """The contract, whose gradients are compared with differences, and the Hessian at the same poses."""
    jtik.testing.check_criterion(criterion, robot, samples=poses(robot).values())
    evaluate = derivatives(criterion, robot)
    for kind, q in poses(robot).items():
        _, second = evaluate(q)
        assert np.isfinite(second).all(), kind
        scale = max(1.0, np.abs(second).max())
        found = []
        for step in HESSIAN_STEPS:
            columns = [(evaluate(q + step * u)[0] - evaluate(q - step * u)[0]) / (2 * step) for u in np.eye(robot.n)]
            found.append(np.abs(np.array(columns).T - second).max() / scale)
        assert min(found) < HESSIAN_TOLERANCE, (kind, found)

"""The sign of the multipliers: grad H + J' lambda = 0 at an optimum, as the derivations and other solvers have it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

import jtik
from jtik_formulations import JointCentering

from ..conftest import planar, planar_points, shared_solver

PREFERRED, TARGET = np.array([0.9, -0.3, 0.4, 0.1]), np.array([2.2, 1.4])


@pytest.mark.parametrize("strategy", ["hybrid", "newton", "hybrid+second_order"])
def test_they_are_those_of_the_lagrangian(strategy):
    robot = planar(4)
    ik = shared_solver(robot, jtik.FrameTask(), criteria=JointCentering(preferred=PREFERRED), strategy=strategy)
    solution = ik.solve(TARGET, q0=[0.5, 0.3, -0.2, 0.4])
    J = np.asarray(robot.jacobian(solution.q, robot.tip))[:2]
    gradient = solution.q - PREFERRED
    assert J.T @ solution.multipliers == pytest.approx(-gradient, abs=1e-5)


def test_they_say_how_the_optimum_changes_with_the_target():
    """dH/dx* = -lambda: of the optimum by SLSQP at targets beside, for the residual r = x - x*."""
    ik = shared_solver(planar(4), jtik.FrameTask(), criteria=JointCentering(preferred=PREFERRED))
    solution = ik.solve(TARGET, q0=[0.5, 0.3, -0.2, 0.4])

    def optimum(target):
        constraint = {"type": "eq", "fun": lambda q: planar_points(q)[-1] - target}
        options = {"ftol": 1e-14, "maxiter": 500}
        return minimize(
            lambda q: 0.5 * np.sum((q - PREFERRED) ** 2), solution.q, constraints=constraint, options=options
        ).fun

    step = 1e-4
    for unit, multiplier in zip(np.eye(2), solution.multipliers, strict=True):
        slope = (optimum(TARGET + step * unit) - optimum(TARGET - step * unit)) / (2 * step)
        assert slope == pytest.approx(-multiplier, rel=1e-3, abs=1e-6)

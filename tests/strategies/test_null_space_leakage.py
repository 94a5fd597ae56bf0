"""No null-space displacement moves the end effector: |J nu| / |J| against Jacobians of the tests' own, in NumPy.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering
from jtik_formulations.strategies._parts.significance import LEAKAGE

from ..conftest import planar_jacobian, shared_solver, slow

pytestmark = pytest.mark.thinned

STRATEGIES = ("damped+second_order", "hybrid+qp", "hybrid", *slow("newton+second_order", "sns_qp", "sns"))
LEXICOGRAPHIC = slow("lexicographic_qp")


def leakages(ik, starts, target, jacobian, iterations=1):
    """|J nu| / |J| of every step from these starts, and the length of each step."""
    runner = ik._engine.runners.traced_solve
    layout, found, starting = runner.fused.record.slices, [], list(runner.q)
    rows = []

    def logged(call, q):
        def both():
            before = q.copy()
            call()
            rows.append((before, runner.record.copy()))

        return both

    runner.calls = tuple(logged(call, q) for call, q in zip(runner.calls, starting, strict=True))
    for q0 in starts:
        ik.solve(target, q0=q0, max_iterations=iterations, trace=True)
    for q, record in rows:
        J, nu, dq = jacobian(q), record[layout["null_space"]], record[layout["dq"]]
        found.append((np.linalg.norm(J @ nu) / np.linalg.norm(J), np.linalg.norm(nu), np.linalg.norm(dq)))
    return np.array(found)


@pytest.mark.quick(1)
@pytest.mark.parametrize("strategy", [*STRATEGIES, *LEXICOGRAPHIC])
def test_noise_of_a_solver_is_not_scaled_up_beside_limits(strategy, rng):
    """Where joints at limits leave no direction, the solution of the quadratic program is noise of 1e-15."""
    arm = jtik.Robot.planar(5, lower=-0.8, upper=0.8)
    ik = shared_solver(arm, jtik.FrameTask("tip"), criteria=JointCentering(), strategy=strategy)
    starts = [arm.random_configuration(rng) for _ in range(100)]
    starts = [np.where(rng.random(5) < 0.5, 0.8 * np.sign(q), q) for q in starts]
    leak, null, step = leakages(ik, starts, [4.0, 0.0], planar_jacobian).T
    assert (leak <= LEAKAGE * np.maximum(null, step)).all()
    assert (null > 1e-3).mean() > 0.1


@pytest.mark.quick(1)
@pytest.mark.parametrize("strategy", [*STRATEGIES, *LEXICOGRAPHIC])
@pytest.mark.parametrize("scale", [1e3, *slow(1e-4)])
def test_on_robots_of_kilometres_and_of_tenths_of_millimetres(strategy, scale, rng):
    arm = jtik.Robot.planar(5 * [scale], lower=-1.0, upper=1.0)

    def jacobian(q):
        return scale * planar_jacobian(q)

    ik = shared_solver(arm, jtik.FrameTask("tip"), criteria=JointCentering(), strategy=strategy)
    starts = [np.clip(1.5 * arm.random_configuration(rng), -1, 1) for _ in range(30)]
    leak, null, step = leakages(ik, starts, [3 * scale, scale], jacobian, iterations=6).T
    assert (leak <= LEAKAGE * np.maximum(null, step)).all()
    assert (null > 1e-3).mean() > 0.1

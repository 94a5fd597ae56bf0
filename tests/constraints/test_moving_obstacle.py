"""An obstacle that moves towards an arm in a control loop: the arm makes way, and its end effector stays."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import shared_solver, slow

SAFE, RADIUS, DT = 0.1, 0.4, 0.02
POSTURE = np.array([1.2, -0.5, -0.5, -0.4, -0.3, -0.2])


def passed(strategy, criteria, seed):
    """Largest error of the end effector [m], and the smallest distance of the links [m], while a circle comes down."""
    rng = np.random.default_rng(seed)
    arm, q = jtik.Robot.planar(6), POSTURE + 0.15 * rng.standard_normal(6)
    measure = ObstacleAvoidance([jtik.Circle((3.0, 2.5), RADIUS)], bodies="links")
    ik = shared_solver(
        arm,
        jtik.FrameTask("tip", kind="position"),
        strategy=strategy,
        criteria=criteria,
        clearances=jtik.Clearance(measure, safe=SAFE),
    )
    target, x, speed = arm.position(q), 3 + 0.5 * rng.standard_normal(), rng.uniform(0.1, 0.3)
    errors, distances = [], []
    for y in np.arange(2.5, 0.6, -speed * DT):
        ik.parameters["clearance.centers"] = [[x, y]]
        q = ik.step(q, target, dt=DT).q
        ends = np.array([arm.position(q, frame) for frame in (arm.base, *arm.moving_frames)])
        points = ends[:-1, None] + np.linspace(0, 1, 50)[:, None] * np.diff(ends, axis=0)[:, None]
        errors.append(np.linalg.norm(ends[-1] - target))
        distances.append(np.linalg.norm(points - [x, y], axis=-1).min() - RADIUS)
    return max(errors), min(distances)


@pytest.mark.quick(1)
@pytest.mark.parametrize("strategy", ["hybrid+qp", "damped+qp", "weighted_qp", "lexicographic_qp"])
@pytest.mark.parametrize("seed", [0, *slow(1, 2)])
def test_the_end_effector_stays(strategy, seed):
    error, distance = passed(strategy, None, seed)
    assert error < 1e-4
    assert distance > SAFE


@pytest.mark.quick(1)
@pytest.mark.parametrize("strategy", ["hybrid+qp", "lexicographic_qp"])
def test_beside_a_criterion(strategy):
    error, distance = passed(strategy, 0.1 * JointCentering(), 0)
    assert error < 3e-3
    assert distance > SAFE

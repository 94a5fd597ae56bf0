"""A control loop builds nothing: neither in its first step nor, after warm_up, where a step stalls."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import families_first, planar, slow
from .conftest import STRATEGIES, new_solver

pytestmark = pytest.mark.thinned(together=True)

STRAIGHT = np.zeros(4)
ON_ITS_LINE = [2.0, 0.0]
"""A target at which the straight arm is a saddle point of the error."""

CLEARANCE = jtik.Clearance(ObstacleAvoidance(jtik.Circle((1.0, 3.0), 0.2), bodies="links"), safe=0.05)


class BuildError(Exception):
    """A function was built."""


@pytest.fixture
def refuse_to_build(monkeypatch):
    """A call after which building any function of CasADi fails."""

    def refuse(*_, **__):
        raise BuildError

    def now():
        monkeypatch.setattr(casadi, "Function", refuse)
        monkeypatch.setattr(casadi, "conic", refuse)

    return now


def check_that_nothing_is_built(strategy, criteria, refuse_to_build, monkeypatch):
    ik = new_solver(planar(4, lower=-2.0, upper=2.0), strategy=strategy, criteria=criteria)
    q = np.array([0.4, 0.3, 0.2, 0.1])
    refuse_to_build()
    assert ik.step(q, [1.0, 2.5]).accepted
    monkeypatch.undo()
    ik.warm_up()
    refuse_to_build()
    assert ik.step(q, [1.0, 2.5], dt=0.01).accepted
    ik.track([[1.0, 2.5]] * 3, q0=q, dt=0.01)


@pytest.mark.quick(2)
@pytest.mark.parametrize("strategy", families_first([*STRATEGIES, "hybrid+qp"], large=False))
def test_neither_the_first_step_nor_after_warm_up_a_timed_step_or_a_path(strategy, refuse_to_build, monkeypatch):
    check_that_nothing_is_built(strategy, JointCentering(), refuse_to_build, monkeypatch)


@pytest.mark.parametrize("strategy", ["hybrid", *slow("weighted_qp", "sns_qp", "jparse")])
def test_nor_without_a_criterion(strategy, refuse_to_build, monkeypatch):
    check_that_nothing_is_built(strategy, None, refuse_to_build, monkeypatch)


@pytest.mark.parametrize("strategy", ["hybrid", "weighted_qp"])
@pytest.mark.parametrize("clearances", [None, CLEARANCE])
@pytest.mark.parametrize("dt", [None, 0.1])
def test_after_warm_up_a_stalled_step_builds_nothing(strategy, clearances, dt, refuse_to_build):
    if clearances and strategy == "hybrid":
        strategy = "hybrid+qp"
    cold, warm = (new_solver(planar(4), strategy=strategy, clearances=clearances) for _ in range(2))
    warm.warm_up()
    refuse_to_build()
    assert warm.step(STRAIGHT, ON_ITS_LINE, dt=dt).escaped
    with pytest.raises(BuildError):  # otherwise this test could not fail
        cold.step(STRAIGHT, ON_ITS_LINE, dt=dt)


def test_after_warm_up_a_strategy_that_accepts_every_step_builds_nothing(refuse_to_build):
    """Its `step` has a function of its own, which evaluates the errors where it ends."""
    strategy = jtik.strategies["damped"](backtracking=False)
    cold, warm = (new_solver(planar(4), strategy=strategy) for _ in range(2))
    warm.warm_up()
    refuse_to_build()
    q = np.array([0.4, 0.3, 0.2, 0.1])
    assert warm.step(q, [1.0, 2.5]).accepted
    assert warm.step(q, [1.0, 2.5], dt=0.01).accepted
    with pytest.raises(BuildError):
        cold.step(q, [1.0, 2.5])


def test_warm_up_changes_no_result():
    """Neither of a step that has begun, nor of a solve."""
    cold, warm = (new_solver(planar(4), criteria=JointCentering()) for _ in range(2))
    q, target = np.array([0.4, 0.3, 0.2, 0.1]), [-1.0, 0.1]
    for _ in range(6):
        one, other = cold.step(q, target), warm.step(q, target)
        warm.warm_up()
        assert one.q.tolist() == other.q.tolist()
        q = one.q
    assert cold.solve(target, q0=q).q.tolist() == warm.solve(target, q0=q).q.tolist()


@pytest.mark.parametrize("velocity", [[0.4, -0.8, 0.0, 0.2], {"joint1": 0.4, "joint2": -0.8, "joint4": 0.2}])
@pytest.mark.parametrize("warm", [True, False])
def test_another_solver_goes_on_with_the_velocity_that_it_is_given(velocity, warm):
    robot, dt = planar(4, lower=-2.0, upper=2.0), 0.01
    limits = jtik.Limits(velocity=1.0, acceleration=5.0)
    ik = jtik.InverseKinematics(robot, jtik.FrameTask("tip", kind="position"), limits=limits)
    q, speed = np.array([0.4, 0.3, 0.2, 0.1]), np.array([0.4, -0.8, 0.0, 0.2])
    if warm:
        ik.step(q, [1.0, 2.5], dt=dt)
    ik.reset(velocity=velocity)
    found = (ik.step(q, [-1.0, 0.5], dt=dt).q - q) / dt
    assert np.abs(found - speed).max() <= 5.0 * dt * (1 + 1e-9)
    assert np.abs(found - speed).max() > 1e-3
    ik.reset()
    assert np.abs(ik.step(q, [-1.0, 0.5], dt=dt).q - q).max() <= 5.0 * dt**2 * (1 + 1e-9)


def test_without_limits_of_acceleration_a_velocity_changes_nothing():
    ik = new_solver(planar(4, lower=-2.0, upper=2.0), strategy="hybrid", criteria=None)
    q = np.array([0.4, 0.3, 0.2, 0.1])
    first = ik.step(q, [1.0, 2.5], dt=0.01).q
    ik.reset(velocity=[1.0, 1.0, 1.0, 1.0])
    assert ik.step(q, [1.0, 2.5], dt=0.01).q.tolist() == first.tolist()

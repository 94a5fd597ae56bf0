"""The other damping rules: steps compared with NumPy at every kind of pose, and properties of each rule."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik_formulations import ConstantDamped, Damped, NakamuraHanafusa, Sugihara, WeightedQP

from ..conftest import dh_arm, planar, planar_jacobian, planar_points, shared_solver

BARE = {"backtracking": False, "q_limit": math.inf}
STRATEGIES = {
    "constant": ConstantDamped(damping=0.02, **BARE),
    "sugihara": Sugihara(bias=0.03, **BARE),
    "nakamura": NakamuraHanafusa(damping=0.05, threshold=0.6, **BARE),
}


def damping(name, J, e):
    if name == "nakamura":
        sigma = np.linalg.svd(J, compute_uv=False)
        mean_square = (sigma**2).mean()
        manipulability = sigma.prod() / mean_square ** (len(sigma) / 2)
        return 0.05 * mean_square * max(1 - manipulability / 0.6, 0) ** 2
    return {"constant": 0.02, "sugihara": e @ e / 2 + 0.03}[name]


def expected(name, J, e):
    """By ordinary least squares of the stacked system [J; sqrt(mu) I] p = [r; 0]."""
    n = J.shape[1]
    stacked = np.vstack([J, math.sqrt(damping(name, J, e)) * np.eye(n)])
    return -np.linalg.lstsq(stacked, np.concatenate([e, np.zeros(n)]), rcond=None)[0]


@pytest.mark.thinned
@pytest.mark.parametrize("bend", [1.0, 1e-3, 1e-8, 1e-12, 0.0])
@pytest.mark.parametrize("name", STRATEGIES)
@pytest.mark.parametrize("n", [2, 3, 10])
def test_the_step_of_a_planar_arm(n, name, bend, rng):
    ik = shared_solver(planar(n), jtik.FrameTask("tip"), strategy=STRATEGIES[name])
    for _ in range(5):
        q, target = np.append(0.4, bend * rng.uniform(-1, 1, n - 1)), rng.uniform(-2, 2, 2)
        step = expected(name, planar_jacobian(q), planar_points(q)[-1] - target)
        assert ik.step(q, target).q - q == pytest.approx(step, rel=1e-8, abs=1e-10)


@pytest.mark.thinned
@pytest.mark.parametrize("name", STRATEGIES)
@pytest.mark.parametrize("kind", ["position", "pose"])
def test_the_step_in_space(kind, name, rng):
    robot = dh_arm(7, 3)
    ik = shared_solver(robot, jtik.FrameTask("tip", kind), strategy=STRATEGIES[name])
    for _ in range(5):
        q = robot.random_configuration(rng)
        target = robot.pose(q + rng.uniform(-0.2, 0.2, 7))
        seen = ik.solve(target, q0=q, max_iterations=0)
        assert ik.step(q, target).q - q == pytest.approx(expected(name, seen.jacobian, seen.error), rel=1e-7, abs=1e-9)


def test_a_joint_at_its_limit_does_not_stop_the_others():
    """The joint that is pushed against its limit has no column; the other joints take the damped step."""
    robot = planar(3, lower=-1.0, upper=1.0)
    q, target = np.array([0.2, 0.3, 1.0]), np.array([1.0, 2.5])
    J, e = planar_jacobian(q), planar_points(q)[-1] - target
    assert J[:, 2] @ e < 0
    J[:, 2] = 0
    for name, strategy in STRATEGIES.items():
        ik = shared_solver(robot, jtik.FrameTask("tip"), strategy=strategy)
        wanted = np.clip(q + expected(name, J, e), -1, 1)
        assert ik.step(q, target).q == pytest.approx(wanted, abs=1e-9)


def test_nakamura_is_newton_in_good_poses_and_damped_in_singular_ones():
    strategy = NakamuraHanafusa(threshold=0.1, **BARE)
    ik, target = shared_solver(planar(3), jtik.FrameTask("tip"), strategy=strategy), np.array([1.0, 1.5])
    good, straight = np.array([0.3, 1.0, 1.0]), np.array([0.3, 1e-9, 0.0])
    for q, damped in [(good, False), (straight, True)]:
        J, e = planar_jacobian(q), planar_points(q)[-1] - target
        newton = np.linalg.norm(np.linalg.pinv(J, rcond=1e-14) @ e)
        length = np.linalg.norm(ik.step(q, target).q - q)
        if damped:
            assert length < 1e-6 * newton
        else:
            assert length == pytest.approx(newton, rel=1e-9)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_nakamura_needs_no_number_for_the_size_of_the_robot(scale):
    q = np.array([0.2, 0.1, -0.1, 0.1])
    steps = []
    for size in (1.0, scale):
        ik = shared_solver(
            jtik.Robot.planar([size] * 4), jtik.FrameTask("tip"), strategy=NakamuraHanafusa(threshold=0.5, **BARE)
        )
        steps.append(ik.step(q, size * np.array([2.0, 1.0])).q - q)
    assert steps[0] == pytest.approx(steps[1], rel=1e-9)


def test_a_bias_costs_the_quadratic_end():
    """With a constant the last steps shrink the error by a fixed factor; without, by ever more."""
    target, factors = np.array([2.0, 1.5]), {}
    for strategy in (Damped(), ConstantDamped(damping=0.1), Sugihara(bias=0.1)):
        ik = shared_solver(planar(4), jtik.FrameTask("tip"), strategy=strategy)
        error = ik.solve(target, q0=np.full(4, 0.5), position_tolerance=1e-10, trace=True).trace.error
        factors[type(strategy)] = error[-1] / error[-2]
    assert factors[Damped] < 1e-5
    assert 1e-3 < factors[ConstantDamped] < 0.5
    assert 1e-3 < factors[Sugihara] < 0.5


@pytest.mark.parametrize("strategy", [ConstantDamped, Sugihara, NakamuraHanafusa])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_constants_are_checked(strategy, value):
    for option in {"damping", "bias", "threshold"} & set(strategy.__dataclass_fields__):
        with pytest.raises(jtik.ArgumentError, match=option):
            strategy(**{option: value})


def test_the_limit_is_checked():
    with pytest.raises(jtik.ArgumentError, match="q_limit"):
        Sugihara(q_limit=0.0)


def step_of(strategy, q, target):
    ik = shared_solver(planar(len(q)), jtik.FrameTask("tip"), strategy=strategy, limits=False)
    return ik.step(q, target).q - q


@pytest.mark.parametrize("textbook", [0.1, 0.5])
def test_the_damping_is_the_square_of_a_textbooks(textbook, rng):
    """Buss, Siciliano et al. and KDL: sum of sigma / (sigma^2 + lambda^2) v u' r."""
    for _ in range(5):
        q, target = rng.uniform(-1, 1, 4), rng.uniform(-2, 2, 2)
        U, sigma, V = np.linalg.svd(planar_jacobian(q), full_matrices=False)
        theirs = -V.T @ (sigma / (sigma**2 + textbook**2) * (U.T @ (planar_points(q)[-1] - target)))
        assert step_of(ConstantDamped(damping=textbook**2, **BARE), q, target) == pytest.approx(theirs, abs=1e-12)


def test_the_damping_by_V_is_twice_lm_damping(rng):
    """Of mink, pink and weighted_qp, whose damping is by |r|^2; against ordinary least squares, too."""
    for _ in range(5):
        q, target = rng.uniform(-1, 1, 4), rng.uniform(-2, 2, 2)
        by_V = step_of(Damped(damping=0.6, **BARE), q, target)
        by_square = step_of(WeightedQP(lm_damping=0.3, damping=1e-14, **BARE), q, target)
        J, e = planar_jacobian(q), planar_points(q)[-1] - target
        stacked = np.vstack([J, math.sqrt(0.3 * e @ e) * np.eye(4)])
        expected = -np.linalg.lstsq(stacked, np.concatenate([e, np.zeros(4)]), rcond=None)[0]
        assert by_V == pytest.approx(expected, abs=1e-12)
        assert by_square == pytest.approx(expected, abs=1e-8)  # the tolerance of a QP solver

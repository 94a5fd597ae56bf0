"""One quadratic program a step: its solution in closed form and by SciPy, the final compromise, refused options."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import lsq_linear, minimize

import jtik
from jtik.constraints.limits import AT_LIMIT
from jtik.demo.scene import Scene
from jtik_formulations import JointCentering, ObstacleAvoidance, WeightedQP

from ..conftest import ball_arm, dh_arm, planar, report_at, shared_solver

BARE = {"backtracking": False, "q_limit": math.inf}

SOLVED = 1e-9
"""Accuracy of DAQP divided by the smallest curvature of these quadratic programs."""

OPTIMALITY = 1.01e-6
"""The default optimality tolerance of a solve, and rounding."""

ROUNDING = 1e-11
"""Error of the sum relative to its value: V is divided by weights down to 1e-5."""

FIELD = [jtik.Circle((4.0, 2.0), 0.6), jtik.Circle((5.5, -1.0), 0.8)]


def solver(robot, strategy, kind="position", criteria=None, **options):
    return shared_solver(robot, jtik.FrameTask("tip", kind), criteria=criteria, strategy=strategy, **options)


def oracle(strategy, seen, gradient, low, high):
    """The same QP as bounded linear least squares: rows of the task, of the damping and of the criterion."""
    J, r = seen.jacobian, seen.error
    mu = strategy.damping + strategy.lm_damping * strategy.gain**2 * r @ r
    P = J.T @ J + mu * np.eye(J.shape[1])
    q = strategy.gain * J.T @ r
    if gradient is not None:
        P, q = P + strategy.weight * strategy.curvature * np.eye(len(q)), q + strategy.weight * gradient
    root = np.linalg.cholesky(P).T
    return lsq_linear(root, -np.linalg.solve(root.T, q), (low, high), tol=1e-15, lsmr_tol=1e-15).x


@pytest.mark.thinned
@pytest.mark.parametrize("gain", [1.0, 0.4])
@pytest.mark.parametrize("with_criterion", [False, True])
def test_a_step_is_the_minimum_of_the_weighted_sum(gain, with_criterion, rng):
    strategy = WeightedQP(gain=gain, lm_damping=0.3, damping=1e-3, weight=0.02, curvature=1.7, **BARE)
    criteria = JointCentering() if with_criterion else None
    for robot, kind in ((planar(6), "position"), (dh_arm(7, 2), "pose"), (dh_arm(4, 1), "pose")):
        ik = solver(robot, strategy, kind, criteria=criteria)
        for _ in range(5):
            q = rng.uniform(-1, 1, robot.n)
            target = robot.pose(q + rng.uniform(-0.2, 0.2, robot.n))
            seen = report_at(ik, q, target)
            J, e = seen.jacobian, seen.error
            damping = (
                strategy.damping
                + strategy.lm_damping * gain**2 * e @ e
                + with_criterion * strategy.weight * strategy.curvature
            )
            gradient = gain * J.T @ e + with_criterion * strategy.weight * seen.gradient
            ik.reset()
            dq = ik.step(q, target).q - q
            assert dq == pytest.approx(-np.linalg.solve(J.T @ J + damping * np.eye(robot.n), gradient), abs=SOLVED)


@pytest.mark.parametrize("pose", ["generic", "at a limit", "straight at a limit"])
def test_limits_are_its_box(pose, rng):
    """Compared with SciPy's bounded least squares; the step limit is part of the same box."""
    robot = planar(6, lower=-0.5, upper=0.5)
    strategy = WeightedQP(lm_damping=0.1, damping=1e-3, weight=0.05, q_limit=0.2, backtracking=False)
    ik = solver(robot, strategy, criteria=JointCentering(preferred=np.full(6, 0.3)))
    active = 0
    for _ in range(10):
        q = {
            "generic": lambda: rng.uniform(-0.5, 0.5, 6),
            "at a limit": lambda: rng.choice([-0.5, 0.1, 0.5], 6),
            "straight at a limit": lambda: np.append(0.5, np.zeros(5)),
        }[pose]()
        target = rng.uniform(-4, 4, 2)
        seen = report_at(ik, q, target)
        low, high = np.maximum(-0.5 - q, -0.2), np.minimum(0.5 - q, 0.2)
        apart = np.where(high - low < 1e-12, 1e-12, 0)
        ik.reset()
        dq = ik.step(q, target).q - q
        assert dq == pytest.approx(oracle(strategy, seen, seen.gradient, low - apart, high + apart), abs=1e-7)
        assert (dq >= low - 1e-15).all()
        assert (dq <= high + 1e-15).all()
        active += int(((dq < low + 1e-12) | (dq > high - 1e-12)).sum())
    assert active  # the box mattered


@pytest.mark.quick(2)
@pytest.mark.parametrize("weight", [1.0, 1e-2, 1e-4, 1e-6])
def test_it_ends_where_task_and_criterion_pull_equally(weight):
    """J' r + weight grad H = 0: the error is weight times the multiplier of the task, and the solve says so."""
    strategy = WeightedQP(weight=weight)
    ik = solver(planar(5), strategy, criteria=JointCentering())
    solution = ik.solve([2.0, 1.5], q0=[0.3] * 5, position_tolerance=1e-9)
    balance = solution.jacobian.T @ solution.error + weight * solution.gradient
    assert np.linalg.norm(balance) <= OPTIMALITY * weight * max(1, np.linalg.norm(solution.gradient))
    multiplier = np.linalg.lstsq(solution.jacobian.T, solution.gradient, rcond=None)[0]
    assert solution.error == pytest.approx(-weight * multiplier, rel=1e-3)
    assert solution.multipliers == pytest.approx(-multiplier, rel=1e-3)
    assert solution.status is jtik.Status.COMPROMISE
    assert not solution.converged
    assert f"error / multiplier {weight:.3g}" in repr(solution)


def test_within_the_tolerance_the_compromise_has_converged():
    ik = solver(planar(5), WeightedQP(weight=1e-5), criteria=JointCentering())
    for tolerance, status in ((1e-4, jtik.Status.CONVERGED), (1e-6, jtik.Status.COMPROMISE)):
        solution = ik.solve([2.0, 1.5], q0=[0.3] * 5, position_tolerance=tolerance)
        assert solution.status is status
        assert solution.converged == (status is jtik.Status.CONVERGED)
        assert ik.solve_batch([[2.0, 1.5]], q0=[0.3] * 5, position_tolerance=tolerance).status == (status,)


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("case", "weight"),
    [
        pytest.param(case, weight, marks=[] if (row + column) % 3 == 0 else pytest.mark.slow)
        for row, case in enumerate(["free", "limits", "obstacles", "pose"])
        for column, weight in enumerate([1e-1, 1e-3, 1e-5])
    ],
)
def test_the_compromise_is_a_minimum_of_the_weighted_sum(weight, case, rng):
    """SciPy, from there and within the limits, finds no smaller sum, and its multipliers have the right sign."""
    robot, kind, criteria = {
        "free": lambda: (planar(6), "position", JointCentering()),
        "limits": lambda: (planar(6, lower=-0.8, upper=0.8), "position", JointCentering(preferred=[0.9, -0.9] * 3)),
        "obstacles": lambda: (planar(8), "position", JointCentering() + 0.3 * ObstacleAvoidance(FIELD)),
        "pose": lambda: (dh_arm(7, 2), "pose", JointCentering()),
    }[case]()
    ik = solver(robot, WeightedQP(weight=weight), kind, criteria=criteria)
    bounds, active = list(zip(robot.lower, robot.upper, strict=True)), 0
    for _ in range(4):
        near = rng.uniform(-0.7, 0.7, robot.n)
        target = robot.pose(near)
        solution = ik.solve(target, q0=near + rng.uniform(-0.1, 0.1, robot.n), position_tolerance=1e-12)

        def total(q, target=target):
            seen = report_at(ik, q, target)
            slope = seen.jacobian.T @ seen.error / weight + seen.gradient
            return seen.error @ seen.error / 2 / weight + seen.cost, slope

        value, slope = total(solution.q)
        at_lower, at_upper = solution.q <= robot.lower + AT_LIMIT, solution.q >= robot.upper - AT_LIMIT
        slope[(at_lower & (slope > 0)) | (at_upper & (slope < 0))] = 0
        assert np.linalg.norm(slope) <= OPTIMALITY * max(1, np.linalg.norm(solution.gradient))
        found = minimize(total, solution.q, jac=True, bounds=bounds, options={"maxiter": 200, "ftol": 0, "gtol": 1e-10})
        assert found.fun >= value - ROUNDING * (1 + abs(value))
        assert found.x == pytest.approx(solution.q, abs=1e-3)
        active += int((at_lower | at_upper).sum())
    assert bool(active) == (case == "limits")


def test_a_long_way_to_the_compromise_takes_few_steps():
    """Steps near the target that ignore the second derivatives are of the order weight^(1/3), and took 150 to 2000."""
    scene = Scene()
    ik = scene.solver("weighted_qp")
    for target in scene.path(4):
        solution = ik.solve(target, q0=scene.start)
        assert solution.status is jtik.Status.COMPROMISE
        assert solution.iterations <= 60


def test_steps_without_a_time_know_when_they_do_not_follow_each_other():
    """A configuration that the last step did not lead to says nothing about the second derivatives."""
    ik = solver(planar(5), WeightedQP(weight=1e-2), criteria=JointCentering())
    q, target, elsewhere = np.full(5, 0.3), [2.0, 1.5], np.full(5, -0.4)
    ik.reset()
    fresh = ik.step(q, target).q
    ik.reset()
    ik.step(elsewhere, target)
    assert ik.step(q, target).q == pytest.approx(fresh, abs=SOLVED)


@pytest.mark.quick(2)
@pytest.mark.parametrize(
    ("weight", "beyond", "status"),
    [
        (1e-5, 1.5, jtik.Status.LOCAL_MINIMUM),
        (1e-5, 1.01, jtik.Status.LOCAL_MINIMUM),
        (1e-5, 0.99, jtik.Status.COMPROMISE),
        (1e-2, 0.99, jtik.Status.COMPROMISE),
        (1.0, 0.5, jtik.Status.COMPROMISE),
    ],
)
def test_a_target_out_of_reach_is_no_compromise(weight, beyond, status):
    ik = solver(planar(5), WeightedQP(weight=weight), criteria=JointCentering(preferred=[0.5] * 5))
    assert ik.solve([3.0 * beyond, 4.0 * beyond], q0=[0.3] * 5).status is status


def test_limits_in_the_way_are_no_compromise():
    arm = planar(4, lower=-0.2, upper=0.2)
    ik = solver(arm, WeightedQP(weight=1e-5), criteria=JointCentering())
    solution = ik.solve(planar(4).pose([0.2, 0.2, 0.4, 0.2]), q0=[0.1] * 4)
    assert solution.status is jtik.Status.LIMITS


@pytest.mark.slow
def test_the_weighted_sum_falls_at_every_step_taken(rng):
    strategy = WeightedQP(weight=1e-3, curvature=0.2)
    for robot, kind in ((planar(8), "position"), (dh_arm(7, 1), "pose"), (ball_arm(), "position")):
        ik = solver(robot, strategy, kind, criteria=JointCentering())
        for _ in range(2):
            q = robot.random_configuration(rng)
            target = robot.pose(robot.random_configuration(rng))
            trace = ik.solve(target, q0=q, max_iterations=60, trace=True).trace
            total = trace.V + strategy.weight * trace.H
            assert (np.diff(total) <= 1e-13 * total[:-1]).all()


@pytest.mark.parametrize("bend", [0.0, 1e-9, 1e-6, 1e-3])
def test_a_straight_arm_is_pulled_inwards(bend):
    solution = solver(planar(5), "weighted_qp").solve([3.0, 0.0], q0=bend * np.array([0.0, 1.0, -1.0, 1.0, 1.0]))
    assert solution.converged


@pytest.mark.parametrize(
    "options",
    [
        {"gain": 0.0},
        {"gain": 1.5},
        {"lm_damping": -1.0},
        {"damping": 0.0},
        {"weight": -1.0},
        {"weight": math.inf},
        {"curvature": 0.0},
        {"q_limit": math.nan},
    ],
)
def test_options_out_of_range_are_refused(options):
    with pytest.raises(jtik.ArgumentError, match=next(iter(options))):
        WeightedQP(**options)


@pytest.mark.slow
def test_a_step_grows_with_the_square_of_the_joints():
    """What a quadratic program needs of its data; a factorisation of P written out would need the cube."""
    counts = []
    for n in (20, 40):
        ik = solver(jtik.Robot.planar(n), "weighted_qp", criteria=JointCentering())
        parts = ik._engine.runners.solve.fused.parts
        functions = [
            parts.local,
            *parts.stages,
            *parts.data,
            *(each for call in parts.calls for each in call.functions),
        ]
        counts.append(sum(each.n_instructions() for each in functions))
    assert counts[1] <= 4.2 * counts[0]

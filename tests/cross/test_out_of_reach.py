"""Targets out of reach, near and far: the closest posture, by SciPy, and a status that says so.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import functools
import math
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import jtik
from jtik_formulations import JParse

from ..conftest import large_ones_slow, planar, shared_solver, slow

pytestmark = pytest.mark.thinned

FACTORS = [1.5, 10.0, 100.0, 1e4, 1e9]
"""Distances of targets, relative to the reach of the arm."""

ELSEWHERE = ("damped_constant", "jparse", "mink", "nakamura", "newton", "task_priority", "weighted_least_norm")
"""Strategies whose docs say that they do not find the closest posture."""

SLOW = ("selectively_damped", "transpose")
"""Strategies whose docs say that they approach it linearly: up to 100 times the reach not in 1000 iterations."""

FINDERS = [*[name for name in jtik.strategies if name not in ELSEWHERE], JParse(threshold=0.1)]


@functools.cache
def starts():
    rng = np.random.default_rng(0)
    return [(rng.uniform(-2, 2, 4), rng.uniform(-math.pi, math.pi)) for _ in range(6)]


def closest(robot, target, q):
    """The point that SciPy reaches from q, within the limits, of a target in the same direction that is not so far."""
    nearer = target * min(1.0, 1e3 / np.linalg.norm(target))
    inside = np.clip(q, robot.lower + 1e-9, robot.upper - 1e-9)
    found = least_squares(
        lambda q: robot.position(q) - nearer,
        inside,
        bounds=(robot.lower, robot.upper),
        jac=lambda q: robot.jacobian(q)[: len(target)],
        xtol=1e-15,
        ftol=1e-15,
        gtol=1e-13,
        max_nfev=100,
    )
    return robot.position(found.x)


@functools.cache
def solver_of(strategy):
    return shared_solver(planar(4), jtik.FrameTask(), strategy=strategy)


@functools.cache
def solver_of_arm(name, kind, strategy):
    return shared_solver(jtik.Robot.builtin(name), jtik.FrameTask(kind=kind), strategy=strategy)


def test_the_docs_say_which_strategies_do_not_find_it_and_how_often():
    rows = (Path(__file__).parents[2] / "formulations" / "README.md").read_text(encoding="utf-8").splitlines()
    for name in (*ELSEWHERE, *SLOW, "sugihara"):
        doc = " ".join(jtik.strategies[name].__doc__.split())
        assert re.search(r"out of reach.* of \d+ solves", doc), name
        assert any(row.startswith(f"| `{name}` |") and re.search(r"out of reach.* of \d+", row) for row in rows), name


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("strategy", large_ones_slow(FINDERS), ids=str)
def test_a_planar_arm_ends_at_the_closest_posture_and_says_so(strategy, factor):
    robot, ik = planar(4), solver_of(strategy)
    for q0, angle in starts():
        direction = np.array([math.cos(angle), math.sin(angle)])
        solution = ik.solve(factor * 4 * direction, q0=q0)
        assert solution.status is jtik.Status.LOCAL_MINIMUM, (factor, q0, angle)
        assert np.linalg.norm(robot.position(solution.q) - 4 * direction) < 4e-3  # the straight arm


@pytest.mark.parametrize("factor", [1.5, 1e9])
@pytest.mark.parametrize("strategy", large_ones_slow(["hybrid", "damped", "weighted_qp", "lexicographic_qp"]))
def test_within_limits_it_ends_where_scipy_ends(strategy, factor):
    robot = planar(4, lower=-1.0, upper=1.0)
    ik = shared_solver(robot, jtik.FrameTask(), strategy=strategy)
    for q0, angle in starts():
        target = 4 * factor * np.array([math.cos(angle), math.sin(angle)])
        solution = ik.solve(target, q0=q0)
        assert solution.status is (jtik.Status.LOCAL_MINIMUM if abs(angle) < 1 else jtik.Status.LIMITS)
        assert np.linalg.norm(robot.position(solution.q) - closest(robot, target, solution.q)) < 4e-3


@pytest.mark.quick(2)
@pytest.mark.parametrize("strategy", [*ELSEWHERE])
def test_the_others_do_not_claim_it(strategy):
    """A status is of the configuration, whatever the strategy: "out of reach" only at the closest posture."""
    robot, ik = planar(4), solver_of(strategy)
    for q0, angle in starts()[:2]:
        target = 40 * np.array([math.cos(angle), math.sin(angle)])
        solution = ik.solve(target, q0=q0, max_iterations=300)
        off = np.linalg.norm(robot.position(solution.q) - closest(robot, target, solution.q))
        assert (solution.status is jtik.Status.LOCAL_MINIMUM) <= (off < 4e-3)


@pytest.mark.quick(2)
@pytest.mark.parametrize("factor", [1.5, 10.0, 1e9])
@pytest.mark.parametrize("kind", ["position", "pose"])
@pytest.mark.parametrize("strategy", large_ones_slow(["hybrid", "damped", "weighted_qp"]))
def test_a_spatial_arm(strategy, kind, factor):
    ik = solver_of_arm("ur5", kind, strategy)
    robot, rng = ik.robot, np.random.default_rng(2)
    for _ in range(3):
        q0, direction = robot.random_configuration(rng), rng.normal(size=3)
        target = np.eye(4)
        target[:3, 3] = factor * 0.95 * direction / np.linalg.norm(direction)
        solution = ik.solve(target, q0=q0)
        assert solution.status in (jtik.Status.LOCAL_MINIMUM, jtik.Status.LIMITS)
        if kind == "position" or factor == 1e9:  # there the position alone decides
            again = closest(robot, target[:3, 3], solution.q)
            assert np.linalg.norm(robot.position(solution.q) - again) < 1e-3 * 0.95


POSES = [name for name in jtik.strategies if name not in ELSEWHERE]


@pytest.mark.parametrize("factor", [100.0, 1e3, 1e4, 1e5])
@pytest.mark.parametrize("strategy", large_ones_slow(POSES))
def test_a_pose_is_said_to_be_out_of_reach_while_its_orientation_converges(strategy, factor):
    """V hardly depends on the orientation there, and the position has long arrived: within 1e-3 of the reach."""
    ik = solver_of_arm("ur5", "pose", strategy)
    robot, rng = ik.robot, np.random.default_rng(2)
    for _ in range(2):
        q0, direction = robot.random_configuration(rng), rng.normal(size=3)
        target = robot.pose(robot.random_configuration(rng))
        target[:3, 3] = factor * direction / np.linalg.norm(direction)
        solution = ik.solve(target, q0=q0)
        assert solution.status in (jtik.Status.LOCAL_MINIMUM, jtik.Status.LIMITS)
        missed = np.linalg.norm(robot.position(solution.q) - closest(robot, target[:3, 3], solution.q))
        if factor >= 1e4:  # nearer, the orientation has a weight in where the position ends
            assert missed < 1e-3 * 0.95


def turned(robot, q, angle):
    """The configuration with the last joint turned."""
    turn = np.zeros(robot.n)
    turn[-1] = angle
    return robot.integrate(q, turn)


@pytest.mark.quick(1)
@pytest.mark.parametrize("strategy", ["hybrid", "damped"])
@pytest.mark.parametrize("name", ["ur5", "panda"])
def test_the_orientation_of_a_distant_pose_is_the_nearest(name, strategy):
    """The last joint turns the end effector about its own axis. No other angle of it is nearer, at any distance."""
    ik = solver_of_arm(name, "pose", strategy)
    robot, iterations = ik.robot, []
    for factor in [1e3, 1e5, 1e7, 1e9]:
        rng = np.random.default_rng(2)
        for _ in range(3):
            q0, direction = robot.random_configuration(rng), rng.normal(size=3)
            target = robot.pose(robot.random_configuration(rng))
            target[:3, 3] = factor * direction / np.linalg.norm(direction)
            solution = ik.solve(target, q0=q0)
            iterations.append(solution.iterations)
            assert robot.position(turned(robot, solution.q, 0.5)) == pytest.approx(robot.position(solution.q), abs=1e-9)
            for angle in (-0.5, -0.02, 0.02, 0.5):
                q = turned(robot, solution.q, angle)
                if robot.lower[-1] <= q[-1] <= robot.upper[-1]:
                    assert angle_between(robot.pose(q), target) > angle_between(robot.pose(solution.q), target)
    assert np.median(iterations) < (600 if strategy == "hybrid" else 900)


def angle_between(one, other):
    """Angle of the rotation from one pose to the other [rad]."""
    return np.linalg.norm(Rotation.from_matrix(one[:3, :3].T @ other[:3, :3]).as_rotvec())


@pytest.mark.quick(1, slow=5)
@pytest.mark.parametrize("kind", ["position", "pose"])
@pytest.mark.parametrize(
    "strategy", ["hybrid", "damped", *slow(*(name for name in POSES if name not in ("hybrid", "damped")))]
)
def test_an_arm_within_its_limits(strategy, kind):
    """Joints stop at their limits on the way; the others go on to the closest posture."""
    ik = solver_of_arm("panda", kind, strategy)
    robot = ik.robot
    for factor in [1e3, 1e6, 1e9] if strategy in SLOW else [1.5, 10.0, 100.0, 1e3, 1e6, 1e9]:
        rng = np.random.default_rng(2)
        for _ in range(3):
            q0, direction = robot.random_configuration(rng), rng.normal(size=3)
            target = robot.pose(robot.random_configuration(rng))
            target[:3, 3] = factor * direction / np.linalg.norm(direction)
            solution = ik.solve(target[:3, 3] if kind == "position" else target, q0=q0)
            assert solution.status in (jtik.Status.LOCAL_MINIMUM, jtik.Status.LIMITS), factor
            if kind == "position" or factor >= 1e6:  # there the position alone decides
                missed = np.linalg.norm(robot.position(solution.q) - closest(robot, target[:3, 3], solution.q))
                assert missed < 1e-3, factor  # [m], of a reach of about 1.2 m


@pytest.mark.parametrize("strategy", ["hybrid", "selectively_damped", "transpose"])
def test_a_solve_that_ends_close_to_the_closest_posture_says_so(strategy):
    """Also at the iteration limit: the closest distance is 2 m, of a reach of 4 m."""
    ik = solver_of(strategy)
    said, not_said = 0, 0
    for q0, angle in starts():
        for limit in (1, 3, 10, 20, 40, 80, 160):
            target = 6 * np.array([math.cos(angle), math.sin(angle)])
            solution = ik.solve(target, q0=q0, max_iterations=limit)
            missed = solution.position_error - 2.0
            if solution.status is jtik.Status.LOCAL_MINIMUM:
                said += 1
                assert missed < 4e-4
            else:
                not_said += 1
                assert missed > 4e-6
    assert said
    assert not_said


def test_early_ends_and_folded_arms_are_not_called_out_of_reach():
    """The position is on its way, or at a saddle point: a status of a distant target is of first and second order."""
    ik = solver_of_arm("ur5", "pose", "hybrid")
    robot = ik.robot
    target = robot.pose(robot.home)
    target[:3, 3] = 1e4 * np.array([0.6, -0.5, 0.4])
    early = ik.solve(target, max_iterations=5)
    assert early.status is jtik.Status.ITERATION_LIMIT
    folded = np.array([0.0, math.pi, 0.0, 0.0])
    solver = solver_of("hybrid")
    assert solver.solve((-4e4, 0.0), q0=folded, max_iterations=0).status is not jtik.Status.LOCAL_MINIMUM


@pytest.mark.quick(2)
@pytest.mark.parametrize("strategy", ["hybrid", "newton", "damped_constant", "task_priority", "transpose"])
def test_a_solve_that_says_stalled_is_not_at_a_stationary_point(strategy):
    """SciPy goes on from there, as far as rounding allows to see."""
    robot, ik = planar(3), shared_solver(planar(3), jtik.FrameTask(), strategy=strategy)
    rng, stalled = np.random.default_rng(3), 0
    for _ in range(30):
        target = rng.uniform(1.02, 2) * 3 * np.array([1.0, 0.0])
        solution = ik.solve(target, q0=rng.uniform(-2, 2, 3))
        if solution.status is jtik.Status.STALLED:
            stalled += 1
            better = closest(robot, target, solution.q)
            assert np.linalg.norm(better - target) < solution.position_error - 1e-9
    assert stalled or strategy != "newton"

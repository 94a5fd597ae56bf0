"""Levels of priority: both recursions by numpy's pseudo-inverse, strictness, conflicts, and the criterion below all."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import minimize

import jtik
from jtik_formulations import JointCentering, TaskPriority

from ..conftest import dh_arm, planar, planar_jacobian, planar_points, shared_solver

BARE = {"damping": 0.0, "backtracking": False, "q_limit": math.inf}
STRICT = 1e-10
"""Relative size of what projections may leak: rounding times the condition number of a level, below 1e4 here."""


def expected(levels, rule="recursive", rcond=1e-8):
    """The step by Siciliano and Slotine's recursion, or by Chiaverini's; ``levels`` are pairs (J, r)."""
    n = levels[0][0].shape[1]
    dq, N = np.zeros(n), np.eye(n)
    for J, r in levels:
        free = J @ N
        free[np.linalg.norm(free, axis=1) < 1e-12 * np.linalg.norm(J)] = 0
        inverse = np.linalg.pinv(free, rcond=rcond)
        dq = dq + (inverse @ (-r - J @ dq) if rule == "recursive" else -N @ np.linalg.pinv(J, rcond=rcond) @ r)
        N = N - inverse @ free
    return dq


def points(*priorities):
    """End effector, then elbow, then wrist of a planar arm of eight links, with these priorities."""
    frames = ("tip", "link4", "link6")
    tasks = zip(frames, priorities, strict=False)
    return [jtik.FrameTask(frame, name=frame, priority=priority) for frame, priority in tasks]


def solver(tasks, strategy, robot=None, **options):
    return shared_solver(robot or planar(8), tasks, strategy=strategy, **options)


def targets(rng, q):
    robot = planar(8)
    return {frame: robot.pose(q, frame)[:2, 3] + rng.uniform(-0.3, 0.3, 2) for frame in ("tip", "link4", "link6")}


def by_level(ik, q, target, priorities):
    """(J, r) of each level, the highest first."""
    seen = ik.solve(target, q0=q, max_iterations=0)
    rows = {p: [2 * i + k for i, own in enumerate(priorities) if own == p for k in (0, 1)] for p in set(priorities)}
    return [(seen.jacobian[rows[p]], seen.error[rows[p]]) for p in sorted(rows)]


@pytest.mark.thinned
@pytest.mark.parametrize("rule", ["recursive", "robust"])
@pytest.mark.parametrize("priorities", [(0, 1), (1, 0), (3, 0, 7), (0, 1, 1), (2, 2, 1)])
def test_the_step(priorities, rule, rng):
    """In whatever order tasks are given, and with several tasks on a level."""
    ik = solver(points(*priorities), TaskPriority(rule=rule, **BARE))
    for _ in range(5):
        q = rng.uniform(-1, 1, 8)
        target = targets(rng, q)
        target = {task.name: target[task.name] for task in ik.tasks.tasks}
        wanted = expected(by_level(ik, q, target, priorities), rule)
        assert ik.step(q, target).q - q == pytest.approx(wanted, rel=1e-8, abs=1e-10)


@pytest.mark.parametrize("rule", ["recursive", "robust"])
@pytest.mark.parametrize("bend", [0.0, 1e-4, 1e-2])
def test_the_step_of_a_nearly_straight_arm(bend, rule, rng):
    """Straight, both levels lose the direction along the arm; nearly straight, the step is
    long and equal to the formula."""
    ik = solver(points(0, 1), TaskPriority(rule=rule, **BARE))
    q = np.append(0.5, bend * rng.uniform(-1, 1, 7))
    target = {"tip": np.array([6.0, 4.5]), "link4": np.array([3.2, 2.2])}
    wanted = expected(by_level(ik, q, target, (0, 1)), rule)
    assert ik.step(q, target).q - q == pytest.approx(wanted, rel=1e-5, abs=1e-9)


@pytest.mark.parametrize("rule", ["recursive", "robust"])
def test_a_lower_level_does_not_change_what_a_higher_one_does(rule, rng):
    alone, both = (solver(points(*p), TaskPriority(rule=rule, **BARE)) for p in [(0,), (0, 1)])
    for _ in range(20):
        q = rng.uniform(-1, 1, 8)
        target = {"tip": rng.uniform(-6, 6, 2), "link4": rng.uniform(-6, 6, 2)}
        J = planar_jacobian(q)
        step = both.step(q, target).q - q
        own = alone.step(q, target["tip"]).q - q
        assert np.linalg.norm(J @ (step - own)) <= STRICT * np.linalg.norm(J) * np.linalg.norm(step)
        assert np.linalg.norm(step - own) > 1e-3


def test_compatible_levels_are_all_served_at_once_by_the_recursion(rng):
    """Then it is Newton's step for all rows together, up to the free motion: J dq = -r."""
    ik = solver(points(0, 1, 2), TaskPriority(**BARE))
    for _ in range(10):
        q = rng.uniform(-1, 1, 8)
        target = targets(rng, q)
        step = ik.step(q, target).q - q
        for J, r in by_level(ik, q, target, (0, 1, 2)):
            assert J @ step == pytest.approx(-r, abs=1e-9)


def test_a_level_without_remaining_freedom_adds_nothing(rng):
    """The same point twice with another target: its projected rows are rounding, not a direction."""
    tasks = [jtik.FrameTask("tip", name="first"), jtik.FrameTask("tip", name="second", priority=1)]
    for rule in ("recursive", "robust"):
        ik = solver(tasks, TaskPriority(rule=rule, **BARE))
        for _ in range(10):
            q, a, b = rng.uniform(-1, 1, 8), rng.uniform(-5, 5, 2), rng.uniform(-5, 5, 2)
            newton = -np.linalg.pinv(planar_jacobian(q)) @ (planar_points(q)[-1] - a)
            assert ik.step(q, {"first": a, "second": b}).q - q == pytest.approx(newton, abs=1e-10)


def test_one_level_is_newtons_method(rng):
    robot = dh_arm(7, 3)
    strategies = (TaskPriority(), TaskPriority(rule="robust"), "newton")
    for _ in range(3):
        q0, target = rng.uniform(-1, 1, 7), robot.pose(rng.uniform(-1, 1, 7))
        solutions = [
            shared_solver(robot, jtik.FrameTask("tip", "pose"), strategy=strategy).solve(
                target, q0=q0, max_iterations=5
            )
            for strategy in strategies
        ]
        assert solutions[0].q == pytest.approx(solutions[2].q, abs=1e-8)
        assert solutions[1].q == pytest.approx(solutions[2].q, abs=1e-8)


@pytest.mark.parametrize("rule", ["recursive", "robust"])
def test_the_criterion_moves_no_level(rule, rng):
    strategy = TaskPriority(rule=rule, **BARE)
    plain, with_criterion = (solver(points(0, 1), strategy, criteria=c) for c in (None, JointCentering()))
    for _ in range(10):
        q = rng.uniform(-1, 1, 8)
        target = {name: point for name, point in targets(rng, q).items() if name != "link6"}
        null = with_criterion.step(q, target).q - plain.step(q, target).q
        assert np.linalg.norm(null) > 1e-3
        for J, _ in by_level(plain, q, target, (0, 1)):
            assert np.linalg.norm(J @ null) <= STRICT * np.linalg.norm(J) * np.linalg.norm(null)


@pytest.mark.parametrize("rule", ["recursive", "robust"])
def test_of_two_conflicting_tasks_the_lower_is_not_met(rule):
    """End effector at 6 m on the right, elbow at 2 m on the left: only the one of higher priority is met."""
    target, q0 = {"tip": [6.0, 0.0], "link4": [-2.0, 0.5]}, [0.6, -0.4, 0.5, -0.3, 0.2, -0.5, 0.4, 0.3]
    error = {}
    for priorities in ((0, 1), (1, 0)):
        solution = solver(points(*priorities), TaskPriority(rule=rule)).solve(target, q0=q0, max_iterations=800)
        e = solution.error
        error[priorities] = np.array([np.linalg.norm(e[:2]), np.linalg.norm(e[2:])])
        assert not solution.converged
    assert error[0, 1][0] < 1e-6
    assert error[0, 1][1] > 1
    assert error[1, 0][1] < 1e-6
    assert error[1, 0][0] > 1


def test_the_lower_level_of_a_conflict_ends_at_its_constrained_minimum():
    """Against SLSQP: minimum distance of the elbow with the end effector on its target."""
    target, q0 = {"tip": [5.0, 2.0], "link4": [0.5, -2.0]}, np.array([0.3, 0.3, 0.2, 0.3, -0.2, 0.1, 0.3, 0.2])
    solution = solver(points(0, 1), TaskPriority()).solve(target, q0=q0, max_iterations=2000)
    found = minimize(
        lambda q: np.sum((planar_points(q)[2] - target["link4"]) ** 2),
        solution.q,
        method="SLSQP",
        constraints={"type": "eq", "fun": lambda q: planar_points(q)[-1] - target["tip"]},
        options={"ftol": 1e-14, "maxiter": 500},
    )
    e = solution.error
    assert found.success
    assert np.linalg.norm(e[:2]) < 1e-9
    assert np.linalg.norm(e[2:]) == pytest.approx(math.sqrt(found.fun), abs=1e-7)


@pytest.mark.parametrize("rule", ["recursive", "robust"])
def test_below_the_highest_level_inverses_are_damped(rule, rng):
    """By the error of the level, and inside the null space of the one above all the same."""
    ik = solver(points(0, 1), TaskPriority(rule=rule, damping=0.3, backtracking=False, q_limit=math.inf))
    for _ in range(10):
        q = rng.uniform(-1, 1, 8)
        target = {"tip": rng.uniform(-6, 6, 2), "link4": rng.uniform(-6, 6, 2)}
        (J, r), (K, s) = by_level(ik, q, target, (0, 1))
        first, N = -np.linalg.pinv(J) @ r, np.eye(8) - np.linalg.pinv(J) @ J
        A, b = (K @ N, -s - K @ first) if rule == "recursive" else (K, -s)
        second = A.T @ np.linalg.solve(A @ A.T + 0.3 * (b @ b) / 2 * np.eye(2), b)
        assert ik.step(q, target).q - q == pytest.approx(first + N @ second, rel=1e-8, abs=1e-10)


def test_within_joint_limits_the_highest_level_is_still_served(rng):
    robot = planar(8, lower=-0.8, upper=0.8)
    ik = solver(points(0, 1), "task_priority", robot)
    for _ in range(5):
        goal = rng.uniform(-0.7, 0.7, 8)
        target = {"tip": robot.pose(goal)[:2, 3], "link4": np.array([-2.0, 0.0])}
        solution = ik.solve(target, q0=rng.uniform(-0.5, 0.5, 8), max_iterations=1000, trace=True)
        assert np.abs(solution.trace.q).max() <= 0.8
        assert np.linalg.norm(solution.error[:2]) < 1e-3


def test_options_are_checked():
    with pytest.raises(jtik.ArgumentError, match="rule"):
        TaskPriority(rule="exact")
    with pytest.raises(jtik.ArgumentError, match="q_limit"):
        TaskPriority(q_limit=0.0)
    with pytest.raises(jtik.ArgumentError, match="damping"):
        TaskPriority(damping=-1.0)
    with pytest.raises(jtik.ArgumentError, match="lexicographic_qp"):
        TaskPriority(secondary=jtik.secondaries["qp"]())

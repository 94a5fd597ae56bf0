"""Position above orientation on an arm of five joints: the constrained optimum by SciPy, the status and the report.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import jtik
from jtik import Status

from ..conftest import dh_arm, large_ones_slow, planar, shared_solver

pytestmark = pytest.mark.thinned

LEVELS = large_ones_slow(["task_priority", "lexicographic_qp", "sns", "sns_qp"])
TASKS = (
    jtik.FrameTask(kind="position", name="hand", priority=0),
    jtik.FrameTask(kind="orientation", name="wrist", priority=1),
)


def problems(robot, rng, count=4):
    """A pose that the arm reaches, turned by half a radian, and a start near it."""
    for _ in range(count):
        q = rng.uniform(-1, 1, robot.n)
        pose = robot.pose(q)
        pose[:3, :3] = pose[:3, :3] @ Rotation.from_rotvec(0.5 * rng.normal(size=3)).as_matrix()
        yield {"hand": pose[:3, 3], "wrist": pose}, q + 0.2 * rng.normal(size=robot.n)


def angle(robot, q, target):
    return np.linalg.norm(Rotation.from_matrix(target["wrist"][:3, :3].T @ robot.pose(q)[:3, :3]).as_rotvec())


def optimum(robot, q, target):
    """The smallest angle that SciPy finds from q with the position of the target."""
    found = minimize(
        lambda q: angle(robot, q, target) ** 2,
        q,
        constraints={"type": "eq", "fun": lambda q: robot.position(q) - target["hand"]},
        bounds=np.stack([robot.lower, robot.upper], axis=1),
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 300},
    )
    return np.sqrt(found.fun)


@pytest.mark.parametrize("limit", [np.inf, 1.3])
@pytest.mark.parametrize("strategy", LEVELS)
def test_the_position_is_exact_and_the_orientation_as_near_as_possible(strategy, limit, rng):
    robot = dh_arm(5, 3, limit)
    ik = shared_solver(robot, TASKS, strategy=strategy)
    found = 0
    for target, q0 in problems(robot, rng):
        solution = ik.solve(target, q0=np.clip(q0, -limit, limit))
        if strategy != "lexicographic_qp" and limit < np.inf and solution.status is Status.STALLED:
            assert solution.orientation_error > optimum(robot, solution.q, target) + 1e-3
            continue  # a limit stops them before the optimum
        assert solution.status is Status.PRIORITIES
        assert not solution.converged
        assert solution.position_error < 1e-6
        assert solution.orientation_error < optimum(robot, solution.q, target) + 1e-5
        (relaxed,) = (each for each in solution.relaxed if each.name == "task 'wrist'")
        assert relaxed.unit == "rad"
        assert relaxed.amount == pytest.approx(angle(robot, solution.q, target))
        assert str(relaxed) in repr(solution)
        found += 1
    assert found >= 2


@pytest.mark.parametrize("strategy", LEVELS)
def test_where_both_are_reached_it_is_converged(strategy):
    robot = dh_arm(5, 3)
    ik = shared_solver(robot, TASKS, strategy=strategy)
    pose = robot.pose([0.3, 0.5, -0.4, 0.6, 0.2])
    solution = ik.solve({"hand": pose[:3, 3], "wrist": pose}, q0=[0.2, 0.4, -0.3, 0.5, 0.3])
    assert solution.status is Status.CONVERGED
    assert solution.relaxed == ()


@pytest.mark.parametrize("strategy", large_ones_slow(["lexicographic_qp", "sns", "sns_qp"]))
@pytest.mark.parametrize("factor", [3.0, 1e6])
def test_a_position_out_of_reach_ends_at_its_closest_point(strategy, factor, rng):
    """The lower level has a freedom beside it to first order only, and the end is slow."""
    robot = dh_arm(5, 3)
    ik = shared_solver(robot, TASKS, strategy=strategy)
    alone = shared_solver(robot, TASKS[0], strategy=strategy)
    target, q0 = next(problems(robot, rng))
    target["hand"] = factor * np.array([1.0, 0.5, 0.5])
    solution = ik.solve(target, q0=q0)
    assert solution.status in (Status.LOCAL_MINIMUM, Status.ITERATION_LIMIT)
    assert solution.relaxed == ()
    least = alone.solve(target["hand"], q0=solution.q)
    assert least.status is Status.LOCAL_MINIMUM
    closest = robot.position(least.q)
    assert np.linalg.norm(robot.position(solution.q) - closest) < 1e-2
    if factor < 10:
        assert least.position_error == pytest.approx(solution.position_error, abs=1e-4)


@pytest.mark.parametrize("factor", [1.5, 1e3, 1e9])
def test_a_highest_level_out_of_reach_is_said_where_it_is_and_nowhere_else(factor):
    """The straight arm is the closest posture, and no lower level has a freedom beside it but to first order."""
    robot = planar(4)
    ik = shared_solver(robot, TASKS, strategy="lexicographic_qp")
    angles = np.random.default_rng(2).uniform(-2, 2, (3, 4))
    said = dict.fromkeys((3, 10, 30, 300), 0)
    for limit in said:
        for k, q0 in enumerate(angles):
            direction = np.array([np.cos(k), np.sin(k)])
            target = {"hand": 4 * factor * direction, "wrist": k + 1.0}
            solution = ik.solve(target, q0=q0, max_iterations=limit)
            missed = 4 - robot.position(solution.q) @ direction
            assert (solution.status is Status.LOCAL_MINIMUM) <= (missed < 4e-3)  # 1e-3 of the reach
            said[limit] += solution.status is Status.LOCAL_MINIMUM
    assert said[300] == len(angles)
    assert said[3] == 0


@pytest.mark.quick(0, slow=2)
@pytest.mark.parametrize("factor", [1.5, 10.0, 1e3, 1e9])
def test_within_limits_a_solve_of_levels_out_of_reach_comes_to_rest(factor):
    """It ends where the position alone is closest, at limits, and no turn beside that position is nearer."""
    robot, rng = jtik.Robot.builtin("panda"), np.random.default_rng(2)
    q0, direction = robot.random_configuration(rng), rng.normal(size=3)
    target = {"hand": 1.2 * factor * direction / np.linalg.norm(direction)}
    target["wrist"] = robot.pose(robot.random_configuration(rng))
    solution = jtik.InverseKinematics(robot, TASKS, strategy="lexicographic_qp").solve(target, q0=q0)
    assert solution.status is Status.LIMITS
    alone = jtik.InverseKinematics(robot, TASKS[0]).solve(target["hand"], q0=solution.q)
    assert np.linalg.norm(robot.position(solution.q) - robot.position(alone.q)) < 1e-9
    assert solution.iterations < 100
    beside = {"hand": robot.position(solution.q), "wrist": target["wrist"]}
    assert angle(robot, solution.q, target) < optimum(robot, solution.q, beside) + 1e-4


def test_stopped_on_the_way_it_is_not_claimed(rng):
    robot = dh_arm(5, 3)
    ik = shared_solver(robot, TASKS, strategy="task_priority")
    target, q0 = next(problems(robot, rng))
    solution = ik.solve(target, q0=q0, max_iterations=6)
    assert solution.status is Status.ITERATION_LIMIT
    assert solution.relaxed == ()


def test_a_strategy_without_levels_does_not_claim_them(rng):
    robot = dh_arm(5, 3)
    target, q0 = next(problems(robot, rng))
    solution = shared_solver(robot, TASKS).solve(target, q0=q0)
    assert solution.status is Status.LOCAL_MINIMUM
    assert solution.position_error > 1e-3  # a compromise of both

"""Levels of priority whose highest is out of reach: the solve comes to rest, where SciPy and closed forms say."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

import jtik
from jtik import Status
from jtik._loop.escapes.level_newton import LevelNewton

from ...conftest import dh_arm, planar

TASKS = (
    jtik.FrameTask(kind="position", name="hand", priority=0),
    jtik.FrameTask(kind="orientation", name="wrist", priority=1),
)
Q0 = np.array([0.3, 0.8, -0.4, 1.1])
DIRECTION = np.array([np.cos(0.7), np.sin(0.7)])


def solver(robot, **options):
    return jtik.InverseKinematics(robot, TASKS, strategy="lexicographic_qp", **options)


@pytest.mark.parametrize("factor", [1.1, 10.0, 1e9])
def test_the_straight_arm_has_no_freedom_for_the_orientation(factor):
    robot = planar(4)
    solution = solver(robot).solve({"hand": 4 * factor * DIRECTION, "wrist": 2.0}, q0=Q0)
    assert solution.status is Status.LOCAL_MINIMUM
    assert not solution.converged
    assert solution.iterations < 100
    assert solution.escapes == 0
    assert robot.position(solution.q) == pytest.approx(4 * DIRECTION, abs=1e-12)
    assert solution.orientation_error == pytest.approx(1.3)


def test_the_level_below_uses_the_freedom_that_is_left():
    """Only the last link turns the frame without moving the hand, which is at the end of the third link."""
    robot = planar(4)
    tasks = [jtik.FrameTask("link4", name="hand", priority=0), jtik.FrameTask("tip", name="end", priority=1)]
    ik = jtik.InverseKinematics(robot, tasks, strategy="lexicographic_qp")
    end = 3 * DIRECTION + np.array([2.0, -1.0])
    solution = ik.solve({"hand": 5 * DIRECTION, "end": end}, q0=Q0)
    assert solution.status is Status.LOCAL_MINIMUM
    assert robot.position(solution.q, "link4") == pytest.approx(3 * DIRECTION, abs=1e-9)
    assert robot.position(solution.q) == pytest.approx(3 * DIRECTION + np.array([2.0, -1.0]) / np.sqrt(5), abs=1e-7)


@pytest.mark.parametrize("angle", [0.3, 2.5])
def test_within_limits_it_ends_where_scipy_ends(angle):
    robot = planar(4, lower=-1.0, upper=1.0)
    hand = 6 * np.array([np.cos(angle), np.sin(angle)])
    solution = solver(robot).solve({"hand": hand, "wrist": 2.0}, q0=0.5 * Q0)
    assert solution.status is (Status.LOCAL_MINIMUM if angle < 1 else Status.LIMITS)
    found = least_squares(
        lambda q: robot.position(q) - hand, np.clip(solution.q, -0.999, 0.999), bounds=(-1, 1), xtol=1e-15, gtol=1e-14
    )
    assert solution.position_error <= np.linalg.norm(found.fun) + 1e-9
    assert (abs(solution.q) <= 1).all()


def test_where_all_levels_are_reached_it_is_converged():
    robot = planar(4)
    solution = solver(robot).solve({"hand": [2.0, 1.0], "wrist": 1.0}, q0=Q0)
    assert solution.status is Status.CONVERGED
    assert solution.escapes == 0


def test_q_is_kept_where_the_method_does_not_arrive(monkeypatch):
    monkeypatch.setattr("jtik._loop.escapes.level_newton.STEPS", 2)
    ik, q = solver(planar(4)), Q0.copy()
    ik.solve({"hand": 6 * DIRECTION, "wrist": 2.0}, q0=Q0, max_iterations=1)
    assert not LevelNewton(ik._engine.problem).reach(q, ik._engine.runners.search_inputs)
    assert (q == Q0).all()


def test_a_trace_ends_where_the_solve_ends():
    ik, target = solver(planar(4)), {"hand": 6 * DIRECTION, "wrist": 2.0}
    traced, plain = ik.solve(target, q0=Q0, trace=True), ik.solve(target, q0=Q0)
    assert (traced.trace.q[-1] == traced.q).all()
    assert traced.q == pytest.approx(plain.q)
    assert len(traced.trace) == traced.iterations == plain.iterations


def test_with_restarts_it_ends_so_too():
    robot = planar(4)
    solution = solver(robot).solve({"hand": 6 * DIRECTION, "wrist": 2.0}, q0=Q0, restarts=2)
    assert solution.status is Status.LOCAL_MINIMUM
    assert robot.position(solution.q) == pytest.approx(4 * DIRECTION, abs=1e-12)


@pytest.mark.slow
def test_generated_code_does_the_same():
    target = {"hand": 6 * DIRECTION, "wrist": 2.0}
    answers = [solver(planar(4), compiled=compiled).solve(target, q0=Q0) for compiled in (False, True)]
    assert answers[0].iterations == answers[1].iterations
    assert answers[0].q == pytest.approx(answers[1].q)


def test_an_interruption_changes_nothing_where_the_solve_goes_on():
    """The orientation is not reached beside the position: the solve is interrupted on the way, and repeats the call."""
    robot = dh_arm(5, 3)
    pose, q0 = robot.pose([0.3, 0.5, -0.4, 0.6, 0.2]), [0.2, 0.4, -0.3, 0.5, 0.3]
    pose[:3, :3] = pose[:3, :3] @ Rotation.from_rotvec([0.2, -0.5, 0.3]).as_matrix()
    ik, answers = solver(robot), []
    for pauses in (True, False):
        ik._engine.runners.solve.pauses = pauses
        answers.append(ik.solve({"hand": pose[:3, 3], "wrist": pose}, q0=q0))
    assert answers[0].status is Status.PRIORITIES
    assert answers[0].iterations == answers[1].iterations > 25
    assert (answers[0].q == answers[1].q).all()

"""Joints that can turn all the way round: a search crosses +-180 degrees, and its answer is the nearest turn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import jtik
from jtik._loop.search.full_turns import SHORT_OF_A_TURN, TURN, FullTurns
from jtik.robot import Joint, JointType, Mimic
from jtik_formulations import JointCentering

from ...conftest import planar, shared_solver


def limited(robot, half):
    """The robot with every moving joint between -half and half."""
    joints = [replace(j, lower=-half, upper=half) if j.is_moving else j for j in robot.joints]
    return jtik.Robot(joints, base=robot.base, tip=robot.tip, planar=robot.dimension == 2)


UR5 = limited(jtik.Robot.builtin("ur5"), np.pi)
BEYOND = np.array([3.0, -1.2, 1.5, -0.3, 1.0, 3.0])
"""A start from which the wrap-around is nearer than the way within the limits to the target's configuration."""
TARGET = UR5.pose([-3.0, -1.2, 1.5, -0.3, 1.0, -3.0])


def solver(robot, kind="pose", **options):
    return shared_solver(robot, jtik.FrameTask("tip", kind), **options)


@pytest.mark.quick(3)
@pytest.mark.parametrize(
    ("strategy", "compiled"),
    [
        *((name, False) for name in ("hybrid", "damped", "newton", "weighted_qp", "sns")),
        ("hybrid", True),
        pytest.param("weighted_qp", True, marks=pytest.mark.slow),
    ],
)
def test_a_solve_crosses_180_degrees(strategy, compiled):
    ik = solver(UR5, strategy=strategy, compiled=compiled)
    for _ in range(2):  # the second compiled one takes the shortest way through Python
        solution = ik.solve(TARGET, q0=BEYOND)
        assert solution.converged
        assert solution.iterations < 15
        assert solution.q == pytest.approx([-3.0, -1.2, 1.5, -0.3, 1.0, -3.0], abs=1e-4)
    assert ik.solve_batch([TARGET] * 2, q0=BEYOND).converged.all()


def test_a_step_and_a_path_do_not():
    ik = solver(UR5)
    q = BEYOND
    for _ in range(50):
        after = ik.step(q, TARGET).q
        assert (np.abs(after) <= np.pi).all()
        assert np.abs(after - q).max() < np.pi
        q = after
    path = ik.track([TARGET] * 20, q0=BEYOND, dt=0.1)
    assert (np.abs(path.q) <= np.pi).all()
    assert np.abs(np.diff(path.q, axis=0)).max() < 0.1 * np.pi + 1e-9  # the velocity limit


@pytest.mark.quick(3)
@pytest.mark.parametrize(
    ("half", "compiled"), [(np.pi, False), (2 * np.pi, True), (3 * np.pi, False), (np.inf, False), (np.inf, True)]
)
def test_every_answer_is_the_turn_nearest_to_the_start(half, compiled, rng):
    arm = limited(jtik.Robot.builtin("ur5"), half)
    ik, q0 = solver(arm, compiled=compiled), np.array([0.5, -1.5, 1.5, -1.5, -1.5, 0.1])
    for _ in range(25):
        target = UR5.pose(UR5.random_configuration(rng))
        solution = ik.solve(target, q0=q0, restarts=50)
        assert solution.converged
        assert np.abs(arm.pose(solution.q) - target).max() < 1e-5  # with kinematics of its own, not the solver's
        assert (np.abs(solution.q) <= half).all()
        nearer = solution.q - TURN * np.rint((solution.q - q0) / TURN)
        further = np.abs(solution.q - q0) > np.abs(nearer - q0) + 1e-9
        assert not (further & (np.abs(nearer) < half)).any()


def test_a_start_beyond_its_limits_comes_back_within_them():
    ik = solver(UR5)
    solution = ik.solve(TARGET, q0=BEYOND + 2 * TURN)
    assert solution.converged
    assert (np.abs(solution.q) <= np.pi).all()
    assert (np.abs(ik.solve(TARGET, q0=BEYOND + TURN, max_iterations=0).q) <= np.pi).all()


def test_a_range_that_is_a_little_short_of_a_turn_keeps_its_limits(rng):
    """Where no turn fits, the solve goes on with the limits in force: the answer is always within them."""
    half = np.pi - 0.4 * SHORT_OF_A_TURN
    arm = limited(planar(3), half)
    ik = solver(arm, "pose")
    gap = np.array([np.pi, 0.4, -0.9])  # its first joint is in the gap
    solution = ik.solve(arm.pose(gap), q0=gap - 0.3)
    assert (np.abs(solution.q) <= half).all()
    assert not solution.converged
    assert solution.status in (jtik.Status.LIMITS, jtik.Status.LOCAL_MINIMUM)
    assert "joint1" in solution.active_limits or "q1" in solution.active_limits
    solution = ik.solve(arm.pose(gap), q0=gap - 0.3, restarts=30)  # the same pose with the elbow on the other side
    assert solution.converged
    assert (np.abs(solution.q) <= half).all()


def test_a_criterion_decides_between_the_turns_that_change_it(rng):
    """The answer is the turn nearest to the start, unless H is larger there; and it is stationary within the limits."""
    preferred = np.array([-3.0, 2.0, 1.0, 3.0])
    arm = limited(planar(4), 2 * np.pi)
    ik, kept = solver(arm, "position", criteria=JointCentering(preferred=preferred)), 0
    for _ in range(20):
        q0 = arm.random_configuration(rng)
        solution = ik.solve([1.5, 1.5], q0=q0, max_iterations=3000)
        assert solution.converged
        assert (np.abs(solution.q) <= 2 * np.pi).all()
        assert solution.null_space_residual < 1e-5
        nearest = solution.q - TURN * np.rint((solution.q - q0) / TURN)
        if (np.abs(nearest) <= 2 * np.pi).all():
            kept += int(np.abs(nearest - solution.q).max() > 1)
            assert np.sum((nearest - preferred) ** 2) >= np.sum((solution.q - preferred) ** 2) - 1e-6
    assert kept  # else H would never have decided


def test_limits_that_are_active_stay_so_beside_a_criterion():
    arm = limited(planar(3), np.pi)
    ik = solver(arm, "position", criteria=JointCentering(preferred=[5.0, 0.0, 0.0]))
    solution = ik.solve([1.0, 1.0], q0=[1.0, 1.0, 1.0])
    assert (np.abs(solution.q) <= np.pi).all()
    assert solution.position_error < 1e-6


def turns_of(robot, task):
    ik = shared_solver(robot, task)
    return ik._engine.runners.turns


def test_which_joints_can_turn():
    def joint(name, parent, child, **more):
        return Joint(name, JointType.REVOLUTE, parent, child, axis=(0, 0, 1), **more)

    arm = [
        joint("full", "base", "a", lower=-np.pi, upper=np.pi),
        joint("short", "a", "b", lower=-3.0, upper=3.0, origin=jtik.Robot.planar(1).pose([0.0])),
        joint("leads", "b", "c", origin=jtik.Robot.planar(1).pose([0.0])),
        joint("half", "c", "tip", mimic=Mimic("leads", 0.5, 0.0), origin=jtik.Robot.planar(1).pose([0.0])),
    ]
    robot = jtik.Robot(arm, tip="tip")
    assert turns_of(robot, jtik.FrameTask("tip", "pose")).indices.tolist() == [0]
    arm[3] = joint("whole", "c", "tip", mimic=Mimic("leads", -2.0, 0.0), origin=jtik.Robot.planar(1).pose([0.0]))
    robot = jtik.Robot(arm, tip="tip")
    assert turns_of(robot, jtik.FrameTask("tip", "pose")).indices.tolist() == [0, 2]


def test_nearest_by_hand():
    turns = FullTurns(solver(limited(planar(2), 2 * np.pi))._engine.problem, np.full(2, -5.0), np.full(2, 7.0))
    q, fits = turns.nearest(np.array([0.5 + 3 * TURN, -6.2]), np.array([6.9, 0.0]))
    assert q == pytest.approx([0.5 + TURN, -6.2 + TURN])
    assert fits
    q, fits = turns.nearest(np.array([0.5, -6.2]), np.array([-6.9, 0.0]))
    assert q == pytest.approx([0.5, -6.2 + TURN])  # a turn further would be nearer, but is outside the limits
    assert fits

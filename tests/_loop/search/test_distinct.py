"""What counts as another posture, as a jump, and as the better of two failed attempts."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik._loop.search.ends import Ends, smaller
from jtik.robot.tree import Mimic

from ...conftest import ball_arm, floating_arm, planar, shared_solver, slow
from ..conftest import solver

BOTH = pytest.mark.parametrize("compiled", [False, True], ids=["interpreted", "compiled"])


def ball_robot():
    """A ball joint with a tip 1 m beside it."""
    reach = np.eye(4)
    reach[0, 3] = 1.0
    ball = jtik.Joint("shoulder", jtik.JointType.BALL, "base", "arm")
    return jtik.Robot([ball, jtik.Joint("hand", jtik.JointType.FIXED, "arm", "tip", origin=reach)], tip="tip")


def angle(one, other):
    """The angle of the rotation from one unit quaternion to another [rad]."""
    return 2 * np.arccos(min(1.0, abs(float(one @ other))))


@BOTH
def test_the_restarts_tried_are_counted(compiled):
    """A target that two links reach in one posture only, straight."""
    solution = solver(planar(2), compiled=compiled).solve([2.0, 0.0], q0=[0.1, 0.2], restarts=5, best_of=4)
    assert solution.alternatives == ()
    assert solution.restarts == 5


@pytest.mark.quick(1)
@BOTH
def test_whole_turns_are_no_other_postures(compiled):
    """H prefers joints two turns apart; each of the two postures of the arm is returned at one turn, the better."""

    @jtik.criterion
    def turned(q, robot):
        return (q[0] - 5.0) ** 2 / 100

    arm = planar(2, lower=-6.0, upper=6.0)
    ik = solver(arm, criteria=turned, compiled=compiled)
    solution = ik.solve([1.0, 1.0], q0=[0.2, 0.4], restarts=60, best_of=8)
    found = [solution, *solution.alternatives]
    assert len(found) == 2
    for each in found:
        copies = each.q[0] + 2 * np.pi * np.array([-1, 0, 1])
        copies = copies[np.abs(copies) <= 6.0]
        assert each.q[0] == pytest.approx(min(copies, key=lambda q: (q - 5.0) ** 2), abs=1e-6)


def test_the_jump_of_a_ball_joint_is_the_angle_of_its_rotation():
    """A rotation about (1, 1, 1) by 0.4 rad has three components of 0.23 rad."""
    robot = ball_robot()
    ik = solver(robot, kind="pose")
    q0 = robot.neutral
    there = robot.integrate(q0, np.full(3, 0.4 / np.sqrt(3)))
    assert ik.solve(robot.pose(there), q0=q0, jump_limit=0.41).converged
    beyond = ik.solve(robot.pose(there), q0=q0, jump_limit=0.3)
    assert beyond.status is jtik.Status.JUMP_LIMIT
    assert not beyond.converged


def test_the_jump_of_a_free_joint_is_the_length_of_its_displacement():
    robot = jtik.Robot([jtik.Joint("float", jtik.JointType.FREE, "base", "tip")], tip="tip")
    ik, q0 = solver(robot), robot.neutral
    assert ik.solve([0.2, 0.2, 0.2], q0=q0, jump_limit=0.36).converged
    assert ik.solve([0.2, 0.2, 0.2], q0=q0, jump_limit=0.3).status is jtik.Status.JUMP_LIMIT


@pytest.mark.thinned
@pytest.mark.parametrize("robot", [ball_arm(), floating_arm()], ids=str)
@pytest.mark.parametrize("limit", [0.3, 1.0])
def test_a_goal_within_the_jump_of_ball_and_free_joints_is_reached_from_one_start(robot, limit, rng):
    """That their motion is judged at the end costs nothing there: the steps of the task are short ones."""
    ik = solver(robot, kind="pose")
    for _ in range(10):
        q0 = np.clip(robot.integrate(robot.neutral, rng.uniform(-0.5, 0.5, robot.n)), robot.lower, robot.upper)
        v = rng.normal(size=robot.n)
        v *= 0.9 * limit / np.abs(v).max() / np.sqrt(3) * rng.uniform()
        goal = np.clip(robot.integrate(q0, v), robot.lower, robot.upper)
        solution = ik.solve(robot.pose(goal), q0=q0, jump_limit=limit)
        assert solution.converged
        moved = robot.difference(q0, solution.q)
        assert np.abs(moved).max() <= limit + 1e-9
        for joint in robot.independent_joints:
            for part in np.split(moved[robot.v_slice(joint.name)], 2 if joint.type is jtik.JointType.FREE else 1):
                assert np.linalg.norm(part) <= limit + 1e-9


def test_restarts_stay_within_the_jump_of_a_ball_joint(monkeypatch):
    robot = ball_robot()
    ik, q0 = solver(robot, kind="pose"), robot.neutral
    search = ik._engine.search
    drawn = search._restarts.around(1, 0, q0, search.jump(q0, 0.3))
    angles = [angle(q0, row) for row in drawn.configurations]
    assert 0.2 < max(angles) <= 0.3 + 1e-9


def test_mimic_joints_count():
    """The second joint follows the first and moves ten times as far."""
    link = np.eye(4)
    link[0, 3] = 1.0
    z = np.array([0.0, 0.0, 1.0])
    revolute = jtik.JointType.REVOLUTE
    robot = jtik.Robot(
        [
            jtik.Joint("lead", revolute, "base", "one", axis=z),
            jtik.Joint("follow", revolute, "one", "two", origin=link, axis=z, mimic=Mimic("lead", 10.0)),
            jtik.Joint("hand", jtik.JointType.FIXED, "two", "tip", origin=link),
        ],
        tip="tip",
    )
    ik = shared_solver(robot, jtik.FrameTask("tip", "position"))
    near, far = robot.position([0.02], "tip"), robot.position([0.05], "tip")
    assert ik.solve(near, q0=[0.0], jump_limit=0.3).converged
    solution = ik.solve(far, q0=[0.0], jump_limit=0.3)
    assert solution.q[0] == pytest.approx(0.03, abs=1e-9)
    assert solution.status is jtik.Status.JUMP_LIMIT


def test_ends_are_compared_level_by_level():
    assert smaller((1.0, 9.0), (2.0, 0.0))
    assert smaller((1.0, 1.0), (0.9999, 2.0))  # equal in the first level but for rounding of attempts
    assert not smaller((1.0, 1.0), (0.99, 2.0))
    assert smaller((0.5,), (0.5 + 1e-15,))
    ends = Ends()
    for number, errors in enumerate([(0.0, 5.0), (0.1, 0.0), (0.0, 4.0)]):
        ends.add(number, errors, np.full(1, float(number)))
    assert ends.best is not None
    assert ends.best[1] == 2


@pytest.mark.quick(1)
@BOTH
def test_restarts_choose_by_the_levels_of_priority(compiled):
    """The first level is within reach; the second, 50 m away, has nearly all of V and does not decide."""
    tip, elbow = (
        jtik.FrameTask("tip", "position", name="tip"),
        jtik.FrameTask("link2", "position", name="elbow", priority=2),
    )
    robot = planar(4, lower=-1.2, upper=1.2)
    ik = shared_solver(robot, [tip, elbow], strategy="task_priority", compiled=compiled)
    rng = np.random.default_rng(0)
    kept = 0
    for _ in range(6):
        there = rng.uniform(-1, 1, 4)
        targets = {"tip": robot.position(there, "tip"), "elbow": np.array([-50.0, 20.0])}
        solution = ik.solve(targets, q0=rng.uniform(-1, 1, 4), restarts=20)
        kept += np.linalg.norm(robot.position(solution.q, "tip") - targets["tip"]) < 1e-4
    assert kept == 6


@pytest.mark.slow
def test_a_singular_spherical_wrist_gives_each_posture_once():
    """There the first and the last axis of the wrist are one: any share of the turn between them is on target."""
    half = np.pi / 2
    columns = [(0, half, 0.4), (0.5, 0, 0), (0.05, half, 0), (0, -half, 0.4), (0, half, 0), (0, 0, 0.1)]
    rows = [{"a": a, "alpha": alpha, "d": d, "theta": 0, "lower": -np.pi, "upper": np.pi} for a, alpha, d in columns]
    arm = jtik.Robot.from_dh(rows)
    ik = shared_solver(arm, jtik.FrameTask(arm.tip, "pose"))
    singular = np.array([0.5, -0.7, 0.8, 0.3, 0.0, 0.9])
    solution = ik.solve(arm.pose(singular), q0=np.full(6, 0.3), restarts=40, best_of=16)
    found = [solution, *solution.alternatives]
    postures = {tuple(np.round(arm.position(each.q, "link4"), 2)) for each in found}
    assert 4 <= len(found) <= 8  # 16 where joint positions alone are compared
    assert len(postures) <= 4


@pytest.mark.slow
@pytest.mark.parametrize("bend", [0.0, *slow(1e-6, 1e-5, 1e-4, 1e-2)])
def test_the_singular_wrist_of_a_ur5e_gives_no_posture_twice(bend):
    """Its continuum is curved: three parallel axes and the last one turn together. There are at most 8 postures."""
    arm = jtik.Robot.builtin("ur5e")
    ik = shared_solver(arm, jtik.FrameTask(arm.tip, "pose"))
    rng = np.random.default_rng(0)
    counts = []
    for _ in range(2):
        there = rng.uniform(-2, 2, 6)
        there[4] = bend
        solution = ik.solve(arm.pose(there), q0=np.full(6, 0.3), restarts=60, best_of=16)
        found = [solution, *solution.alternatives]
        counts.append(len(found))
        for each in found:
            assert np.abs(arm.pose(each.q) - arm.pose(there)).max() < 1e-5
    assert max(counts) <= 8
    assert min(counts) >= 3

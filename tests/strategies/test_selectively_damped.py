"""Selectively damped least squares: its steps compared with NumPy, both clamps, several effectors, and bounds."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik_formulations import SelectivelyDamped

from ..conftest import dh_arm, planar, planar_jacobian, planar_points, shared_solver

QUARTER = math.pi / 4


def clamped(step, most, trust, soft):
    """The joint that moves furthest brought to the share ``trust`` of its entry of ``most`` [rad or m]."""
    motion = np.abs(step / most).max()
    if soft:
        return step * trust / (trust + motion) if trust else 0 * step
    return step if motion <= trust else step * trust / motion


def expected(J, e, *, effectors=None, soft=False, max_error=math.inf, most=QUARTER):
    """Buss and Kim's section 4, by numpy's singular value decomposition; minus the step."""
    effectors = [list(range(len(e)))] if effectors is None else [list(rows) for rows in effectors]
    e = e.copy()
    for rows in effectors:
        e[rows] *= min(1, max_error / np.linalg.norm(e[rows]))
    U, sigma, Vt = np.linalg.svd(J, full_matrices=False)
    reach = np.array([[np.linalg.norm(J[rows, j]) for j in range(J.shape[1])] for rows in effectors])
    total = np.zeros(J.shape[1])
    for u, s, v in zip(U.T, sigma, Vt, strict=True):
        N = sum(np.linalg.norm(u[rows]) for rows in effectors)
        M = (reach @ np.abs(v)).sum() / s
        total += clamped((u @ e) / s * v, most, min(1, N / M), soft)
    if soft and np.abs(total / most).max() <= 1:
        return total
    return clamped(total, most, 1, soft)


def bare(**options):
    return SelectivelyDamped(backtracking=False, **options)


@pytest.mark.thinned
@pytest.mark.parametrize("bend", [1.0, 1e-3, 1e-6, 1e-12, 0.0])
@pytest.mark.parametrize("clamp", ["hard", "soft"])
@pytest.mark.parametrize("max_error", [math.inf, 0.4])
def test_the_step_of_a_planar_arm(clamp, max_error, bend, rng):
    ik = shared_solver(planar(5), jtik.FrameTask("tip"), strategy=bare(clamp=clamp, max_error=max_error))
    for _ in range(10):
        q, target = np.append(0.4, bend * rng.uniform(-1, 1, 4)), rng.uniform(-5, 5, 2)
        J, e = planar_jacobian(q), planar_points(q)[-1] - target
        wanted = -expected(J, e, soft=clamp == "soft", max_error=max_error)
        assert ik.step(q, target).q - q == pytest.approx(wanted, rel=1e-4 if bend == 1e-12 else 1e-8, abs=1e-9)


@pytest.mark.quick(1)
@pytest.mark.parametrize("clamp", ["hard", "soft"])
def test_the_step_in_space(clamp, rng):
    robot = dh_arm(7, 3)
    ik = shared_solver(robot, jtik.FrameTask("tip", "pose"), strategy=bare(clamp=clamp))
    for _ in range(10):
        q = robot.random_configuration(rng)
        target = robot.pose(robot.random_configuration(rng))
        seen = ik.solve(target, q0=q, max_iterations=0)
        wanted = -expected(seen.jacobian, seen.error, soft=clamp == "soft")
        assert ik.step(q, target).q - q == pytest.approx(wanted, rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("clamp", ["hard", "soft"])
def test_several_effectors(clamp, rng):
    """End effector and elbow of one arm; rows of an effector count together, and its distance is clamped by itself."""
    robot, groups = planar(6), ((0, 1), (2, 3))
    tasks = [jtik.FrameTask("tip", name="tip"), jtik.FrameTask("link3", name="elbow")]
    ik = shared_solver(robot, tasks, strategy=bare(clamp=clamp, effectors=groups, max_error=0.5))
    for _ in range(10):
        q = rng.uniform(-1, 1, 6)
        target = {"tip": rng.uniform(-4, 4, 2), "elbow": rng.uniform(-2, 2, 2)}
        seen = ik.solve(target, q0=q, max_iterations=0)
        wanted = expected(seen.jacobian, seen.error, effectors=groups, soft=clamp == "soft", max_error=0.5)
        assert ik.step(q, target).q - q == pytest.approx(-wanted, rel=1e-7, abs=1e-9)
        as_one = expected(seen.jacobian, seen.error, soft=clamp == "soft", max_error=0.5)
        assert np.abs(wanted - as_one).max() > 1e-4


def test_at_a_joint_limit_the_joint_pressed_against_it_has_no_column():
    robot = planar(3, lower=-1.0, upper=1.0)
    q, target = np.array([0.2, 0.3, 1.0]), np.array([1.0, 2.5])
    J, e = planar_jacobian(q), planar_points(q)[-1] - target
    assert J[:, 2] @ e < 0
    J[:, 2] = 0
    ik = shared_solver(robot, jtik.FrameTask("tip"), strategy=bare())
    assert ik.step(q, target).q == pytest.approx(np.clip(q - expected(J, e), -1, 1), abs=1e-9)


def test_it_is_newton_s_step_where_nothing_needs_a_clamp(rng):
    ik = shared_solver(planar(4), jtik.FrameTask("tip"), strategy=bare())
    for _ in range(10):
        q = rng.uniform(0.3, 0.8, 4)
        target = planar_points(q)[-1] + rng.uniform(-0.05, 0.05, 2)
        newton = -np.linalg.pinv(planar_jacobian(q)) @ (planar_points(q)[-1] - target)
        assert ik.step(q, target).q - q == pytest.approx(newton, abs=1e-12)


@pytest.mark.parametrize("bend", [0.0, 1e-12, 1e-6, 1e-2, 1.0])
def test_no_angle_of_a_step_is_larger_than_the_limit(bend, rng):
    ik = shared_solver(planar(4), jtik.FrameTask("tip"), strategy=bare(max_angle=0.3))
    for _ in range(20):
        q = bend * rng.uniform(-1, 1, 4)
        assert np.abs(ik.step(q, rng.uniform(-8, 8, 2)).q - q).max() <= 0.3 * (1 + 1e-12)


@pytest.mark.parametrize("clamp", ["hard", "soft"])
@pytest.mark.parametrize("longest", [0.1, 2.0, math.inf])
def test_prismatic_joints_have_a_limit_of_their_own(longest, clamp, rng):
    robot = jtik.Robot.vehicle(2)
    ik = shared_solver(robot, jtik.FrameTask("tip"), strategy=bare(clamp=clamp, max_length=longest))
    most = np.where(robot.rotational, QUARTER, longest)
    for _ in range(10):
        q, target = robot.random_configuration(rng), rng.uniform(-5, 5, 2)
        seen = ik.solve(target, q0=q, max_iterations=0)
        wanted = -expected(seen.jacobian, seen.error, soft=clamp == "soft", most=most)
        assert ik.step(q, target).q - q == pytest.approx(wanted, rel=1e-7, abs=1e-9)


def test_a_vehicle_whose_arm_need_not_move_arrives_at_once():
    """10 m are the limit of a step."""
    robot = jtik.Robot.vehicle(1)
    ik = shared_solver(robot, jtik.FrameTask("tip"), strategy=bare())
    q = np.zeros(robot.n)
    for distance, wanted in [(9.0, 9.0), (30.0, 10.0)]:
        step = ik.step(q, robot.pose(q)[:2, 3] + [distance, 0.0]).q - q
        assert step == pytest.approx([wanted] + [0.0] * (robot.n - 1), abs=1e-9)


def two_slides(angle):
    """Two prismatic joints one after the other, at an ``angle`` to each other [rad]."""
    axes = np.array([[1.0, 0.0, 0.0], [math.cos(angle), math.sin(angle), 0.0]])
    joints = [
        jtik.Joint("first", jtik.JointType.PRISMATIC, "base", "between", axis=axes[0]),
        jtik.Joint("second", jtik.JointType.PRISMATIC, "between", "tip", axis=axes[1]),
    ]
    return jtik.Robot(joints, planar=True)


@pytest.mark.parametrize("clamp", ["hard", "soft"])
def test_a_weak_direction_that_moves_only_prismatic_joints_is_damped(clamp):
    """The step along it tends to zero with the angle between the two, and is zero where they are parallel."""
    lengths = []
    for angle in (1e-1, 1e-3, 1e-5, 1e-7, 0.0):
        ik = shared_solver(two_slides(angle), jtik.FrameTask("tip"), strategy=bare(clamp=clamp))
        lengths.append(np.abs(ik.step([0.0, 0.0], [0.0, 1.0]).q).max())
    assert lengths[0] == pytest.approx(0.5, rel=0.1)  # 10 m times the share that does not cancel
    assert np.all(np.array(lengths[1:]) <= [6e-3, 6e-5, 6e-7, 0.0])


def test_a_target_out_of_reach_ends_at_the_closest_posture():
    ik = shared_solver(planar(4), jtik.FrameTask("tip"), strategy="selectively_damped")
    solution = ik.solve([6.0, 0.0], q0=[0.5, -0.4, 0.3, 0.2], max_iterations=2000)
    assert not solution.converged
    assert solution.position_error == pytest.approx(2.0, abs=1e-3)


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("clamp", "firm"),
        ("max_angle", 0.0),
        ("max_angle", math.inf),
        ("max_length", 0.0),
        ("max_error", 0.0),
        ("max_error", math.nan),
    ],
)
def test_options_are_checked(option, value):
    with pytest.raises(jtik.ArgumentError, match=option):
        SelectivelyDamped(**{option: value})


@pytest.mark.parametrize("effectors", [((0,),), ((0, 1), (1,)), ((0, 1, 2),)])
def test_every_row_belongs_to_one_effector(effectors):
    strategy = SelectivelyDamped(effectors=effectors)
    with pytest.raises(jtik.ArgumentError, match="2 task rows"):
        jtik.InverseKinematics(planar(3), jtik.FrameTask("tip"), strategy=strategy).step(np.zeros(3), [1.0, 1.0])

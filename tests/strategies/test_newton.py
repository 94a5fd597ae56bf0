"""Newton's method: -J+ e at any rank, limited in length, and its null-space term."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, Newton, ProjectedGradient

from ..conftest import (
    EXACT,
    ball_arm,
    dh_arm,
    floating_arm,
    large_ones_slow,
    planar,
    planar_jacobian,
    planar_points,
    shared_solver,
)

WITH_FIGURES = [name for name, strategy in jtik.strategies.items() if not strategy.is_soft and name != "mink"]
"""Strategies whose null-space step is exact, and separate from the task step."""

BARE = {"backtracking": False, "q_limit": math.inf}

LEAKAGE = 1e-10
"""|J nu| / |nu| in poses of full rank: the projector is right to rounding times the condition number."""


def solver(robot, strategy, kind="position", **options):
    return shared_solver(robot, jtik.FrameTask("tip", kind), strategy=strategy, limits=False, **options)


def test_the_minimum_norm_step_of_the_sns_example():
    """Unit 4R, q = (pi/2, -pi/2, pi/2, -pi/2), xdot = (-4, -1.5)."""
    q = np.array([1, -1, 1, -1]) * np.pi / 2
    ik = solver(planar(4), Newton(**BARE))
    target = planar_points(q)[-1] + (-4.0, -1.5)
    assert ik.solve(target, q0=q, max_iterations=0).jacobian == pytest.approx(
        np.array([[-2, -1, -1, 0], [2, 2, 1, 1]]), abs=EXACT
    )
    assert ik.step(q, target).q - q == pytest.approx([2.454545, -2.136364, 1.227273, -3.363636], abs=1e-6)
    assert ik.step(q, target).q - q == pytest.approx(np.array([27, -23.5, 13.5, -37]) / 11, abs=1e-8)


@pytest.mark.parametrize("n", [2, 3, 10])
def test_the_undamped_step_is_the_pseudo_inverse(n, rng):
    ik = solver(planar(n), Newton(**BARE))
    for _ in range(20):
        q, target = rng.uniform(-1, 1, n), rng.uniform(-2, 2, 2)
        J, e = planar_jacobian(q), planar_points(q)[-1] - target
        dq = -np.linalg.pinv(J) @ e
        assert ik.step(q, target).q - q == pytest.approx(dq, rel=1e-9, abs=1e-11)


@pytest.mark.thinned
@pytest.mark.parametrize("name", ["dh6", "dh9", "ball", "floating"])
@pytest.mark.parametrize("kind", ["position", "orientation", "pose"])
def test_in_space_and_on_manifolds_too(name, kind, rng):
    robot = {
        "dh6": lambda: dh_arm(6, 1),
        "dh9": lambda: dh_arm(9, 1),
        "ball": ball_arm,
        "floating": floating_arm,
    }[name]()
    ik = solver(robot, Newton(**BARE), kind)
    for _ in range(5):
        q = robot.random_configuration(rng)
        target = robot.pose(robot.integrate(q, rng.uniform(-0.05, 0.05, robot.n)))
        seen = ik.solve(target, q0=q, max_iterations=0)
        dq = -np.linalg.pinv(seen.jacobian) @ seen.error
        assert robot.difference(q, ik.step(q, target).q) == pytest.approx(dq, rel=1e-7, abs=1e-10)


class TestRankDeficient:
    def test_a_straight_arm(self, rng):
        """J has one row of zeros; the step is that of the other."""
        ik = solver(planar(4), Newton(**BARE))
        target = np.array([3.0, 0.6])
        dq = -np.linalg.pinv(planar_jacobian(np.zeros(4))) @ (np.array([4.0, 0.0]) - target)
        assert ik.step(np.zeros(4), target).q == pytest.approx(dq, abs=EXACT)

    @pytest.mark.parametrize("angle", [0.3, 1.0, 2.5])
    def test_a_straight_arm_in_any_direction(self, angle):
        """Both rows are there, and dependent up to rounding."""
        q = np.array([angle, 0.0, 0.0, 0.0])
        target = planar_points(q)[-1] * 0.9 + np.array([-np.sin(angle), np.cos(angle)]) * 0.4
        J, e = planar_jacobian(q), planar_points(q)[-1] - target
        dq = -np.linalg.pinv(J, rcond=1e-8) @ e
        assert solver(planar(4), Newton(**BARE)).step(q, target).q - q == pytest.approx(dq, abs=1e-11)

    def test_a_pose_task_at_a_singular_wrist(self, rng):
        """Two wrist axes in line: rank 5 of 6."""
        half = np.pi / 2
        robot = jtik.Robot.from_dh(
            [
                (0, half, 0.4, 0),
                (0.5, 0, 0, 0),
                (0.1, half, 0, 0),
                (0, -half, 0.4, 0),
                (0, half, 0, 0),
                (0, 0, 0.1, 0),
            ]
        )
        ik = solver(robot, Newton(**BARE), "pose")
        for _ in range(10):
            q = rng.uniform(-1, 1, 6)
            q[4] = 0.0
            target = robot.pose(q)
            target[:3, 3] += rng.uniform(-0.1, 0.1, 3)
            seen = ik.solve(target, q0=q, max_iterations=0)
            assert np.linalg.matrix_rank(seen.jacobian, tol=1e-9) == 5
            dq = -np.linalg.pinv(seen.jacobian, rcond=1e-9) @ seen.error
            assert ik.step(q, target).q - q == pytest.approx(dq, rel=1e-8, abs=1e-10)

    def test_more_rows_than_joints(self, rng):
        """The least-squares step."""
        robot = dh_arm(4, 2)
        ik = solver(robot, Newton(**BARE), "pose")
        for _ in range(5):
            q = robot.random_configuration(rng)
            target = robot.pose(q + rng.uniform(-0.1, 0.1, 4))
            target[:3, 3] += 0.05
            seen = ik.solve(target, q0=q, max_iterations=0)
            dq = np.linalg.lstsq(seen.jacobian, -seen.error, rcond=None)[0]
            assert ik.step(q, target).q - q == pytest.approx(dq, rel=1e-8, abs=1e-10)


def test_stiffness_weighs_what_cannot_all_be_reached(rng):
    """min (J dq + e)' Kp (J dq + e): the weights matter where J has not full row rank, and only there."""
    robot, Kp = dh_arm(4, 2), np.diag([4.0, 1.0, 2.0, 0.3, 0.1, 0.2])
    task = jtik.FrameTask("tip", "pose", stiffness=np.diag(Kp))
    ik = shared_solver(robot, task, strategy=Newton(**BARE), limits=False)
    q = robot.random_configuration(rng)
    target = robot.pose(q + 0.1)
    target[:3, 3] += 0.1
    seen = ik.solve(target, q0=q, max_iterations=0)
    root = np.sqrt(Kp)
    dq = np.linalg.lstsq(root @ seen.jacobian, -root @ seen.error, rcond=None)[0]
    assert ik.step(q, target).q - q == pytest.approx(dq, rel=1e-8, abs=1e-10)


def test_the_limit_shortens_the_step_and_keeps_its_direction(rng):
    for _ in range(10):
        q, target = rng.uniform(-1, 1, 5), rng.uniform(-4, 4, 2)
        free = solver(planar(5), Newton(**BARE)).step(q, target).q - q
        dq = solver(planar(5), Newton(q_limit=0.2, backtracking=False)).step(q, target).q - q
        assert dq == pytest.approx(free * min(1, 0.2 / np.linalg.norm(free)), abs=1e-13)


def test_convergence_is_quadratic_near_the_target(rng):
    q = rng.uniform(0.2, 1, 4)
    trace = (
        solver(planar(4), Newton()).solve(planar_points(q + 0.1)[-1], q0=q, position_tolerance=1e-13, trace=True).trace
    )
    error = trace.error[(trace.error < 1e-1) & (trace.error > 1e-7)]
    after = trace.error[1:][(trace.error[:-1] < 1e-1) & (trace.error[:-1] > 1e-7)]
    assert len(error) >= 2
    assert (after <= 2 * error**2 + 1e-14).all()


class TestNullSpaceTerm:
    def test_the_worked_projector(self):
        """Unit 3R at (pi/2, pi/2, pi/2) on target: a step along each coordinate's gradient is a column of N."""
        q = np.full(3, np.pi / 2)
        strategy = Newton(secondary=ProjectedGradient(rule="paper"), **BARE)

        @jtik.criterion
        def ramp(q, robot, *, along=(1.0, 1.0, 1.0)):
            return q[0] * along[0] + q[1] * along[1] + q[2] * along[2]

        ik = solver(planar(3), strategy, criteria=ramp)
        target = planar_points(q)[-1]
        assert ik.solve(target, q0=q, max_iterations=0).jacobian == pytest.approx(
            np.array([[0, 1, 1], [-1, -1, 0]]), abs=EXACT
        )
        columns = []
        for unit in np.eye(3):
            ik.parameters["ramp.along"] = unit
            ik.reset()
            columns.append(q - ik.step(q, target).q)
        projector = np.array([[1, -1, 1], [-1, 1, -1], [1, -1, 1]]) / 3
        found = np.array(columns).T
        assert found == pytest.approx(projector, abs=1e-8)
        ik.parameters["ramp.along"] = np.ones(3)
        ik.reset()
        assert q - ik.step(q, target).q == pytest.approx([1 / 3, -1 / 3, 1 / 3], abs=1e-8)

    @pytest.mark.parametrize("beta", [0.1, 1.0])
    def test_the_whole_step_is_newtons_and_the_projected_gradient(self, beta, rng):
        """-J+ e - beta (I - J+ J) dH."""
        strategy = Newton(secondary=ProjectedGradient(rule="paper", beta_max=beta), **BARE)
        for robot, kind in ((planar(6), "position"), (dh_arm(7, 2), "pose")):
            ik = solver(robot, strategy, kind, criteria=JointCentering())
            for _ in range(5):
                q = rng.uniform(-1, 1, robot.n)
                target = robot.pose(q + rng.uniform(-0.1, 0.1, robot.n))
                seen = ik.solve(target, q0=q, max_iterations=0)
                J, e, g = seen.jacobian, seen.error, seen.gradient
                pinv = np.linalg.pinv(J)
                ik.reset()
                dq = ik.step(q, target).q - q
                assert dq == pytest.approx(-pinv @ e - beta * (g - pinv @ J @ g), rel=1e-8, abs=1e-10)

    @pytest.mark.quick(3, slow=6)
    @pytest.mark.parametrize("strategy", large_ones_slow(WITH_FIGURES))
    def test_it_does_not_move_the_end_effector(self, strategy, rng):
        """|J nu| / |nu|, as the trace reports it and as computed from on-target steps."""
        for robot, kind in ((planar(10), "position"), (dh_arm(7, 1), "position"), (dh_arm(8, 2), "pose")):
            ik = solver(robot, strategy, kind, criteria=JointCentering(preferred=np.full(robot.n, 0.4)))
            for _ in range(5):
                q = rng.uniform(-1, 1, robot.n)
                trace = ik.solve(robot.pose(q + 0.05), q0=q, max_iterations=60, trace=True).trace
                moved = trace.leakage[np.isfinite(trace.leakage)]
                assert len(moved)
                assert moved.max() < LEAKAGE
                # on the target the task step is zero, and the whole step is the null-space step
                step = ik.solve(robot.pose(q), q0=q, max_iterations=1, trace=True)
                nu = step.trace.q[1] - step.trace.q[0]
                J = step.trace and ik.solve(robot.pose(q), q0=q, max_iterations=0).jacobian
                if np.linalg.norm(nu) > 1e-6:
                    assert np.linalg.norm(J @ nu) <= 1e-9 * np.linalg.norm(nu)  # q is rounded to 1e-16 of itself
                geometric = robot.jacobian(q)[: 2 if robot.dimension == 2 else 3]
                assert np.linalg.norm(geometric @ nu) <= 1e-8 * max(np.linalg.norm(nu), 1e-6)


@pytest.mark.parametrize("options", [{"q_limit": 0.0}, {"q_limit": -math.inf}, {"q_limit": math.nan}])
def test_options_out_of_range_are_refused(options):
    with pytest.raises(jtik.ArgumentError, match="q_limit"):
        Newton(**options)

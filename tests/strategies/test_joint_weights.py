"""Joint weights: every strategy minimises dq' W dq instead of dq' dq, in the task step and in the null space.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import linprog

import jtik
from jtik_formulations import (
    SNS,
    SNSQP,
    Damped,
    Hybrid,
    JointCentering,
    JParse,
    LexicographicQP,
    Mink,
    Newton,
    SecondOrder,
    TaskPriority,
    TransposeBB,
    WeightedQP,
)

from ..conftest import EXACT, ball_arm, dh_arm, families_first, floating_arm, planar, planar_points, shared_solver, slow

pytestmark = pytest.mark.thinned(together=True, times=2)

ROBOTS = {
    "planar": (lambda: planar(5), "position"),
    "spatial": (lambda: dh_arm(8, 1), "pose"),
    "ball": (ball_arm, "position"),
    "floating": (floating_arm, "position"),
}

UNDAMPED = {
    "newton": Newton(q_limit=math.inf, backtracking=False),
    "hybrid": Hybrid(q_limit=3.0),
    "task_priority": TaskPriority(),
    "sns": SNS(damping=0.0),
    "lexicographic_qp": LexicographicQP(damping=0.0),
    "nakamura": "nakamura",
    "jparse": JParse(threshold=1e-6),
    "weighted_least_norm": "weighted_least_norm",
    "weighted_qp": WeightedQP(lm_damping=0.0, damping=1e-10),
    "sns_qp": SNSQP(damping=0.0),
    "mink": Mink(),
}
"""Strategies whose first step to a target nearby is that of the pseudo-inverse."""

EXACT_STEPS = ["newton", "hybrid", "task_priority", "sns", "lexicographic_qp", *slow(*list(UNDAMPED)[5:])]

OTHERS = ("hybrid+qp", "damped+qp", "newton+second_order")
"""Strategies with another secondary term."""

MINIMISING = ("newton", "lexicographic_qp", "task_priority", *OTHERS)
"""Strategies that find a minimum of H at limits to the tolerance of a solve."""

POINT = 1e-6
"""Task error of a converged solve."""


@jtik.criterion
def posture(q, robot):
    """Something other than a parabola, of every entry of q."""
    return sum((q[i] - 0.3 * (i % 3)) ** 2 + 0.1 * (q[i] + 0.2) ** 4 for i in range(robot.nq))


def solver(robot, strategy, kind="position", **options):
    return shared_solver(robot, jtik.FrameTask("tip", kind), strategy=strategy, **options)


def drawn(robot, rng):
    """Weights between 0.1 and 100."""
    return 10.0 ** rng.uniform(-1, 2, robot.n)


def nearby(robot, rng, size=0.05):
    """A configuration, and a target close to it."""
    q = robot.random_configuration(rng)
    return q, robot.pose(robot.integrate(q, rng.uniform(-size, size, robot.n)))


def moved(ik, q, target, **options):
    return ik.robot.difference(q, ik.step(q, target, **options).q)


def weighted_inverse(J, W, damping=0.0):
    """W^-1 J' (J W^-1 J' + damping I)^+."""
    light = J / W
    return light.T @ np.linalg.pinv(light @ J.T + damping * np.eye(len(J)), rcond=1e-12)


def gradient(function, robot, q, step=1e-6):
    ends = [[function(robot.integrate(q, sign * step * unit)) for sign in (1, -1)] for unit in np.eye(robot.n)]
    return np.array([(ahead - behind) / (2 * step) for ahead, behind in ends])


class TestTaskStep:
    @pytest.mark.parametrize("name", EXACT_STEPS)
    @pytest.mark.parametrize("which", ROBOTS)
    def test_it_is_the_weighted_pseudo_inverse(self, name, which, rng):
        build, kind = ROBOTS[which]
        if kind == "pose" and name in ("nakamura", "mink"):
            pytest.skip("damped where its measure of manipulability is low, or with another error of a pose")
        robot = build()
        W = drawn(robot, rng)
        ik = solver(robot, UNDAMPED[name], kind, weights=W, limits=False)
        for _ in range(4):
            q, target = nearby(robot, rng, 0.01)
            here = ik.solve(target, q0=q, max_iterations=0)
            wanted = -weighted_inverse(here.jacobian, W) @ here.error
            assert moved(ik, q, target) == pytest.approx(wanted, abs=2e-6 * np.linalg.norm(wanted))
            ik.reset()

    def test_damping_is_relative_to_the_lightest_joint(self, rng):
        robot, W = planar(5), np.array([9.0, 4.0, 0.5, 2.0, 30.0])
        ik = solver(robot, Damped(damping=2.0, q_limit=math.inf), weights=W, limits=False)
        for _ in range(5):
            q, target = nearby(robot, rng)
            here = ik.solve(target, q0=q, max_iterations=0)
            damping = 2.0 * here.error @ here.error / 2
            wanted = -weighted_inverse(here.jacobian, W / 0.5, damping) @ here.error
            assert moved(ik, q, target) == pytest.approx(wanted, abs=1e-10)
            ik.reset()

    def test_at_a_singular_pose(self):
        """A straight arm: one row of J is zero, the weighted step is that of the other."""
        W = np.array([50.0, 1.0, 3.0, 7.0])
        ik = solver(planar(4), Newton(q_limit=math.inf, backtracking=False), weights=W, limits=False)
        J = np.array([[4.0, 3.0, 2.0, 1.0]])
        wanted = weighted_inverse(J, W)[:, 0] * 0.1
        assert moved(ik, np.zeros(4), [4.0, 0.1]) == pytest.approx(wanted, abs=EXACT)

    @pytest.mark.parametrize("name", families_first(sorted(jtik.strategies), large=False))
    def test_a_heavy_joint_moves_less(self, name):
        q, target = np.array([0.4, 0.5, -0.6, 0.7, 0.3]), None
        target = planar_points(q)[-1] + np.array([-0.02, 0.03])
        shares = []
        for weight in (1.0, 25.0):
            dq = moved(solver(planar(5), name, weights={"joint1": weight}, limits=False), q, target)
            shares.append(abs(dq[0]) / np.abs(dq).max())
        assert shares[1] < 0.2 * shares[0]

    def test_rotations_stay_within_the_q_limit(self):
        """The limit is on the angles of the joints, not on what the strategy minimises."""
        for strategy in (Newton(q_limit=0.1), Hybrid(q_limit=0.1), TransposeBB(q_limit=0.1), TaskPriority(q_limit=0.1)):
            ik = solver(planar(4), strategy, weights=[100.0, 1.0, 40.0, 9.0], limits=False)
            dq = moved(ik, np.array([0.5, 0.5, 0.5, 0.5]), [-2.0, 1.0])
            assert np.linalg.norm(dq) == pytest.approx(0.1, rel=1e-6)
        ik = solver(planar(4), LexicographicQP(q_limit=0.1), weights=[100.0, 1.0, 40.0, 9.0], limits=False)
        assert np.abs(moved(ik, np.array([0.5, 0.5, 0.5, 0.5]), [-2.0, 1.0])).max() == pytest.approx(0.1, rel=1e-6)


class TestWithinLimits:
    @pytest.mark.slow
    def test_a_saturated_step_is_the_closest_in_the_metric(self, rng):
        """Of all displacements with the largest share of the task within the velocity limits."""
        n, dt, speed = 5, 0.02, 1.0
        robot, saturated = planar(n), 0
        for _ in range(12):
            W = drawn(robot, rng)
            limits = jtik.Limits(velocity=speed)
            ik = solver(robot, Newton(q_limit=math.inf, backtracking=False), weights=W, limits=limits)
            q, target = nearby(robot, rng, 0.04)
            here = ik.solve(target, q0=q, max_iterations=0)
            J, e, light = here.jacobian, here.error, W / W.min()
            damping = 0.05 * e @ e + 1e-12 * (J**2 / light).sum()  # of a timed step, (Q3)
            t = -weighted_inverse(J, light, damping) @ e
            x, room = moved(ik, q, target, dt=dt), speed * dt
            if np.abs(t).max() <= room:
                assert x == pytest.approx(t, abs=1e-9)
                continue
            best = linprog(
                np.r_[np.zeros(n), -1.0],
                A_eq=np.c_[J, -J @ t],
                b_eq=np.zeros(2),
                bounds=[*[(-room, room)] * n, (0, 1)],
            ).x[-1]
            assert x @ J.T == pytest.approx(best * J @ t, abs=1e-6 * np.linalg.norm(J @ t) + 1e-9)
            free = np.abs(x) < room * (1 - 1e-6)
            if free.sum() <= 2:
                continue
            saturated += 1
            force = W * (x - t)
            multipliers = np.linalg.lstsq(J[:, free].T, force[free], rcond=None)[0]
            rest = force - J.T @ multipliers
            scale = np.abs(force).max()
            assert np.abs(rest[free]).max() <= 1e-4 * scale
            assert (rest[~free] * np.sign(x[~free]) <= 1e-4 * scale).all()
        assert saturated >= 3

    def test_the_box_of_a_quadratic_program(self, rng):
        """The conditions of optimality of min 1/2 |J dq + r|^2 + 1/2 mu dq' W dq in the box of the joints."""
        robot, mu, active = planar(6, lower=-0.6, upper=0.6), 1e-3, 0
        W = np.array([30.0, 1.0, 2.0, 9.0, 1.0, 5.0])
        ik = solver(robot, WeightedQP(lm_damping=0.0, damping=mu, q_limit=math.inf, backtracking=False), weights=W)
        for _ in range(8):
            q, target = nearby(robot, rng, 0.3)
            here = ik.solve(target, q0=q, max_iterations=0)
            x = moved(ik, q, target)
            residual = here.jacobian.T @ (here.jacobian @ x + here.error) + mu * W * x
            up, down = q + x >= 0.6 - 1e-9, q + x <= -0.6 + 1e-9
            active += int((up | down).sum())
            assert np.abs(residual[~(up | down)]).max() <= 1e-7
            assert (residual[up] <= 1e-7).all()
            assert (residual[down] >= -1e-7).all()
        assert active >= 8

    def test_the_null_space_step_in_the_box(self, rng):
        """nu minimises 1/2 nu' W nu + beta grad H' nu where J nu = 0, in the box of the joints."""
        robot, active = planar(7, lower=-0.5, upper=0.5), 0
        W = np.array([30.0, 1.0, 2.0, 9.0, 1.0, 5.0, 0.5])
        ik = solver(robot, "newton+qp", weights=W, criteria=JointCentering(preferred=[0.9, -0.9] * 3 + [0.9]))
        for _ in range(8):
            q = rng.choice([-0.49, 0.49, 0.1], 7)
            here = ik.solve(robot.pose(q), q0=q, max_iterations=0)
            x = moved(ik, q, robot.pose(q))
            ik.reset()
            up, down = q + x >= 0.5 - 1e-9, q + x <= -0.5 + 1e-9
            free, J, g = ~(up | down), here.jacobian, here.gradient
            active += int((~free).sum())
            basis = np.c_[-g, J.T]
            (beta, *multipliers), *_ = np.linalg.lstsq(basis[free], (W * x)[free], rcond=None)
            rest = W * x + beta * g - J.T @ np.array(multipliers)
            scale = np.abs(W * x).max()
            assert beta > 0
            assert np.abs(J @ x).max() <= 1e-9
            assert np.abs(rest[free]).max() <= 1e-6 * scale
            assert (rest[up] <= 1e-6 * scale).all()
            assert (rest[down] >= -1e-6 * scale).all()
        assert active >= 4

    @pytest.mark.parametrize("name", families_first([*sorted(jtik.strategies), *OTHERS], large=False))
    def test_velocities_and_positions_hold(self, name, rng):
        robot, dt = planar(4, lower=-1.0, upper=1.0), 0.02
        W, limits = {"joint1": 40.0, "joint3": 0.2}, jtik.Limits(velocity=1.0, acceleration=20.0)
        for criteria in (JointCentering(), *([None] if name in ("hybrid", "weighted_qp") else [])):
            ik = solver(robot, name, weights=W, limits=limits, criteria=criteria)
            q = np.array([0.2, 0.6, -0.4, 0.5])
            start = planar_points(q)[-1]
            path = [start + 0.5 * np.sin(k / 10) * np.array([-1.0, 0.6]) for k in range(40)]
            track = ik.track(path, q0=q, dt=dt)
            assert np.abs(track.dq).max() <= 1.0 + 1e-9
            assert np.abs(np.diff(track.dq, axis=0, prepend=0)).max() <= 20.0 * dt + 1e-9
            assert np.abs(track.q).max() <= 1.0


class TestNullSpace:
    @pytest.mark.parametrize(
        "name", ["hybrid", "damped", "hybrid+qp", *slow("newton", "sns", "lexicographic_qp", "mink")]
    )
    @pytest.mark.parametrize("which", ROBOTS)
    def test_on_the_target_it_is_the_weighted_projection(self, name, which, rng):
        build, kind = ROBOTS[which]
        robot = build()
        W = drawn(robot, rng)
        ik = solver(robot, name, kind, weights=W, limits=False, criteria=posture)
        for _ in range(4):
            q = robot.random_configuration(rng)
            here = ik.solve(robot.pose(q), q0=q, max_iterations=0)
            g = gradient(lambda p: float(posture(p, robot)), robot, q)
            null = g / W - weighted_inverse(here.jacobian, W) @ (here.jacobian @ (g / W))
            dq = moved(ik, q, robot.pose(q))
            ik.reset()
            assert dq / np.linalg.norm(dq) == pytest.approx(-null / np.linalg.norm(null), abs=1e-6)
            assert np.abs(here.jacobian @ dq).max() <= 1e-9 * np.linalg.norm(here.jacobian)

    def test_a_newton_step_does_not_depend_on_the_metric(self):
        """It minimises the model of H in the null space, in which dq' W dq has no part."""
        q, steps = np.array([0.5, 0.6, -0.7, 0.8, 0.4]), []
        centering = JointCentering(preferred=q + np.array([0.05, -0.04, 0.03, 0.05, -0.06]))
        newton = Newton(secondary=SecondOrder(curvature="gauss_newton", corrections=0))
        for weights in (None, [4.0, 1.0, 1.5, 2.0, 3.0]):
            ik = solver(planar(5), newton, weights=weights, limits=False, criteria=centering)
            steps.append(moved(ik, q, planar_points(q)[-1]))
        assert np.abs(steps[0]).max() > 0.01
        assert steps[1] == pytest.approx(steps[0], abs=1e-8)

    @pytest.mark.parametrize(
        ("name", "limit"),
        [
            *[(name, limit) for name in ("hybrid", "damped") for limit in (math.inf, 0.7)],
            *[pytest.param(name, math.inf, marks=pytest.mark.slow) for name in (*MINIMISING, "sns")],
            *[pytest.param(name, 0.7, marks=pytest.mark.slow) for name in MINIMISING],
        ],
    )
    def test_a_solve_ends_at_the_same_minimum_whatever_the_weights(self, name, limit, rng):
        """The conditions of optimality there do not contain the weights."""
        robot = planar(5, lower=-limit, upper=limit)
        iks = [
            solver(robot, name, weights=weights, criteria=JointCentering(preferred=[0.9, 0.1, -0.2, 0.5, 0.3]))
            for weights in (None, [100.0, 1.0, 30.0, 1.0, 0.3])
        ]
        for _ in range(4):
            q = rng.uniform(-0.6, 0.6, 5)
            target = planar_points(np.clip(q + rng.uniform(-0.1, 0.1, 5), -0.6, 0.6))[-1]
            plain, weighted = (ik.solve(target, q0=q) for ik in iks)
            assert weighted.converged, weighted.status
            assert planar_points(weighted.q)[-1] == pytest.approx(target, abs=POINT)
            assert weighted.q == pytest.approx(plain.q, abs=2e-5)

    def test_a_solve_is_stationary_by_the_joints_themselves(self, rng):
        """The tolerance is of dH/dq, not of its derivative in weighted coordinates, which is ten times smaller."""
        ik = solver(planar(4), "hybrid", weights=[1.0, 100.0, 100.0, 100.0], limits=False, criteria=JointCentering())
        for _ in range(10):
            q = rng.uniform(-1, 1, 4)
            solution = ik.solve(planar_points(q + 0.1)[-1], q0=q, optimality_tolerance=1e-4, trace=True)
            assert solution.converged
            assert solution.null_space_residual <= 1e-4 * max(1, np.linalg.norm(solution.gradient))
            assert solution.trace.null_residual[-1] >= solution.null_space_residual / 2


class TestSolves:
    @pytest.mark.parametrize("name", families_first([*sorted(jtik.strategies), *OTHERS], large=False))
    def test_converged_solves_are_on_their_target(self, name, rng):
        arm = jtik.Robot.builtin("panda")
        for criteria in (JointCentering(), *([None] if name in ("hybrid", "weighted_qp") else [])):
            ik = shared_solver(
                arm,
                jtik.FrameTask(arm.tip, kind="position"),
                criteria=criteria,
                strategy=name,
                weights={"panda_joint1": 30.0, "panda_joint2": 10.0, "panda_joint6": 0.5},
            )
            reached = 0
            for _ in range(4):
                target = arm.pose(arm.random_configuration(rng))
                solution = ik.solve(target, q0=arm.random_configuration(rng), until="reached", max_iterations=400)
                off = np.linalg.norm(arm.pose(solution.q)[:3, 3] - target[:3, 3])
                assert solution.converged == (off <= POINT * (1 + 1e-6))
                assert (solution.q >= arm.lower).all()
                assert (solution.q <= arm.upper).all()
                reached += solution.converged
            assert reached >= 3 or (ik.strategy.is_soft and criteria)

    @pytest.mark.parametrize(
        "name", ["hybrid", *slow(*(name for name in jtik.strategies if name != "hybrid"), *OTHERS)]
    )
    def test_equal_weights_are_none(self, name):
        q0, target = np.array([0.5, 0.3, -0.4, 0.6, 0.1]), [2.0, 2.5]
        every = {f"joint{i + 1}": 0.2 for i in range(5)}
        plain, *weighted = (
            solver(planar(5), name, weights=w, criteria=JointCentering()).solve(target, q0=q0, max_iterations=30).q
            for w in (None, every, *([[3.0] * 5] if name == "hybrid" else []))
        )
        for each in weighted:
            assert np.array_equal(plain, each)

    @pytest.mark.parametrize("name", ["hybrid", "hybrid+qp", *slow("damped", "sns", "weighted_qp", "lexicographic_qp")])
    @pytest.mark.parametrize("criteria", [None, JointCentering()])
    def test_a_base_moves_less_than_its_arm(self, name, criteria):
        """Prismatic joints in x and y under three joints, along a path within the reach of the arm."""
        robot = jtik.Robot.vehicle(3)
        q0 = np.array([0.0, 0.0, 0.6, 0.6, 0.6])
        start = robot.position(q0, "tip")
        angles = np.linspace(0, 1.5, 60)[1:]
        path = [start + 0.5 * np.array([np.cos(a) - 1, np.sin(a)]) for a in angles]
        driven = []
        for weights in (None, {"x": 50.0, "y": 50.0}):
            ik = solver(robot, name, weights=weights, criteria=criteria)
            track = ik.track(path, q0=q0)
            assert track.position_error.max() <= (1e-3 if ik.strategy.is_soft else POINT)
            driven.append(np.abs(np.diff(track.q[:, :2], axis=0, prepend=q0[None, :2])).sum())
        assert driven[1] <= 0.4 * driven[0]

    def test_a_heavy_joint_still_does_what_the_others_cannot(self):
        """Only the base can drive ten metres."""
        ik = solver(jtik.Robot.vehicle(3), "hybrid", weights={"x": 10.0, "y": 10.0})
        solution = ik.solve([10.0, 0.3], q0=[0, 0, 0.5, 0.5, 0.5])
        assert solution.converged
        assert ik.robot.position(solution.q, "tip") == pytest.approx([10.0, 0.3], abs=POINT)

    def test_a_saddle_point_is_left(self):
        ik = solver(planar(3), "hybrid", weights=[100.0, 1.0, 10.0])
        solution = ik.solve([1.5, 0.0], q0=np.zeros(3))
        assert solution.converged
        assert solution.escapes

    def test_a_trace_is_of_the_joints_themselves(self):
        ik = solver(planar(4), "hybrid", weights=[100.0, 1.0, 0.04, 9.0], criteria=JointCentering(), limits=False)
        trace = ik.solve([2.0, 1.5], q0=[0.4, 0.5, 0.6, 0.3], trace=True).trace
        taken = trace.accepted == 1
        assert trace.step_length[taken] == pytest.approx(np.linalg.norm(np.diff(trace.q, axis=0), axis=1)[taken])
        smallest = [np.linalg.svd(ik.robot.jacobian(q, "tip")[:2], compute_uv=False)[-1] for q in trace.q[:-1]]
        assert trace.sigma_min == pytest.approx(smallest)

    @pytest.mark.slow
    def test_as_generated_c(self):
        weights = {"joint1": 20.0, "joint4": 0.3}
        plain, compiled = (
            solver(planar(5), "hybrid", weights=weights, criteria=JointCentering(), compiled=compiled)
            for compiled in (False, True)
        )
        for ik in (plain, compiled):
            assert ik.solve([2.0, 2.0], q0=[0.3] * 5).converged
        assert compiled.solve([2.0, 2.0], q0=[0.3] * 5).q == pytest.approx(plain.solve([2.0, 2.0], q0=[0.3] * 5).q)


class TestClearances:
    @pytest.mark.parametrize("name", ["hybrid+qp", *slow("weighted_qp", "lexicographic_qp", "damped+qp")])
    def test_every_step_keeps_them_on_its_way(self, name, rng):
        """By the distance of the joints from a circle, at points of the straight path in q."""
        from jtik_formulations import ObstacleAvoidance

        center, radius, safe = np.array([1.8, 1.0]), 0.4, 0.05
        clearance = jtik.Clearance(ObstacleAvoidance([jtik.Circle(center=center, radius=radius)]), safe=safe)
        ik = solver(planar(4), name, weights=[0.05, 3.0, 40.0, 1.0], clearances=clearance)
        reached, blocked = 0, 0
        for _ in range(6):
            q = rng.uniform(-1.2, 1.2, 4)
            if (np.linalg.norm(planar_points(q) - center, axis=1) < radius + safe).any():
                continue
            solution = ik.solve(planar_points(q + rng.uniform(-0.8, 0.8, 4))[-1], q0=q, trace=True)
            for before, after in zip(solution.trace.q[:-1], solution.trace.q[1:], strict=True):
                for share in np.linspace(0, 1, 11):
                    points = planar_points(before + share * (after - before))
                    assert np.linalg.norm(points - center, axis=1).min() >= radius + safe - 1e-9
            reached += solution.converged
            blocked += not solution.converged
        assert reached >= 2

"""The Newton step on the conditions of optimality: one step by hand, its order of convergence, and what it finds.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import copy
import functools
import math
import pickle

import casadi
import numpy as np
import pytest
from scipy.optimize import minimize

import jtik
from jtik.symbolic import SX, function, looped
from jtik.testing import check_strategy
from jtik_formulations import Hybrid, JointCentering, Newton, ObstacleAvoidance, SecondOrder
from jtik_formulations.strategies import second_order
from jtik_formulations.strategies.second_order import convexified

from ..conftest import (
    ball_arm,
    dh_arm,
    differences,
    floating_arm,
    planar,
    planar_jacobian,
    planar_points,
    report_at,
    shared_solver,
    slow,
)

pytestmark = pytest.mark.thinned

FIELD = [jtik.Circle((4.0, 2.5), 0.5), jtik.Circle((6.5, -1.0), 0.8)]

TIGHT = {"position_tolerance": 1e-12, "orientation_tolerance": 1e-12, "optimality_tolerance": 1e-12}

SAME = 1e-8
"""Difference of H at the optima of two solvers, one of which keeps the constraint to 1e-10."""


@jtik.criterion
def elbow(q, robot):
    """The fourth frame at a height, and no joint far from 0.1 rad; neither quadratic nor convex."""
    height = robot.position(q, robot.moving_frames[3])[2]
    return (height - 0.8) ** 2 + 0.1 * casadi.sumsqr(casadi.sin(q - 0.1))


@jtik.criterion
def two_points(q, robot):
    """Springs at two frames; for robots that no angles describe."""
    first, last = robot.position(q, robot.moving_frames[1]), robot.position(q, robot.moving_frames[-2])
    return casadi.sumsqr(first - np.array([0.3, 0.2, 0.5])) + casadi.sumsqr(last - np.array([0.2, 0.3, 0.5]))


@jtik.criterion
def waves(q, robot):
    """Many minima and maxima."""
    return casadi.sumsqr(casadi.sin(3 * q))


@jtik.criterion(residual=True)
def reaching(q, robot):
    """A frame that cannot reach a point, in residual form: its Hessian is not positive definite everywhere."""
    return robot.position(q, robot.moving_frames[1])[:2] - np.array([0.0, 9.0])


def instructions(ik):
    """Instructions of the functions of a step."""
    parts = ik._engine.runners.solve.fused.parts
    of_calls = [each for call in parts.calls for each in call.functions]
    return sum(each.n_instructions() for each in (parts.local, *parts.stages, *parts.data, *of_calls))


@functools.cache
def planar_solver(limit, strategy):
    criteria = JointCentering() + 0.3 * ObstacleAvoidance(FIELD)
    robot = planar(10, lower=-limit, upper=limit)
    return shared_solver(robot, jtik.FrameTask(), criteria=criteria, strategy=strategy)


def planar_problems(limit, count, seed=0):
    """Starts and targets a body's length from every obstacle, and where limits are narrow goals close to them."""
    rng = np.random.default_rng(seed)
    while count:
        q0, goal = 0.6 * min(limit, 1.0) * rng.uniform(-1, 1, (2, 10))
        if limit < 0.5:
            goal = rng.choice([-1, 1]) * rng.uniform(0.5, 1.0, 10) * limit
        gaps = [
            np.linalg.norm(planar_points(q) - ball.center, axis=1) - ball.radius for q in (q0, goal) for ball in FIELD
        ]
        if min(gap.min() for gap in gaps) > 0.3:
            count -= 1
            yield q0, planar_points(goal)[-1]


def is_quadratic(solution, robot, *, least=2, factor=30.0):
    """Whether each step taken with the limits of the optimum active squares the distance to it, up to a factor.

    At least so many steps must show it, between 0.3 and 1e-6.
    """
    trace = solution.trace
    e = np.array([np.linalg.norm(robot.difference(solution.q, q)) for q in trace.q])
    at = (trace.q >= robot.upper - 1e-9) | (trace.q <= robot.lower + 1e-9)
    final = np.flatnonzero((at != at[-1]).any(axis=1)).max(initial=-1) + 1
    ahead, behind = e[final + 1 :], e[final:-1]
    close = (behind < 0.3) & (behind > 1e-6)
    return close.sum() >= least and bool((ahead[close] <= factor * behind[close] ** 2 + 1e-12).all())


class TestOneStep:
    def test_it_is_the_step_of_the_conditions_of_optimality(self, rng):
        """Against the linear system [W J'; J 0] [p; l] = -[dH; r], W by differences of dH + J' lambda."""
        H = JointCentering(np.linspace(1.0, 2.0, 4), np.full(4, 0.2))
        strategy = Newton(secondary=SecondOrder(step_limit=10.0, corrections=0), backtracking=False, q_limit=math.inf)
        ik = shared_solver(planar(4), jtik.FrameTask(), criteria=H, strategy=strategy)
        K = np.diag(np.linspace(1.0, 2.0, 4))
        definite = 0
        for _ in range(20):
            q = rng.uniform(0.1, 0.9, 4)
            target = planar_points(q)[-1] + rng.uniform(-0.02, 0.02, 2)
            J, g = planar_jacobian(q), K @ (q - 0.2)
            multiplier = -np.linalg.pinv(J).T @ g
            W = K + differences(lambda q, multiplier=multiplier: planar_jacobian(q).T @ multiplier, ik.robot, q)
            null = np.linalg.svd(J)[2][2:]
            if np.linalg.eigvalsh(null @ W @ null.T)[0] < 1e-3:
                continue
            definite += 1
            system = np.block([[W, J.T], [J, np.zeros((2, 2))]])
            p = np.linalg.solve(system, -np.concatenate([g, planar_points(q)[-1] - target]))[:4]
            ik.reset()
            assert ik.step(q, target).q - q == pytest.approx(p, rel=1e-7, abs=1e-7)
        assert definite >= 8

    @pytest.mark.parametrize(("sign", "convex"), [(1.0, True), (-1.0, False)])
    def test_the_quadratic_program_has_the_reduced_hessian_where_that_is_positive_definite(self, sign, convex):
        """Up to a factor; where it is not, another that is."""

        @jtik.criterion
        def bowl(q, robot, *, sign=sign):
            return 0.5 * sign * casadi.sumsqr(q) - robot.position(q, "tip")[0]

        def gradient(q):
            return sign * q - planar_jacobian(q)[0]

        q = np.array([0.4, 0.5, -0.3, 0.6])
        J, target = planar_jacobian(q), planar_points(q)[-1]
        ik = shared_solver(planar(4), jtik.FrameTask(), criteria=bowl, strategy="newton+second_order")
        null = np.linalg.svd(J)[2][2:]
        multiplier = -np.linalg.pinv(J).T @ gradient(q)
        exact = null @ differences(lambda q: gradient(q) + planar_jacobian(q).T @ multiplier, ik.robot, q) @ null.T
        assert (np.linalg.eigvalsh(exact)[0] > 0) == convex
        P = null @ ik.build(q, target).P @ null.T
        assert np.linalg.eigvalsh(P)[0] > 0
        assert (np.abs(P - P[0, 0] / exact[0, 0] * exact).max() < 1e-6) == convex
        assert ik.solve(target, q0=q, max_iterations=1, trace=True).trace.positive_definite[0] == convex

    def test_without_a_criterion_it_is_not_there(self):
        robot, task = planar(4), jtik.FrameTask()
        plain, with_term = (
            shared_solver(robot, task, strategy=strategy) for strategy in ("newton", "newton+second_order")
        )
        q = np.full(4, 0.4)
        assert with_term.step(q, (2.0, 1.0)).q.tolist() == plain.step(q, (2.0, 1.0)).q.tolist()


def modified_factorisation(A):
    """What Gill, Murray and Wright's factorisation adds to the diagonal, and the smallest pivot or 0."""
    n, left, added, lowest = len(A), A.copy(), np.zeros(len(A)), 0.0
    bound = max(2 * np.abs(np.diag(A)).max(), np.abs(A - np.diag(np.diag(A))).max()) + 1e-300
    for j in range(n):
        pivot, column = left[j, j], left[j + 1 :, j]
        smallest = np.abs(column).max(initial=0) ** 2 / bound
        good = pivot > 1e-8 and pivot >= smallest
        used = pivot if good else max(abs(pivot), smallest, 1e-2)
        added[j], lowest = used - pivot, min(lowest, pivot)
        left[j + 1 :, j + 1 :] -= np.outer(column / used, column)
    return added, lowest


def matrices(n, rng):
    """Symmetric matrices: positive definite, indefinite, singular, badly scaled; with entries of order 1."""
    turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
    signs = np.where(rng.random(n) < 0.3, -1.0, 1.0)
    scale = 10.0 ** -rng.uniform(0, 4, n)
    for eigenvalues in (rng.uniform(0.1, 1, n), signs * rng.uniform(0.1, 1, n), np.arange(n) % 3, np.zeros(n)):
        matrix = turn @ np.diag(eigenvalues) @ turn.T
        matrix = (matrix + matrix.T) / 2
        yield from (matrix, scale[:, None] * matrix * scale)


@functools.cache
def factorised(n, loops):
    """The results of `convexified` as a function, with loops or written out."""
    A = SX.sym("A", n, n)
    return function("convexified", [A], looped(convexified, A, when=loops))


class TestConvexified:
    @pytest.mark.parametrize("loops", [False, True])
    @pytest.mark.parametrize("n", [1, 2, 5, 8])
    def test_a_matrix_stays_as_it_is_exactly_where_it_is_positive_definite(self, n, loops, rng):
        spread = 10.0 ** np.linspace(-6, 0, n)
        for sign in [*np.eye(n)[:3], np.zeros(n)]:
            turn = np.linalg.qr(rng.normal(size=(n, n)))[0]
            eigenvalues = np.where(sign > 0, -1.0, 1.0) * spread
            matrix = turn @ np.diag(eigenvalues) @ turn.T
            changed, definite, lowest = (np.array(part) for part in factorised(n, loops)((matrix + matrix.T) / 2))
            assert definite[0, 0] == (lowest[0, 0] == 0) == (not sign.any())
            if definite[0, 0]:
                assert np.array_equal(changed, (matrix + matrix.T) / 2)
            assert np.linalg.eigvalsh(changed)[0] > 0
            assert np.abs(changed - matrix).max() < 100

    @pytest.mark.parametrize("loops", [False, True])
    @pytest.mark.parametrize("n", [1, 2, 3, 12, 13, 30])
    def test_it_is_the_factorisation_on_numbers(self, n, loops, rng):
        definite = []
        for A in (each for _ in range(5) for each in matrices(n, rng)):
            found = [np.array(part) for part in factorised(n, loops)(A)]
            added, lowest = modified_factorisation(A)
            assert found[0] == pytest.approx(A + np.diag(added), abs=1e-9)
            assert found[1].item() == (not added.any())
            assert found[2].item() == pytest.approx(lowest, abs=1e-9)
            definite.append(not added.any())
        assert 0 < sum(definite) < len(definite)

    def test_loops_give_the_same_bits(self, rng):
        for n in (2, 7, 20):
            for A in matrices(n, rng):
                one, two = (factorised(n, loops)(A) for loops in (False, True))
                assert all(np.array_equal(np.array(a), np.array(b)) for a, b in zip(one, two, strict=True))

    def test_zero_is_not_positive_definite(self):
        changed, definite, _ = factorised(3, False)(np.zeros((3, 3)))
        assert not definite
        assert np.linalg.eigvalsh(np.array(changed))[0] > 1e-3


class TestManyJoints:
    """Products and factorisations of many joints are loops over numbers."""

    @pytest.mark.parametrize(("n", "criteria"), [(3, waves), (5, reaching + JointCentering())])
    def test_the_step_is_that_of_the_written_out_matrices(self, n, criteria, monkeypatch, rng):
        robot, task = planar(n, lower=-2.0, upper=2.0), jtik.FrameTask()
        written_out = jtik.InverseKinematics(robot, task, criteria=criteria, strategy="hybrid+second_order")
        monkeypatch.setattr(second_order, "UNROLLED", 1)
        loops = jtik.InverseKinematics(robot, task, criteria=criteria, strategy="hybrid+second_order")
        definite = set()
        for k in range(20):
            q, goal = rng.uniform(-1.9, 1.9, (2, n))
            if k % 3 == 0:
                q[k % n] = 2.0
            one, two = (
                ik.solve(robot.position(goal), q0=q, max_iterations=1, trace=True) for ik in (written_out, loops)
            )
            assert one.q == pytest.approx(two.q, abs=1e-10)
            definite.add(one.trace.positive_definite[0])
        assert definite == ({0.0, 1.0} if criteria is waves else {1.0})  # Gauss-Newton takes over

    @pytest.mark.parametrize(("rows", "n"), [(2, 3), (2, 9), (6, 20), (2, 1)])
    def test_the_reduced_hessian_is_that_of_numpy(self, rows, n, rng):
        W, moved, free = rng.normal(size=(n, n)), rng.normal(size=n), (rng.random(n) < 0.7) * 1.0
        basis = np.zeros((rows, n))
        independent = min(rows, int(free.sum()))
        basis[:independent, free > 0] = np.linalg.qr(rng.normal(size=(int(free.sum()), independent)))[0].T
        N = np.diag(free) - basis.T @ basis
        given = [SX.sym("W", n, n), SX.sym("B", rows, n), SX.sym("f", n), SX.sym("t", n)]
        for loops in (True, False):
            f = function("reduced", given, looped(second_order._reduced, *given, when=loops))
            reduced, largest, change = (np.array(each) for each in f(W, basis, free, moved))
            assert reduced == pytest.approx(N @ W @ N, abs=1e-12)
            assert largest.item() == np.abs(reduced).max()
            assert change.ravel() == pytest.approx(N @ W @ moved, abs=1e-12)

    def test_a_step_grows_with_the_square_of_the_joints(self):
        """What a Hessian has of entries; products and a factorisation written out would need the cube."""
        robots = [planar(n) for n in (16, 32)]
        solvers = [
            jtik.InverseKinematics(robot, jtik.FrameTask(), criteria=JointCentering(), strategy="hybrid+second_order")
            for robot in robots
        ]
        few, many = map(instructions, solvers)
        assert many <= 4.2 * few


def at_limit(q, limit):
    """Which joints are at a limit."""
    return np.abs(q) > limit - 1e-9


class TestOrder:
    @pytest.mark.slow
    @pytest.mark.parametrize("limit", [0.25, *slow(np.inf)])
    def test_ten_links_among_obstacles(self, limit):
        """Quadratic, with limits that bind and without; the projected gradient takes more steps to four digits less."""
        ik, plain = planar_solver(limit, "hybrid+second_order"), planar_solver(limit, "hybrid")
        steps, theirs, bound, quadratic = [], [], 0, 0
        for q0, target in planar_problems(limit, 8):
            solution = ik.solve(target, q0=q0, trace=True, **TIGHT)
            assert solution.status is jtik.Status.CONVERGED
            assert solution.second_order == "minimum"
            settled = [(at_limit(q, limit) == at_limit(solution.q, limit)).all() for q in solution.trace.q[:-1]]
            assert solution.trace.positive_definite[settled][-1:].all()
            steps.append(solution.iterations)
            theirs.append(plain.solve(target, q0=q0, optimality_tolerance=1e-8).iterations)
            bound += bool(solution.active_limits)
            # once narrow limits have settled who is at one, there may be but a step left to take, or none
            quadratic += is_quadratic(solution, ik.robot, least=2 if np.isinf(limit) else 1)
        assert quadratic >= (8 if np.isinf(limit) else 6)
        assert np.median(steps) < np.median(theirs) / 1.5
        assert bound == (0 if np.isinf(limit) else 8)

    @pytest.mark.slow
    @pytest.mark.parametrize("kind", ["position", *slow("pose")])
    @pytest.mark.parametrize("limit", [1.0, *slow(math.inf)])
    @pytest.mark.parametrize("primary", ["hybrid", *slow("newton")])
    def test_a_spatial_arm_with_a_criterion_of_the_user(self, primary, kind, limit, rng):
        robot, strategy = dh_arm(8, 3, limit), f"{primary}+second_order"
        ik = shared_solver(robot, jtik.FrameTask("tip", kind), criteria=elbow, strategy=strategy)
        for _ in range(4):
            q0 = rng.uniform(-0.6, 0.6, 8)
            target = robot.pose(np.clip(q0 + rng.uniform(-0.3, 0.3, 8), robot.lower, robot.upper))
            solution = ik.solve(target, q0=q0, trace=True, **TIGHT)
            assert solution.status is jtik.Status.CONVERGED
            assert is_quadratic(solution, robot, least=2 if np.isinf(limit) else 1)

    @pytest.mark.slow
    @pytest.mark.parametrize("arm", [ball_arm, *slow(floating_arm)])
    def test_manifolds_have_it_too(self, arm, rng):
        """The optimum is a valley, as the rotation about a link is free: the gradient falls quadratically."""
        robot = arm()
        ik = shared_solver(robot, jtik.FrameTask(), criteria=two_points, strategy="hybrid+second_order")
        for _ in range(3):
            q0 = robot.integrate(robot.neutral, rng.uniform(-0.4, 0.4, robot.n))
            q0 = np.clip(q0, robot.lower, robot.upper)
            target = robot.pose(robot.integrate(q0, rng.uniform(-0.1, 0.1, robot.n)))
            solution = ik.solve(target, q0=q0, trace=True, **TIGHT)
            assert solution.status is jtik.Status.CONVERGED
            assert solution.second_order == "flat"
            gradient = solution.trace.null_residual
            close = np.flatnonzero(gradient < 1e-2)[:-1]
            falls = gradient[close + 1] <= 50 * gradient[close] ** 1.5 + 1e-13
            assert falls[-2:].all()

    @pytest.mark.slow
    @pytest.mark.parametrize("count", [2, *slow(6)])
    def test_without_the_curvature_of_the_task_convergence_is_linear_to_a_minimum(self, count):
        exact = planar_solver(np.inf, "newton+second_order")
        strategy = Newton(secondary=SecondOrder(curvature="gauss_newton"))
        linear = planar_solver(np.inf, strategy)
        more = 0
        for q0, target in planar_problems(np.inf, count, seed=1):
            answers = [ik.solve(target, q0=q0, trace=True, **TIGHT) for ik in (exact, linear)]
            assert [answer.status for answer in answers] == [jtik.Status.CONVERGED] * 2
            again = exact.solve(target, q0=answers[1].q, **TIGHT)  # may be another minimum, but is one
            assert again.q == pytest.approx(answers[1].q, abs=1e-9)
            more += answers[1].iterations > answers[0].iterations
            assert not is_quadratic(answers[1], linear.robot)
        assert more == count

    def test_the_correction_saves_good_steps_from_the_merit(self):
        """A large multiplier of the task: the second-order error of a self-motion outweighs its decrease of H."""

        @jtik.criterion
        def priced(q, robot):
            return 0.5 * casadi.sumsqr(q - 0.3) + 20.0 * robot.position(q, "tip")[1]

        refused, q0 = [], np.array([0.9, 0.7, -0.5, 0.4, 0.8])
        for corrections in (0, 2):
            strategy = Newton(secondary=SecondOrder(corrections=corrections))
            ik = shared_solver(planar(5), jtik.FrameTask(), criteria=priced, strategy=strategy)
            solution = ik.solve(planar_points(q0)[-1], q0=q0, trace=True, **TIGHT)
            assert solution.status is jtik.Status.CONVERGED
            refused.append(int((solution.trace.accepted == 0).sum()))
        assert refused[0] > refused[1] == 0

    @pytest.mark.slow
    def test_and_along_a_valley_of_the_criterion(self):
        """H nearly flat along the self-motion: the error after one correction outweighs the decrease of H."""

        @jtik.criterion
        def valley(q, robot):
            return 5e-3 * casadi.sumsqr(q - 0.3) + 2.0 * robot.position(q, "tip")[1]

        refused, q0 = [], np.array([0.9, 0.7, -0.5, 0.4, 0.8])
        for corrections in (0, 1, 2):
            strategy = Newton(secondary=SecondOrder(corrections=corrections))
            ik = shared_solver(planar(5), jtik.FrameTask(), criteria=valley, strategy=strategy)
            options = {**TIGHT, "optimality_tolerance": 1e-9}
            solution = ik.solve(planar_points(q0)[-1], q0=q0, trace=True, **options)
            assert solution.status is jtik.Status.CONVERGED
            refused.append(int((solution.trace.accepted == 0).sum()))
        assert refused[0] > refused[1] > refused[2] == 0


class TestOptimum:
    @pytest.mark.quick(1)
    @pytest.mark.parametrize("limit", [np.inf, 0.25])
    def test_slsqp_finds_the_same_one(self, limit):
        """From beside it: H has many minima. SLSQP gets value and gradient of H from a solver without limits."""
        ik, free = planar_solver(limit, "hybrid+second_order"), planar_solver(np.inf, "hybrid")
        rng = np.random.default_rng(2)
        for q0, target in planar_problems(limit, 4, seed=3):
            solution = ik.solve(target, q0=q0, **TIGHT)
            assert solution.status is jtik.Status.CONVERGED
            other = minimize(
                lambda q, t=target: report_at(free, q, t).cost,
                np.clip(solution.q + rng.uniform(-0.01, 0.01, 10), -limit, limit),
                jac=lambda q, t=target: report_at(free, q, t).gradient,
                bounds=None if np.isinf(limit) else [(-limit, limit)] * 10,
                constraints={
                    "type": "eq",
                    "fun": lambda q, t=target: planar_points(q)[-1] - t,
                    "jac": planar_jacobian,
                },
                method="SLSQP",
                options={"ftol": 1e-15, "maxiter": 300},
            )
            assert np.linalg.norm(planar_points(other.x)[-1] - target) < 1e-9
            assert solution.cost == pytest.approx(other.fun, abs=SAME)
            assert solution.q == pytest.approx(other.x, abs=1e-5)

    @pytest.mark.slow
    def test_a_spatial_arm_too(self, rng):
        robot = dh_arm(7, 1, 0.5)
        ik = shared_solver(robot, jtik.FrameTask(), criteria=elbow, strategy="hybrid+second_order")
        free = shared_solver(robot, jtik.FrameTask(), criteria=elbow, limits=False)
        bound = 0
        for _ in range(4):
            q0 = rng.uniform(-0.4, 0.4, 7)
            target = robot.position(np.clip(q0 + rng.uniform(-0.3, 0.3, 7), -0.5, 0.5), "tip")
            solution = ik.solve(target, q0=q0, **TIGHT)
            assert solution.status is jtik.Status.CONVERGED
            bound += bool(solution.active_limits)
            other = minimize(
                lambda q, t=target: report_at(free, q, t).cost,
                np.clip(solution.q + rng.uniform(-0.01, 0.01, 7), -0.5, 0.5),
                jac=lambda q, t=target: report_at(free, q, t).gradient,
                bounds=[(-0.5, 0.5)] * 7,
                constraints={
                    "type": "eq",
                    "fun": lambda q, t=target: report_at(free, q, t).error,
                    "jac": lambda q, t=target: report_at(free, q, t).jacobian,
                },
                method="SLSQP",
                options={"ftol": 1e-15, "maxiter": 300},
            )
            assert solution.cost == pytest.approx(other.fun, abs=SAME)
        assert bound >= 1


ANGLE = 0.7
"""Of the first link of a trapezoid of three unit links, whose second is level and whose third goes down again."""

TRAPEZOID = np.array([ANGLE, -ANGLE, -ANGLE])


def four_bar(t):
    """Three unit links with the tip at that of the trapezoid and the first link at angle t, in closed form."""
    end = np.array([1 + 2 * math.cos(ANGLE), 0.0])
    first = np.array([math.cos(t), math.sin(t)])
    across = end - first
    half = np.linalg.norm(across) / 2
    second = first + across / 2 + math.sqrt(1 - half**2) * np.array([-across[1], across[0]]) / (2 * half)
    turns = [math.atan2(*link[::-1]) for link in (first, second - first, end - second)]
    return np.array([turns[0], turns[1] - turns[0], turns[2] - turns[1]])


class TestKindOfStationaryPoint:
    """Three links, tip fixed: a four-bar linkage, one self-motion. A symmetric H is stationary at the trapezoid.

    With until="reached" a solve does not leave it.
    """

    @staticmethod
    def solver(stiffness, strategy="newton+second_order"):
        @jtik.criterion
        def level(q, robot, *, stiffness=stiffness):
            return 0.5 * stiffness * (q[0] + q[1]) ** 2

        return shared_solver(planar(3), jtik.FrameTask(), criteria=level, strategy=strategy)

    @pytest.mark.parametrize(("stiffness", "kind"), [(2.0, "minimum"), (-2.0, "saddle"), (0.0, "flat")])
    def test_a_criterion_of_the_angle_of_the_second_link(self, stiffness, kind):
        """The unit self-motion turns link 2 by 2 cos a / sqrt(1 + 2 (1 + 2 cos a)^2); H'' has the square of that."""
        ik, target = self.solver(stiffness), planar_points(TRAPEZOID)[-1]
        sampled = [0.5 * stiffness * (four_bar(ANGLE + d)[:2].sum()) ** 2 for d in (-0.01, 0.0, 0.01)]
        assert four_bar(ANGLE) == pytest.approx(TRAPEZOID)
        assert np.sign(sampled[0] - 2 * sampled[1] + sampled[2]) == np.sign(stiffness)
        solution = ik.solve(target, q0=TRAPEZOID, until="reached")
        assert solution.status is (jtik.Status.SADDLE if kind == "saddle" else jtik.Status.CONVERGED)
        assert solution.second_order == kind
        cosine = math.cos(ANGLE)
        curvature = stiffness * (2 * cosine) ** 2 / (1 + 2 * (1 + 2 * cosine) ** 2)
        null = np.linalg.svd(solution.jacobian)[2][2]
        assert null @ solution.report.curvature(np.zeros(2)) @ null == pytest.approx(curvature, abs=1e-12)

    @pytest.mark.parametrize("stiffness", [1.0, -1.0])
    def test_the_multiplier_of_the_task_counts(self, stiffness):
        """H = height of the elbows: dH is not zero, and its Hessian alone does not decide. Against H on the curve."""

        @jtik.criterion
        def height(q, robot, *, stiffness=stiffness):
            return stiffness * (robot.position(q, "link2")[1] + robot.position(q, "link3")[1])

        def sampled(t):
            return stiffness * planar_points(four_bar(t))[:2, 1].sum()

        ik = shared_solver(planar(3), jtik.FrameTask(), criteria=height, strategy="newton+second_order")
        target = planar_points(TRAPEZOID)[-1]
        curvature = sampled(ANGLE - 1e-3) - 2 * sampled(ANGLE) + sampled(ANGLE + 1e-3)
        solution = ik.solve(target, q0=TRAPEZOID, until="reached")
        assert solution.status is (jtik.Status.CONVERGED if curvature > 0 else jtik.Status.SADDLE)
        assert np.linalg.norm(solution.gradient) > 0.1
        assert solution.second_order == ("minimum" if curvature > 0 else "saddle")

    def test_from_beside_a_saddle_it_goes_down(self):
        """A curvature that is not positive makes no Newton step towards the saddle."""
        ik, target = self.solver(-2.0), planar_points(TRAPEZOID)[-1]
        solution = ik.solve(target, q0=four_bar(ANGLE + 1e-3), trace=True)
        assert solution.trace.positive_definite[0] == 0
        assert solution.status is jtik.Status.CONVERGED
        assert solution.second_order == "minimum"
        assert solution.cost < -0.1

    def test_two_self_motions_of_opposite_curvature(self):
        """Three links, a task along x, springs at rest, any sign of stiffness: the eigenvalues are those of Z' K Z."""
        rest, kinds = np.array([0.3, 0.5, -0.4]), set()
        for stiffness in ((1.0, 2.0, 3.0), (1.0, -5.0, 1.0), (-1.0, -2.0, -3.0), (1.0, 0.0, 0.0)):
            K = np.diag(stiffness)

            @jtik.criterion
            def springs(q, robot, *, stiffness=stiffness):
                return 0.5 * casadi.dot(stiffness, (q - rest) ** 2)

            ik = shared_solver(planar(3), jtik.FrameTask(axes="x"), criteria=springs)
            null = np.linalg.svd(planar_jacobian(rest)[:1])[2][1:]
            lowest = np.linalg.eigvalsh(null @ K @ null.T)[0]
            expected = "flat" if abs(lowest) < 1e-9 else "minimum" if lowest > 0 else "saddle"
            solution = ik.solve(planar_points(rest)[-1], q0=rest, until="reached")
            assert solution.second_order == expected
            kinds.add(expected)
        assert kinds == {"minimum", "saddle", "flat"}

    def test_a_limit_makes_a_minimum_of_a_saddle(self):
        """The only self-motion is blocked by a limit: no direction remains."""
        robot = jtik.Robot.planar(3, lower=[-3.0, -3.0, -ANGLE], upper=[3.0, 3.0, 3.0])

        @jtik.criterion
        def downhill(q, robot):
            return q[2]

        ik = shared_solver(robot, jtik.FrameTask(), criteria=downhill, strategy="hybrid+second_order")
        start = four_bar(ANGLE + 0.05)
        start = start if start[2] > -ANGLE else four_bar(ANGLE - 0.05)
        solution = ik.solve(planar_points(TRAPEZOID)[-1], q0=start)
        assert solution.status is jtik.Status.CONVERGED
        assert solution.active_limits
        assert solution.q == pytest.approx(TRAPEZOID, abs=1e-6)
        assert solution.second_order == "minimum"

    def test_it_is_none_away_from_a_stationary_point_and_without_a_criterion(self):
        target = planar_points(TRAPEZOID)[-1]
        assert self.solver(2.0).solve(target, q0=four_bar(ANGLE + 0.1), max_iterations=0).second_order is None
        assert self.solver(2.0).solve((9.0, 0.0), q0=TRAPEZOID).second_order is None
        assert shared_solver(planar(3), jtik.FrameTask()).solve(target, q0=TRAPEZOID).second_order is None

    def test_it_is_copied_and_pickled(self):
        solution = self.solver(-2.0).solve(planar_points(TRAPEZOID)[-1], q0=TRAPEZOID, until="reached")
        for copied in (copy.copy(solution), pickle.loads(pickle.dumps(solution))):
            assert copied.second_order == "saddle"


@pytest.mark.slow
@pytest.mark.parametrize("strategy", ["hybrid+second_order", Hybrid(secondary=SecondOrder(curvature="gauss_newton"))])
def test_contract(strategy):
    check_strategy(strategy, samples=1)


@pytest.mark.parametrize(
    ("option", "value"),
    [("curvature", "none"), ("step_limit", 0.0), ("step_limit", math.inf), ("step_limit", math.nan)],
)
def test_options_are_checked(option, value):
    with pytest.raises(jtik.ArgumentError) as caught:
        SecondOrder(**{option: value})
    assert caught.value.argument == option

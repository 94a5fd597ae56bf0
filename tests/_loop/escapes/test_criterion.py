"""Criterion escapes: a solve that ends at a maximum or a saddle point of H on the self-motion leaves it.

Oracle of the closed form: a planar arm of three unit links, whose end effector is at T, and H = y^2 of the end of link
1, that is sin(q1)^2. Its self-motion covers the q1 where the end of link 1 is within 2 of T. At the ends of that range
joint 3 is straight, q3 = 0, and dH/dv vanishes over the self-motion: a maximum where H rises towards the end, otherwise
a minimum.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

import jtik
from jtik.symbolic import cos, sum1
from jtik_formulations import JointCentering, ObstacleAvoidance

from ...conftest import dh_arm, families_first, planar, planar_points, shared_solver, slow
from ..conftest import EVERY_STRATEGY, STRATEGIES, new_solver, solver

CRITERION_STRATEGIES = families_first(name for name in STRATEGIES if name != "weighted_qp")
"""Those whose end is a stationary point of H on the target; weighted_qp ends at one of a sum."""

TARGET_ERROR = 1e-6
"""The tolerance of a solve [m]."""

STATIONARY_H = 1e-10
"""Largest H - H* of these problems where the gradient is within the optimality tolerance of 1e-6."""

JUMP = 1e-3
"""Longest escape of a step without a time [rad]."""


@jtik.criterion
def height(q, robot):
    """The square of the height of the end of link 1."""
    return robot.position(q, "link2")[1] ** 2


@jtik.criterion
def upright(q, robot):
    """The sum of the cosines of the angles: bounded, with maxima, minima and saddle points."""
    return sum1(cos(q))


@functools.cache
def arm(criteria=height, strategy="hybrid", **options):
    return solver(planar(3, **options), criteria=criteria, strategy=strategy)


def outstretched(q1, q2):
    """Links 2 and 3 in line: an end of the range of q1. The configuration and its target."""
    q = np.array([q1, q2, 0.0])
    return q, planar_points(q)[-1]


def rises_towards_the_end(q1, q2):
    """Whether sin(q1)^2 rises where the self-motion takes q1 to its end: there |T - p1| becomes 2."""
    p1, target = np.array([math.cos(q1), math.sin(q1)]), planar_points(np.array([q1, q2, 0.0]))[-1]
    # d|T - p1|/dq1 is positive where a growing q1 leads to the end
    towards_end = (p1 - target) @ np.array([-math.sin(q1), math.cos(q1)])
    return math.sin(2 * q1) * towards_end > 0


MAXIMUM, MINIMUM = (0.9, -1.3), (0.9, 1.3)


def test_the_cases_are_what_they_are_called():
    assert rises_towards_the_end(*MAXIMUM)
    assert not rises_towards_the_end(*MINIMUM)


class TestSolve:
    @pytest.mark.thinned(together=True)
    @pytest.mark.parametrize("strategy", EVERY_STRATEGY)
    def test_it_leaves_a_maximum(self, strategy):
        q0, target = outstretched(*MAXIMUM)
        solution = arm(strategy=strategy).solve(target, q0=q0, trace=True)
        assert solution.status is jtik.Status.CONVERGED
        assert solution.escapes == solution.trace.escaped.sum() == 1
        assert solution.second_order == "minimum"
        assert solution.cost == pytest.approx(0.0, abs=STATIONARY_H)  # q1 = 0 is in the range
        assert planar_points(solution.q)[-1] == pytest.approx(target, abs=TARGET_ERROR)
        assert len(solution.trace) == solution.iterations
        assert "escapes     1" in repr(solution)

    @pytest.mark.thinned(together=True)
    @pytest.mark.parametrize("strategy", CRITERION_STRATEGIES)
    def test_the_maximum_to_which_the_opposite_criterion_led(self, strategy):
        up, down = arm(-1.0 * height, strategy), arm(height, strategy)
        highest = up.solve([1.5, 0.6], q0=[0.3, 0.4, 0.5])
        assert highest.converged
        solution = down.solve([1.5, 0.6], q0=highest.q)
        assert (solution.converged, solution.escapes, solution.second_order) == (True, 1, "minimum")
        assert solution.cost == pytest.approx(0.0, abs=STATIONARY_H)

    def test_what_second_order_says_is_the_sign_of_the_closed_form(self, rng):
        ends = {"saddle": 0, "minimum": 0}
        for q1, q2 in zip(rng.uniform(-3, 3, 60), rng.uniform(-2.5, 2.5, 60), strict=True):
            q0, target = outstretched(q1, q2)
            if abs(math.sin(2 * q1)) < 0.1 or abs(math.sin(q2)) < 0.1:
                continue  # nearly flat, or nearly singular
            kind = "saddle" if rises_towards_the_end(q1, q2) else "minimum"
            ends[kind] += 1
            stays = arm().solve(target, q0=q0, until="reached")
            assert stays.second_order == kind
            solution = arm().solve(target, q0=q0)
            assert solution.converged
            assert solution.escapes == (kind == "saddle")
            assert solution.second_order == "minimum"
            if kind == "minimum":
                assert solution.q.tolist() == q0.tolist()  # no move at all
                assert solution.iterations == 0
            else:
                assert solution.cost < stays.cost
        assert min(ends.values()) > 10

    def test_it_is_deterministic(self):
        q0, target = outstretched(*MAXIMUM)
        first, again = (solver(planar(3), criteria=height).solve(target, q0=q0, trace=True) for _ in range(2))
        assert first.trace.q.tolist() == again.trace.q.tolist()

    def test_a_tie_is_broken_by_a_convention(self):
        """Joint 2 is where the end effector is: it turns freely, and either way is equally good for H = -q2^2 / 2."""
        ik = solver(planar(3), criteria=-1.0 * JointCentering({"joint1": 0.0, "joint2": 1.0, "joint3": 0.0}))
        solution = ik.solve([1.0, 0.0], q0=[0.0, 0.0, math.pi])
        assert solution.escapes >= 1
        assert solution.q[1] > 0.1

    def test_with_restarts_too(self):
        q0, target = outstretched(*MAXIMUM)
        solution = arm().solve(target, q0=q0, restarts=5)
        assert (solution.converged, solution.escapes, solution.restarts) == (True, 1, 0)

    def test_in_a_batch_too(self):
        starts = [outstretched(*MAXIMUM), outstretched(*MINIMUM)]
        batch = arm().solve_batch([target for _, target in starts], q0=np.array([q for q, _ in starts]))
        assert batch.converged.all()
        assert batch.escapes.tolist() == [1, 0]

    @pytest.mark.slow
    def test_compiled_it_does_the_same(self):
        q0, target = outstretched(*MAXIMUM)
        compiled = solver(planar(3), criteria=height, compiled=True)
        solution, plain = compiled.solve(target, q0=q0), arm().solve(target, q0=q0)
        assert (solution.escapes, solution.status) == (1, plain.status)
        assert solution.q == pytest.approx(plain.q, abs=1e-9)
        batch = compiled.solve_batch([target], q0=q0)
        assert batch.escapes.tolist() == [1]
        assert batch.q[0].tolist() == solution.q.tolist()

    @pytest.mark.thinned
    @pytest.mark.parametrize("compiled", [False, True])
    @pytest.mark.parametrize("restarts", [0, 3])
    def test_joints_that_can_turn_all_the_way_round(self, compiled, restarts):
        """They move without limits and are brought back."""
        q0, target = outstretched(*MAXIMUM)
        robot = planar(3, lower=-math.pi, upper=math.pi)
        ik = solver(robot, criteria=height, compiled=compiled)
        for start in (q0, q0 + np.array([0.0, 0.0, 2e-10])):
            solution = ik.solve(target, q0=start, restarts=restarts)
            assert (solution.status, solution.escapes, solution.restarts) == (jtik.Status.CONVERGED, 1, 0)
            assert solution.cost == pytest.approx(0.0, abs=STATIONARY_H)
            assert np.abs(solution.q).max() <= math.pi
        batch = ik.solve_batch([target] * 2, q0=q0, restarts=restarts)
        assert batch.escapes.tolist() == [1, 1]

    def test_within_a_jump_limit(self):
        q0, target = outstretched(*MAXIMUM)
        limited = arm(lower=-3.0, upper=3.0)
        solution = limited.solve(target, q0=q0, restarts=1, jump_limit=0.2)
        assert solution.escapes >= 1
        assert np.abs(solution.q - q0).max() <= 0.2 + 1e-12
        assert solution.cost < math.sin(q0[0]) ** 2

    def test_a_start_in_a_plane_of_symmetry_stays_in_it_until_it_escapes(self):
        """Many steps in the plane of a Panda whose odd joints are zero, then out of it, where H is lower."""
        robot = jtik.Robot.builtin("panda")

        @jtik.criterion
        def odd_joints_away(q, robot):
            return cos(q[0]) + cos(q[2]) + cos(q[4]) + 0.3 * ((q[1] - 0.2) ** 2 + (q[5] - 1.2) ** 2 + q[6] ** 2)

        ik = shared_solver(robot, jtik.FrameTask(kind="position"), criteria=odd_joints_away)
        q0 = np.array([0.0, 0.4, 0.0, -1.8, 0.0, 1.9, 0.5])
        target = robot.position(np.array([0.0, 0.1, 0.0, -1.5, 0.0, 1.4, 0.5]), robot.tip)
        solution = ik.solve(target, q0=q0, trace=True)
        escape = int(np.argmax(solution.trace.escaped))
        assert escape > 3
        assert np.abs(solution.trace.q[escape][[0, 2, 4]]).max() < 1e-3
        assert np.abs(solution.q[[0, 2, 4]]).max() > 0.5
        assert solution.converged
        assert solution.second_order == "minimum"

    @pytest.mark.thinned
    @pytest.mark.parametrize("strategy", ["hybrid", *slow("newton+qp", "hybrid+second_order", "sns")])
    @pytest.mark.parametrize("kind", ["position", *slow("pose")])
    def test_from_any_maximum_or_saddle_a_spatial_arm_gets_to_a_minimum(self, strategy, kind, rng):
        robot = dh_arm(7, 3)
        up, down = (solver(robot, kind=kind, strategy=strategy, criteria=sign * upright) for sign in (-1.0, 1.0))
        left = 0
        for _ in range(8):
            q = robot.random_configuration(rng)
            target = robot.pose(q, "tip") if kind == "pose" else robot.position(q, "tip")
            highest = up.solve(target, q0=q)
            if not highest.converged or up.solve(target, q0=highest.q).second_order != "minimum":
                continue
            left += 1
            solution = down.solve(target, q0=highest.q)
            assert solution.converged
            assert solution.escapes >= 1
            assert solution.second_order in ("minimum", "flat")
            assert solution.cost < -highest.cost - 1e-3
            assert lowest_nearby(robot, kind, target, solution.q, rng) >= solution.cost - 1e-9
        assert left >= 4

    @pytest.mark.parametrize("strategy", ["hybrid", "damped", "lexicographic_qp"])
    def test_limits_are_kept(self, strategy):
        robot = planar(3, lower=(-3.0, -3.0, 0.0), upper=(3.0, 3.0, 3.0))
        q0, target = outstretched(*MAXIMUM)
        solution = solver(robot, criteria=height, strategy=strategy).solve(target, q0=q0, trace=True)
        assert solution.escapes == 1
        assert (solution.trace.q >= robot.lower).all()
        assert solution.cost == pytest.approx(0.0, abs=STATIONARY_H)

    def test_at_a_limit_it_leaves_in_the_only_direction_that_is_left(self):
        """Joint 3 is at its limit, without a multiplier: either sign of the direction is allowed by one robot."""
        q0, target = outstretched(*MAXIMUM)
        for lower, upper, side in ((0.0, 3.0, 1.0), (-3.0, 0.0, -1.0)):
            robot = planar(3, lower=(-3.0, -3.0, lower), upper=(3.0, 3.0, upper))
            ik = solver(robot, criteria=height)
            assert ik.solve(target, q0=q0, until="reached").second_order == "saddle"
            solution = ik.solve(target, q0=q0)
            assert (solution.converged, solution.escapes) == (True, 1)
            assert side * solution.q[2] > 0.1

    def test_a_joint_without_room_stays_and_the_status_says_so(self):
        """Joint 2 is not at its limits, but may not move by more than rounding."""
        q0, target = outstretched(*MAXIMUM)
        window = 3e-9
        lower, upper = np.array([-3.0, q0[1] - window, -3.0]), np.array([3.0, q0[1] + window, 3.0])
        solution = solver(jtik.Robot.planar(3, lower=lower, upper=upper), criteria=height).solve(target, q0=q0)
        assert solution.status is jtik.Status.SADDLE
        assert not solution.converged
        assert solution.second_order == "saddle"
        assert solution.q.tolist() == q0.tolist()
        assert "saddle point or a maximum" in repr(solution)

    @pytest.mark.thinned
    @pytest.mark.parametrize("room", [0.01, 0.3])
    @pytest.mark.parametrize("strategy", ["hybrid+qp", "lexicographic_qp"])
    def test_clearances_are_kept(self, strategy, room):
        """Two circles, one on each side of joint 3: it leaves the line as far as its clearance allows."""
        q0, target = outstretched(*MAXIMUM)
        p1, joint3, _ = planar_points(q0)
        normal = np.array([[0.0, -1.0], [1.0, 0.0]]) @ (joint3 - p1)
        safe, radius, margin = 0.05, 0.1, 1e-3
        centers = [joint3 + side * (radius + safe + margin + room) * normal for side in (1, -1)]
        measure = ObstacleAvoidance([jtik.Circle(center, radius) for center in centers], bodies="joints")
        clearance = jtik.Clearance(measure, safe=safe, margin=margin)
        ik = solver(planar(3), criteria=height, strategy=strategy, clearances=clearance)
        solution = ik.solve(target, q0=q0, trace=True)
        distances = [np.linalg.norm(planar_points(q)[1] - centers, axis=1) - radius for q in solution.trace.q]
        assert np.min(distances) >= safe
        assert np.min(distances[-1]) == pytest.approx(safe + margin, abs=2 * margin)
        assert (solution.status, solution.escapes) == (jtik.Status.CONVERGED, 1)
        assert solution.cost < math.sin(q0[0]) ** 2

    def test_until_reached_stays_and_succeeds(self):
        q0, target = outstretched(*MAXIMUM)
        solution = arm().solve(target, q0=q0, until="reached")
        assert (solution.status, solution.converged, solution.escapes) == (jtik.Status.SADDLE, True, 0)
        assert solution.q.tolist() == q0.tolist()

    def test_a_flat_criterion_stays(self):
        """H has the same value everywhere on the self-motion."""

        @jtik.criterion
        def height_of_the_tip(q, robot):
            return robot.position(q, "tip")[1] ** 2

        q0 = np.array([0.3, 0.8, -0.4])
        ik = solver(planar(3), criteria=height_of_the_tip)
        solution = ik.solve(planar_points(q0)[-1], q0=q0)
        assert (solution.converged, solution.second_order, solution.escapes) == (True, "flat", 0)
        assert solution.q.tolist() == q0.tolist()

    @pytest.mark.parametrize("sign", [1.0, -1.0])
    def test_an_outstretched_arm_at_full_reach_has_nowhere_to_go(self, sign):
        """Its target is at 3: the set of solutions is a point, although J has a null space of two dimensions."""
        solution = arm(sign * JointCentering()).solve([3.0, 0.0], q0=np.zeros(3))
        assert (solution.status, solution.escapes) == (jtik.Status.CONVERGED, 0)
        assert solution.second_order == ("minimum" if sign > 0 else "flat")

    def test_redundant_rows_of_a_task_do_not_prevent_it(self):
        """The pose of a planar arm has rows that are zero for every motion: J never has full rank."""
        robot, q0 = planar(4), np.array([0.9, -1.3, 0.0, 0.7])
        ik = solver(robot, kind="pose", criteria=upright)
        solution = ik.solve(robot.pose(q0, "tip"), q0=ik.solve(robot.pose(q0, "tip"), q0=q0).q)
        assert solution.converged
        up = solver(robot, kind="pose", criteria=-1.0 * upright).solve(robot.pose(q0, "tip"), q0=q0)
        away = ik.solve(robot.pose(q0, "tip"), q0=up.q)
        assert (up.second_order, away.escapes, away.second_order) == ("minimum", 1, "minimum")

    def test_a_limit_below_and_above_at_once_fixes_a_joint(self):
        q0, target = np.array([0.9, -1.3, 0.4, 0.2]), planar_points(np.array([0.9, -1.3, 0.4, 0.2]))[-1]
        lower, upper = np.full(4, -3.0), np.full(4, 3.0)
        lower[0] = upper[0] = q0[0]
        robot = jtik.Robot.planar(4, lower=lower, upper=upper)
        fixed = solver(robot, criteria=JointCentering(), strategy="sns")
        solution = fixed.solve(target, q0=q0)
        assert (solution.converged, solution.second_order) == (True, "minimum")


def lowest_nearby(robot, kind, target, q, rng, distance=1e-3):
    """The smallest H of twenty configurations at that distance on the self-motion, by Newton's method in NumPy."""

    def error(at):
        position = robot.position(at, "tip")
        if kind == "position":
            return position - target
        rotation = target[:3, :3].T @ robot.pose(at, "tip")[:3, :3]
        return np.concatenate([position - target[:3, 3], [rotation[2, 1], rotation[0, 2], rotation[1, 0]]])

    def jacobian(at):
        steps = 1e-6 * np.eye(robot.n)
        return np.array([(error(at + step) - error(at - step)) / 2e-6 for step in steps]).T

    found = []
    null = np.linalg.svd(jacobian(q))[2][len(error(q)) :]
    for _ in range(20):
        direction = rng.normal(size=len(null)) @ null
        moved = q + distance * direction / np.linalg.norm(direction)
        for _ in range(4):
            moved = moved - np.linalg.pinv(jacobian(moved)) @ (error(moved) - error(q))
        found.append(float(np.cos(moved).sum()))
    return min(found)


class TestStep:
    @pytest.mark.thinned(together=True)
    @pytest.mark.parametrize("strategy", EVERY_STRATEGY)
    def test_it_leaves_a_maximum_without_a_jump(self, strategy):
        q, target = outstretched(*MAXIMUM)
        ik, escapes = solver(planar(3), criteria=height, strategy=strategy), 0
        for _ in range(400):
            step = ik.step(q, target)
            if step.escaped:
                assert np.linalg.norm(step.q - q) <= (1 + 1e-6) * JUMP
                assert step.position_error <= TARGET_ERROR
                assert not step.done
                escapes += 1
            q = step.q
        assert escapes >= 1
        assert math.sin(q[0]) ** 2 == pytest.approx(0.0, abs=STATIONARY_H)

    @pytest.mark.thinned
    @pytest.mark.parametrize("acceleration", [None, 20.0])
    @pytest.mark.parametrize("dt", [0.001, 0.02])
    def test_a_timed_one_keeps_its_limits_on_the_way(self, dt, acceleration):
        q, target = outstretched(*MAXIMUM)
        limits = jtik.Limits(velocity=1.0, acceleration=acceleration)
        ik = solver(planar(3), criteria=height, limits=limits)
        before, escapes, velocity = math.sin(q[0]) ** 2, 0, np.zeros(3)
        for _ in range(round(8 / dt)):
            step = ik.step(q, target, dt=dt)
            now = (step.q - q) / dt
            assert np.abs(now).max() <= 1.0 + 1e-9
            if acceleration:
                assert np.abs(now - velocity).max() <= acceleration * dt + 1e-9
            escapes += step.escaped
            q, velocity = step.q, now
            assert step.position_error <= 1e-3
        assert 1 <= escapes <= 50
        assert math.sin(q[0]) ** 2 < 1e-3 * before

    def test_at_rest_the_second_derivatives_are_evaluated_once(self, monkeypatch):
        q, target = outstretched(*MINIMUM)
        other = planar_points(np.add(q, [0.3, 0.2, 0.1]))[-1]
        q_other = arm().solve(other, q0=q).q
        ik, calls = solver(planar(3), criteria=height), []
        inspector = ik._engine._inspector
        saddle = type(inspector).saddle
        monkeypatch.setattr(type(inspector), "saddle", lambda *args: calls.append(1) or saddle(*args))
        for _ in range(10):
            step = ik.step(q, target)
            assert (step.done, step.escaped, step.q.tolist()) == (True, False, q.tolist())
        assert len(calls) == 1
        for _ in range(10):
            assert ik.step(q_other, other).done
        assert len(calls) == 2

    def test_a_rest_at_another_configuration_is_another_rest(self):
        """From the minimum, then from the maximum of the same problem."""
        q0, target = outstretched(*MAXIMUM)
        ik = solver(planar(3), criteria=height)
        lowest = ik.solve(target, q0=q0).q
        assert ik.step(lowest, target).done
        assert ik.step(q0, target).escaped

    def test_a_parameter_that_turns_the_minimum_into_a_maximum(self):
        q, target = outstretched(*MINIMUM)
        ik = solver(planar(3), criteria=height)
        assert ik.step(q, target).done
        ik.parameters["height.weight"] = -1.0
        assert ik.step(q, target).escaped

    def test_warm_up_builds_what_it_needs(self):
        ik = new_solver(planar(3), criteria=height)
        ik.warm_up()
        inspector = ik._engine._inspector
        assert "_hessian" in vars(inspector)
        assert "_function" in vars(inspector._certificate)


def test_track_escapes_within_the_limits_of_its_steps():
    q0, target = outstretched(*MAXIMUM)
    ik = solver(planar(3), criteria=height, limits=jtik.Limits(velocity=1.0))
    path = ik.track([target] * 200, q0=q0, dt=0.02, until="stationary")
    assert np.abs(path.dq).max() <= 1.0 + 1e-9
    assert math.sin(path.q[-1][0]) ** 2 == pytest.approx(0.0, abs=STATIONARY_H)

"""The transpose method: alpha, S and Q as derived and as printed."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

import jtik
from jtik_formulations import Newton, Transpose

from ..conftest import EXACT, dh_arm, planar, planar_jacobian, planar_points, shared_solver

WORKED = 1e-8
"""The worked numbers are printed to eight digits."""

MACHINE = 1e-15
"""Two ways to write the same product, relative to the step."""

BARE = {"backtracking": False, "q_limit": math.inf}


def solver(robot, strategy, **task):
    return shared_solver(robot, jtik.FrameTask("tip", **task), strategy=strategy, limits=False)


@functools.cache
def _kept(robot, strategy, kind, axes):
    return solver(robot, strategy, kind=kind, axes=axes)


def first_step(robot, strategy, q, target, kind="position", axes=None):
    """The step dq from q, taken without limits and without a past."""
    ik = _kept(robot, strategy, kind, axes)
    ik.reset()
    return ik.step(q, target).q - q


def optimal(J, u, S=None):
    """alpha = u'M u / u'M M u and the step -alpha S J' u, M = J S J'."""
    S = np.eye(J.shape[1]) if S is None else S
    M = J @ S @ J.T
    alpha = (u @ M @ u) / (u @ M @ M @ u)
    return alpha, -alpha * S @ J.T @ u


def test_one_worked_step():
    """Unit 2R, q = (0, pi/2), target (0, 1.5)."""
    q0 = np.array([0.0, np.pi / 2])
    solution = solver(planar(2), Transpose(**BARE)).solve((0.0, 1.5), q0=q0, max_iterations=1, trace=True)
    trace = solution.trace
    assert solution.q - q0 == pytest.approx([0.57352941, 0.38235294], abs=WORKED)
    assert trace.alpha[0] == pytest.approx(13 / 34, abs=EXACT)
    assert trace.V[0] == pytest.approx(0.625, abs=EXACT)
    assert trace.V[0] - trace.predicted_decrease[0] == pytest.approx(0.00367647, abs=WORKED)
    assert trace.V[0] - trace.actual_decrease[0] == pytest.approx(0.07266294, abs=WORKED)
    assert trace.error[1] ** 2 / 2 == pytest.approx(0.07266294, abs=WORKED)


@pytest.mark.parametrize("strategy", [Transpose(**BARE), Transpose(rule="paper", **BARE)])
def test_alpha_is_the_exact_minimum_along_the_step(strategy, rng):
    for n in (2, 5, 10):
        for _ in range(10):
            q = rng.uniform(-1, 1, n)
            target = planar_points(rng.uniform(-1, 1, n))[-1]
            J, e = planar_jacobian(q), planar_points(q)[-1] - target
            alpha, dq = optimal(J, e)
            assert first_step(planar(n), strategy, q, target) == pytest.approx(dq, abs=EXACT * (1 + np.abs(dq).max()))
            values = [np.sum((e - a * J @ J.T @ e) ** 2) for a in (0.99 * alpha, alpha, 1.01 * alpha)]
            assert values[1] == min(values)


class TestEqualToNewton:
    """With one row in the task, u is an eigenvector of J J', and the transpose step is Newton's."""

    @pytest.mark.parametrize("strategy", [Transpose(**BARE), Transpose(rule="paper", **BARE)])
    def test_one_degree_of_freedom(self, strategy, rng):
        robot = jtik.Robot.planar([0.7])
        for _ in range(20):
            q = rng.uniform(-2.5, 2.5, 1)
            target = np.array([0.7 * np.cos(q[0] + rng.uniform(-0.5, 0.5)), 0.0])
            e, j = 0.7 * np.cos(q[0]) - target[0], -0.7 * np.sin(q[0])
            for each in (strategy, Newton(**BARE)):
                dq = first_step(robot, each, q, target, axes="x")
                assert dq[0] == pytest.approx(-e / j, rel=1e-13)

    @pytest.mark.thinned
    @pytest.mark.parametrize("axis", ["x", "y"])
    @pytest.mark.parametrize("n", [2, 5, 12])
    def test_one_task_coordinate(self, axis, n, rng):
        for _ in range(10):
            q, target = rng.uniform(-1, 1, n), rng.uniform(-2, 2, 2)
            transpose = first_step(planar(n), Transpose(**BARE), q, target, axes=axis)
            newton = first_step(planar(n), Newton(**BARE), q, target, axes=axis)
            # q + dq is rounded at the size of q, the step itself to MACHINE
            assert transpose == pytest.approx(newton, rel=10 * MACHINE, abs=1e-15)

    @pytest.mark.parametrize("axis", ["x", "rz", "ry"])
    def test_one_task_coordinate_in_space(self, axis, rng):
        robot = dh_arm(6, 3)
        for _ in range(5):
            q = robot.random_configuration(rng)
            target = robot.pose(q + 0.1)
            steps = [
                first_step(robot, strategy, q, target, kind="pose", axes=(axis,))
                for strategy in (Transpose(**BARE), Newton(**BARE))
            ]
            assert steps[0] == pytest.approx(steps[1], rel=1e-12, abs=1e-15)


class TestS:
    @pytest.mark.quick(1)
    @pytest.mark.parametrize("limit", [0.01, 0.1, 0.5])
    def test_as_printed_it_changes_nothing_on_an_all_revolute_arm(self, limit, rng):
        """alpha(S) S does not depend on S = s I."""
        active = 0
        for n in (2, 10):
            for _ in range(10):
                q, target = rng.uniform(-1, 1, n), rng.uniform(-n, n, 2)
                with_S = Transpose(rule="paper", q_limit=limit, backtracking=False)
                without = first_step(planar(n), Transpose(rule="paper", **BARE), q, target)
                limited = first_step(planar(n), with_S, q, target)
                active += np.linalg.norm(without) > limit  # so that S is not I
                assert limited == pytest.approx(without, rel=MACHINE, abs=MACHINE)
        assert active > 5

    def test_after_alpha_it_limits_the_step(self, rng):
        for _ in range(20):
            q, target = rng.uniform(-1, 1, 6), rng.uniform(-6, 6, 2)
            free = first_step(planar(6), Transpose(**BARE), q, target)
            for limit in (0.05, 0.5, 3.0):
                dq = first_step(planar(6), Transpose(q_limit=limit, backtracking=False), q, target)
                scale = min(1.0, limit / np.linalg.norm(free))
                assert dq == pytest.approx(scale * free, abs=1e-14 * (1 + np.abs(free).max()))

    def test_prismatic_joints_are_not_counted(self, rng):
        robot = jtik.Robot.vehicle(3)
        for _ in range(10):
            q, target = rng.uniform(-1, 1, 5), rng.uniform(20, 60, 2)
            J, e = robot.jacobian(q)[:2], robot.position(q) - target
            alpha0, dq0 = optimal(J, e)
            s = min(1, 0.5 / np.linalg.norm(dq0[2:]))
            S = np.diag([1, 1, s, s, s])
            alphaS, _ = optimal(J, e, S)
            alpha = min(alpha0, alphaS)
            dq = first_step(robot, Transpose(backtracking=False), q, target)
            assert dq == pytest.approx(-alpha * S @ J.T @ e, rel=1e-11, abs=1e-11)
            assert np.linalg.norm(dq[2:]) <= 0.5 + EXACT

    @pytest.mark.parametrize("heading", [False, True])
    def test_the_vehicle_approaches_first(self, heading, rng):
        """A far target: the revolute joints turn by the limit, the prismatic joints do most of the motion."""
        robot = jtik.Robot.vehicle(3, heading=heading)
        ik = solver(robot, Transpose(q_limit=0.1))
        for _ in range(10):
            q0 = np.append([0.0, 0.0], rng.uniform(-0.5, 0.5, robot.n - 2))
            target = rng.uniform(30, 60) * np.array([np.cos(a := rng.uniform(-3, 3)), np.sin(a)])
            solution = ik.solve(target, q0=q0, max_iterations=1, trace=True)
            dq = solution.q - q0
            assert solution.trace.accepted[0] == 1
            assert np.linalg.norm(dq[2:]) <= 0.1 + EXACT
            ahead = target - robot.position(q0)
            ahead /= np.linalg.norm(ahead)
            driven, moved = dq[:2] @ ahead, (robot.position(solution.q) - robot.position(q0)) @ ahead
            assert driven > 0.5 * moved > 0
            assert solution.trace.predicted_decrease[0] > 0
            assert solution.trace.actual_decrease[0] > 0

    def test_a_vehicle_whose_arm_points_at_the_target_nearly_arrives_in_one_step(self):
        robot = jtik.Robot.vehicle(3)
        q0 = np.array([0.0, 0.0, 0.3, 0.3, 0.3])
        target = np.array([40.0, 30.0])
        dq = first_step(robot, Transpose(q_limit=0.5), q0, target)
        assert np.linalg.norm(dq[:2]) > 0.8 * np.linalg.norm(robot.position(q0) - target)

    def test_predicted_V_falls_on_mixed_arms_whatever_the_limit(self, rng):
        robot = jtik.Robot.vehicle(4, heading=True)
        for limit in (1e-3, 0.1, 1.0):
            ik = solver(robot, Transpose(q_limit=limit, backtracking=False))
            for _ in range(10):
                q, target = rng.uniform(-1, 1, 7), rng.uniform(-30, 30, 2)
                trace = ik.solve(target, q0=q, max_iterations=1, trace=True).trace
                assert 0 < trace.predicted_decrease[0] <= trace.V[0]


def test_backtracking_halves_a_step_that_does_not_lower_V(rng):
    ik, refusals = solver(planar(10), Transpose(q_limit=math.inf)), 0
    for _ in range(40):
        target = planar_points(rng.uniform(-np.pi, np.pi, 10))[-1]
        trace = ik.solve(target, q0=rng.uniform(-np.pi, np.pi, 10), trace=True, max_iterations=100).trace
        for k in np.flatnonzero(trace.accepted[:-1] == 0):
            refusals += 1
            assert trace.actual_decrease[k] < trace.predicted_decrease[k]
            assert trace.q[k + 1].tolist() == trace.q[k].tolist()
            assert trace.step_length[k + 1] == pytest.approx(trace.step_length[k] / 2, rel=1e-12)
    assert refusals >= 3


def test_without_backtracking_every_step_is_taken(rng):
    trace = (
        solver(planar(6), Transpose(**BARE))
        .solve((1.0, 2.0), q0=rng.uniform(-1, 1, 6), trace=True, max_iterations=50)
        .trace
    )
    assert (trace.accepted == 1).all()


@pytest.mark.parametrize("options", [{"rule": "printed"}, {"q_limit": 0.0}, {"q_limit": -1.0}, {"q_limit": math.nan}])
def test_options_out_of_range_are_refused(options):
    with pytest.raises(jtik.ArgumentError) as caught:
        Transpose(**options)
    assert caught.value.argument == next(iter(options))


def test_a_strategy_is_a_value():
    assert Transpose() == Transpose(q_limit=0.5)
    assert Transpose() != Transpose(q_limit=0.4)
    assert "q_limit=0.5" in repr(Transpose())
    with pytest.raises(AttributeError):
        Transpose().q_limit = 1.0
    with pytest.raises(TypeError):
        Transpose("paper")

"""The null-space step as a quadratic program: the projection without active limits, else the constrained optimum.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import numpy as np
import pytest
import qpsolvers

import jtik
from jtik_formulations import Hybrid, JointCentering, Manipulability, Newton, ProjectedGradient, QPSecondary, Transpose

from ..conftest import ball_arm, dh_arm, floating_arm, planar, planar_jacobian, shared_solver, slow

pytestmark = pytest.mark.thinned

SAME = 1e-10
"""Difference of a projection and a QP solved by an active-set method."""

PRIMARIES = ["transpose", "newton", "damped", "hybrid"]


@jtik.criterion
def posture(q, robot):
    """Something other than a parabola, of every entry of q."""
    return sum((q[i] - 0.3 * (i % 3)) ** 2 + 0.1 * (q[i] + 0.2) ** 4 for i in range(robot.nq))


def solver(robot, strategy, kind="position", criteria=posture, **options):
    return shared_solver(robot, jtik.FrameTask("tip", kind), criteria=criteria, strategy=strategy, **options)


ROBOTS = {
    "planar": (lambda: planar(6), "position"),
    "pose": (lambda: planar(6), "pose"),
    "spatial": (lambda: dh_arm(8, 1), "pose"),
    "ball": (ball_arm, "position"),
    "floating": (floating_arm, "position"),
    "vehicle": (lambda: jtik.Robot.vehicle(3), "position"),
}


@pytest.mark.quick(2)
@pytest.mark.parametrize("primary", ["hybrid", *slow("transpose", "newton", "damped")])
@pytest.mark.parametrize("name", ROBOTS)
def test_without_limits_it_is_the_projected_gradient(primary, name, rng):
    build, kind = ROBOTS[name]
    robot = build()
    projected, program = (solver(robot, primary + suffix, kind, limits=False) for suffix in ("+gradient", "+qp"))
    for _ in range(4):
        q = robot.random_configuration(rng)
        target = robot.pose(robot.integrate(q, rng.uniform(-0.1, 0.1, robot.n)))
        for ik in (projected, program):
            ik.reset()
        p = q
        for _ in range(6):
            a, b = projected.step(q, target), program.step(p, target)
            assert a.accepted == b.accepted
            assert b.q == pytest.approx(a.q, abs=SAME)
            q, p = a.q, b.q


def test_at_a_singular_pose_too():
    """A straight arm: one row of the task is dependent, and what it frees belongs to the null space."""
    projected, program = (solver(planar(5), "newton" + suffix) for suffix in ("", "+qp"))
    target = np.array([4.9, 0.3])
    step = program.step(np.zeros(5), target)
    assert step.accepted
    assert step.q == pytest.approx(projected.step(np.zeros(5), target).q, abs=SAME)


def test_a_weight_makes_a_joint_lazy(rng):
    q = rng.uniform(-0.5, 0.5, 6)
    W = np.array([1.0, 1, 1, 50, 1, 1])
    ik = solver(planar(6), Newton(secondary=QPSecondary(weight=tuple(W))))
    problem = ik.build(q, planar(6).position(q))
    gradient = problem.q
    Wi, J = np.diag(1 / W), planar_jacobian(q)
    expected = -(Wi - Wi @ J.T @ np.linalg.solve(J @ Wi @ J.T, J @ Wi)) @ gradient
    assert qpsolvers.solve_problem(problem, solver="daqp").x == pytest.approx(expected, abs=1e-9)
    even = -(np.eye(6) - np.linalg.pinv(J) @ J) @ gradient
    assert abs(expected[3]) < 0.2 * abs(even[3])


@pytest.mark.quick(2)
@pytest.mark.parametrize("primary", PRIMARIES)
def test_limits_are_in_the_quadratic_program(primary, rng):
    """The step is optimal among all that keep to the box: multipliers of the right sign, by qpsolvers' own check."""
    robot = planar(6, lower=-0.6, upper=0.6)
    ik = solver(robot, primary + "+qp", criteria=JointCentering(1.0, np.full(6, 1.5)))
    for _ in range(10):
        q = robot.random_configuration(rng)
        q[rng.integers(6)] = 0.6
        problem = ik.build(q, robot.position(q))
        solution = qpsolvers.solve_problem(problem, solver="daqp")
        assert solution.is_optimal(1e-8)
        assert (q + solution.x <= 0.6 + 1e-12).all()
        assert ik.step(q, robot.position(q)).q.max() <= 0.6
        ik.reset()


@pytest.mark.quick(1)
@pytest.mark.parametrize("primary", ["newton", "hybrid", "damped"])
def test_the_optimum_is_that_of_the_active_set(primary, rng):
    """Both are first-order optimal at the same place, with limits that hold."""
    robot = planar(8, lower=-0.5, upper=0.5)
    criteria = JointCentering(1.0, 1.5 * np.array([1.0, -1, 1, -1, 1, -1, 1, -1]))
    working, program = (solver(robot, primary + suffix, criteria=criteria) for suffix in ("", "+qp"))
    active, settled = 0, 0
    for _ in range(8):
        q0, p = rng.uniform(-0.4, 0.4, (2, 8))
        options = {"q0": q0, "max_iterations": 3000}
        first, second = working.solve(robot.position(p), **options), program.solve(robot.position(p), **options)
        if first.status is second.status is jtik.Status.CONVERGED:
            settled += 1
            active += len(second.active_limits)
            assert second.cost == pytest.approx(first.cost, abs=1e-6)
    assert settled >= 6
    assert active >= 4


def test_names_and_objects_pair_freely():
    assert jtik.secondaries["qp"] is QPSecondary
    assert jtik.secondaries["gradient"] is ProjectedGradient
    ik = solver(planar(3), Hybrid(secondary=QPSecondary(step_limit=0.1)))
    assert ik.solve([1.5, 1.5], q0=[0.3, 0.4, 0.5]).position_error <= 1e-6
    with pytest.raises(jtik.UnknownNameError, match="secondary term"):
        solver(planar(3), "newton+pq")
    with pytest.raises(jtik.UnknownNameError, match="strategy"):
        solver(planar(3), "newtn+qp")


@pytest.mark.parametrize("weight", [0.0, -1.0, np.nan, [1.0, 0.0], [[1.0]]])
def test_weights_are_positive(weight):
    with pytest.raises(jtik.ArgumentError, match="weight"):
        QPSecondary(weight=weight)


def test_weights_fit_the_robot():
    with pytest.raises(jtik.ArgumentError, match="weight"):
        solver(planar(3), Transpose(secondary=QPSecondary(weight=(1.0, 2.0))))


def test_the_rules_of_the_paper_know_no_limits():
    with pytest.raises(jtik.ArgumentError, match="rule"):
        QPSecondary(rule="paper")


@pytest.mark.slow
def test_a_step_that_is_short_because_it_ends_at_a_limit_is_not_stationary():
    """The last task step moves a joint 1e-6 off its limit; the solve goes on until it is back."""
    robot = jtik.Robot.builtin("panda")
    ik = shared_solver(robot, jtik.FrameTask("tip", "pose"), criteria=Manipulability(kind="pose"), strategy="hybrid+qp")
    q0 = robot.random_configuration(2)
    solution = ik.solve(robot.pose(q0), q0=q0, until="stationary")
    assert solution.active_limits == ("panda_joint2",)
    assert solution.status is jtik.Status.CONVERGED

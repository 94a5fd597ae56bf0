"""The null-space term -beta (I - J+ J) dH and its three rules for beta."""

from __future__ import annotations

import functools
import math

import casadi
import numpy as np
import pytest

import jtik
from jtik.strategy import Shape
from jtik_formulations import Hybrid, JointCentering, Newton, ObstacleAvoidance, ProjectedGradient, Transpose

from ..conftest import ACCEPTED_RISE, planar, planar_jacobian, planar_points, shared_solver, slow
from ..strategy.conftest import numbers, quadratic_model

PRIMARIES = {"transpose": Transpose, "newton": Newton, "hybrid": Hybrid}
FIELD = [jtik.Circle((4.0, 2.5), 0.5), jtik.Circle((6.5, -1.0), 0.8)]


@functools.cache
def solver(primary, rule, criteria=None, n=10, **options):
    strategy = PRIMARIES[primary](secondary=ProjectedGradient(rule=rule, **options))
    criteria = criteria or JointCentering() + 0.3 * ObstacleAvoidance(FIELD)
    return shared_solver(planar(n), jtik.FrameTask(), criteria=criteria, strategy=strategy)


def run(primary, rule, rng, iterations=150, **options):
    q0 = rng.uniform(-0.6, 0.6, 10)
    target = planar_points(rng.uniform(-0.5, 0.5, 10))[-1]
    return solver(primary, rule, **options).solve(target, q0=q0, max_iterations=iterations, trace=True)


@pytest.mark.quick(2)
@pytest.mark.parametrize("rule", ["sqrt", "paper"])
@pytest.mark.parametrize("primary", PRIMARIES)
def test_V2_does_not_grow(primary, rule, rng):
    """V2 = 1/2 |beta h|^2, over the accepted steps; the floor of the rule "sqrt" is a level it may always return to."""
    for _ in range(5):
        solution = run(primary, rule, rng, floor=1e-12)
        trace = solution.trace  # a joint that is brought back by a turn begins another attempt
        V2 = trace.V2[(trace.accepted == 1) & (trace.attempt == 0)]
        assert len(V2) > 3
        assert V2[0] > 0
        assert (V2[1:] <= V2[:-1] * (1 + 1e-9) + 1e-24).all()


@pytest.mark.parametrize("rule", ["sqrt", "paper"])
def test_beta_is_the_rule_as_derived_or_as_printed(rule, rng):
    """With the root beta is also bounded by the curvature along the last step; few steps meet that bound here."""
    fewer, by_energy, weak = 0, 0, JointCentering(0.2)
    for _ in range(6):
        trace = run("newton", rule, rng, criteria=weak, iterations=12, floor=1e-12, step_limit=100.0).trace
        energy, expected = np.inf, []
        for length, beta, accepted in zip(trace.null_residual, trace.beta, trace.accepted, strict=True):
            if rule == "paper":
                expected.append(energy / length**2 if length**2 > energy else 1.0)
            else:
                expected.append(min(1.0, np.sqrt(energy) / length))
            energy = (beta * length) ** 2 if accepted else energy
        same = np.isclose(trace.beta, expected, rtol=1e-6)
        assert (same | (trace.beta < expected)).all()
        fewer += np.count_nonzero(~same)
        by_energy += np.count_nonzero(same & (np.array(expected) < 1))
    assert fewer <= (0 if rule == "paper" else 6)
    assert by_energy > 5


def curvatures(q, preferred):
    """Curvatures of H = 1/2 |q - preferred|^2 along the self-motions of a planar arm, at an optimum.

    Eigenvalues of the Hessian of H - multipliers' x on the null space of J, with the derivatives of x in closed form.
    """
    n = len(q)
    J = planar_jacobian(q)
    later = np.maximum.outer(np.arange(n), np.arange(n))
    hessians = -J[1][later], J[0][later]  # x = (J_1, -J_0) of joint 0: the end of the arm seen from a joint
    multipliers = np.linalg.pinv(J).T @ (q - preferred)
    W = np.eye(n) - sum(factor * hessian for factor, hessian in zip(multipliers, hessians, strict=True))
    null = np.linalg.svd(J)[2][2:].T
    return np.linalg.eigvalsh(null.T @ W @ null)


@pytest.mark.parametrize("primary", ["newton", "hybrid"])
def test_with_the_root_it_converges_where_the_self_motion_bends_more_than_H(primary):
    """The Hessian of H is the identity; that of H on the solutions exceeds 2, where beta = 1 would go to and fro."""
    seen, rule = 0, functools.partial(solver, primary, criteria=JointCentering(), n=3)
    for k in range(40):
        rng = np.random.default_rng([5, 3, k])
        q0, target = rng.uniform(-np.pi, np.pi, 3), planar_points(rng.uniform(-np.pi, np.pi, 3))[-1]
        best = rule("merit").solve(target, q0=q0, max_iterations=200)
        assert best.status is jtik.Status.CONVERGED
        if curvatures(best.q, np.zeros(3)).max() < 2:
            continue
        seen += 1
        solution = rule("sqrt").solve(target, q0=q0, max_iterations=200)
        assert solution.status is jtik.Status.CONVERGED
        assert solution.cost == pytest.approx(best.cost, abs=1e-6) or curvatures(solution.q, np.zeros(3)).min() > 0
    assert 0.15 < seen / 40 < 0.45  # the derivation says 29 % of 100


def rising(rule, count, primary="hybrid"):
    """Solves in which V rises at an accepted step outside the neighbourhood of the target, and its largest factor."""
    ik, solves, largest = solver(primary, rule), 0, 1.0
    for k in range(count):
        rng = np.random.default_rng([3, k])
        q0, target = rng.uniform(-1, 1, 10), planar_points(rng.uniform(-1, 1, 10))[-1]
        trace = ik.solve(target, q0=q0, max_iterations=150, trace=True).trace
        V = np.append(trace.V, trace.error[-1] ** 2 / 2)
        outside = np.sqrt(2 * trace.V) > 0.02 * np.linalg.norm(planar_jacobian(q0))  # (M1) of merit.md
        same = np.append(np.diff(trace.attempt) == 0, True)
        counted = (trace.accepted == 1) & outside & same
        factor = V[1:][counted] / V[:-1][counted]
        solves += bool((factor > 1 + ACCEPTED_RISE).any())
        largest = max(largest, factor.max(initial=0))
    return solves, largest


@pytest.mark.quick(2)
@pytest.mark.parametrize("rule", ["merit", "sqrt"])
@pytest.mark.parametrize("primary", PRIMARIES)
def test_V_falls_outside_the_neighbourhood_of_the_target(primary, rule):
    assert rising(rule, 20, primary) == (0, 1.0)


def test_V_rises_by_the_rule_as_printed():
    """The exception that merit.md names: the null-space part is added without a test."""
    solves, largest = rising("paper", 20)
    assert solves > 5
    assert largest > 10


@pytest.mark.parametrize("rule", ["paper", "sqrt"])
def test_the_ratio_as_printed_collapses_doubly_exponentially_and_its_root_does_not(rule):
    """|h| = 1 for ever: joint 4 does not move the frame of the task. The ratio squares itself, 0.9^(2^k)."""

    @jtik.criterion
    def downhill(q, robot):
        return q[3]

    secondary = ProjectedGradient(rule=rule, beta_max=0.9, step_limit=10.0)
    strategy = Newton(secondary=secondary, backtracking=False)
    ik = shared_solver(planar(4), jtik.FrameTask("link3"), criteria=downhill, strategy=strategy, joints="all")
    q0 = np.array([0.3, 0.4, 0.5, 0.6])
    trace = ik.solve(planar(4).position(q0, "link3"), q0=q0, max_iterations=10, trace=True).trace
    assert trace.null_residual == pytest.approx(1.0)
    expected = 0.9**2.0 ** np.arange(10) if rule == "paper" else np.full(10, 0.9)
    assert trace.beta == pytest.approx(expected, rel=1e-9)


def test_with_the_root_it_does_not_freeze():
    """The same criterion with both rules: "sqrt" reaches the optimum, "paper" stops before it."""
    residuals, springs = {}, JointCentering(1.0, np.full(10, 0.2))
    for rule in ("sqrt", "paper"):
        rng = np.random.default_rng(5)
        options = {"criteria": springs, "beta_max": 0.3}
        residuals[rule] = [run("newton", rule, rng, iterations=600, **options).null_space_residual for _ in range(5)]
    assert np.median(residuals["sqrt"]) < 1e-5
    assert np.median(residuals["paper"]) > 1e-3


@pytest.mark.quick(1)
@pytest.mark.parametrize("primary", PRIMARIES)
def test_steps_are_no_longer_than_the_limit(primary, rng):
    for rule in ("merit", "sqrt"):
        trace = run(primary, rule, rng, step_limit=0.05).trace
        assert np.sqrt(2 * trace.V2.max()) <= 0.05 * (1 + 1e-9)


TOO_SHORT = 1e-13
"""A displacement [rad] that shows no curvature."""


@pytest.mark.parametrize("timed", [False, True])
def test_a_solve_does_not_keep_a_gain_whose_steps_are_too_short_to_change_it(timed):
    term, gradient = ProjectedGradient(), np.array([0.0, 0.0, 1e-4])
    model = quadratic_model(np.eye(3)[:2], np.zeros(2), gradient=gradient, timed=timed)
    given = {name: casadi.SX(each) for name, each in term.initial_state(Shape(3, 3, 2, True)).items()}
    given |= {"beta": casadi.SX(TOO_SHORT / 1e-4), "last_kind": casadi.SX(2), "last_q": casadi.SX([0, 0, TOO_SHORT])}
    given["last_null_gradient"] = casadi.SX(gradient)
    step = numbers(term.propose(model, given, casadi.SX.zeros(3)).dq)
    assert np.linalg.norm(step) == pytest.approx(TOO_SHORT if timed else 1e-11)


@pytest.mark.parametrize("primary", ["newton", "hybrid"])
def test_a_start_at_the_optimum_of_H_does_not_freeze_the_motion(primary):
    """V2 is zero there; a rule that kept it as its reference would allow no further motion."""
    target = np.array([6.0, 3.0])
    for rule in ("merit", "sqrt"):
        ik = solver(primary, rule, criteria=JointCentering())
        solution = ik.solve(target, q0=np.full(10, 1e-9), max_iterations=400)
        assert solution.status is jtik.Status.CONVERGED


@pytest.mark.parametrize("primary", PRIMARIES)
def test_merit_converges_to_an_optimum(primary, rng):
    for _ in range(5):
        solution = run(primary, "merit", rng, iterations=5000)
        assert solution.position_error <= 1e-6
        if primary != "transpose":
            assert solution.status is jtik.Status.CONVERGED


@pytest.mark.parametrize("primary", ["newton", "hybrid"])
def test_merit_ends_lower_than_where_it_first_arrived(primary, rng):
    for _ in range(5):
        q0 = rng.uniform(-1, 1, 10)
        target = planar_points(rng.uniform(-0.5, 0.5, 10))[-1]
        ik = solver(primary, "merit")
        arrived, settled = (ik.solve(target, q0=q0, until=until) for until in ("reached", "stationary"))
        # an error of 1e-6 is worth that many times the multipliers in H
        assert settled.cost <= arrived.cost + 1e-5


def excess_on_a_circle(strategy, weight):
    """Largest difference of H from the minimum for the same target, over the second of two laps of a controller."""
    arm = jtik.Robot.builtin("panda")
    task, home = jtik.FrameTask(arm.tip, kind="pose"), np.array([0.0, -0.8, 0.0, -2.4, 0.0, 1.6, 0.8])
    centering = weight * JointCentering()
    moving = shared_solver(arm, task, criteria=centering, strategy=strategy, null_space_rate=math.inf)
    settled = shared_solver(arm, task, criteria=weight * JointCentering())
    for ik in (moving, settled):
        ik.parameters["joint_centering.preferred"] = home
    q, worst = home, 0.0
    for k in range(200):
        angle, target = 2 * np.pi * k / 100, arm.pose(home)
        target[:2, 3] += 0.15 * (np.cos(angle) - 1), 0.15 * np.sin(angle)
        step = moving.step(q, target, dt=0.02)
        q = step.q
        assert step.accepted or step.done
        if k >= 100:
            best = settled.solve(target, q0=q, max_iterations=200)
            assert best.status is jtik.Status.CONVERGED
            worst = max(worst, np.sum((q - home) ** 2) / 2 - best.cost / weight)
    return worst


@pytest.mark.quick(1)
@pytest.mark.parametrize("strategy", ["newton", "hybrid", "newton+qp"])
@pytest.mark.parametrize("weight", [1e3, *slow(1e-3, 1.0)])
def test_a_controller_keeps_to_the_optimum_of_a_moving_target_whatever_the_unit_of_H(strategy, weight):
    assert excess_on_a_circle(strategy, weight) <= 1.5e-3  # a step behind


@pytest.mark.parametrize(
    ("options", "argument"),
    [
        ({"rule": "armijo"}, "rule"),
        ({"step_limit": 0.0}, "step_limit"),
        ({"step_limit": np.nan}, "step_limit"),
        ({"beta_max": -1.0}, "beta_max"),
    ],
)
def test_options_out_of_range_are_refused(options, argument):
    with pytest.raises(jtik.ArgumentError) as caught:
        ProjectedGradient(**options)
    assert caught.value.argument == argument

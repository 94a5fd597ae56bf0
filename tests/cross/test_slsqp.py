"""Constrained optima against SciPy's SLSQP: H is equal or smaller, and the Karush-Kuhn-Tucker conditions hold."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import lsq_linear, minimize

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import dh_arm, planar_jacobian, planar_points, shared_solver, slow

SAME = 1e-6
"""Allowed difference in H of two solvers with tolerance 1e-6."""

STATIONARY = 2e-5
"""Norm of the gradient of the Lagrangian: the tolerance 1e-6 relative to a gradient of up to 20."""

DISTANCE = 0.02
"""Clearance above which the obstacle potential is the plain logarithm [m]."""

FIELD = np.array([[4.0, 2.5], [6.5, -1.0]])
RADII = np.array([0.5, 0.8])
GAIN = 0.3


FLOOR = 0.01
"""Distance below which the potential continues as a parabola [m], which SLSQP needs for its infeasible steps."""


def planar_H(q):
    """1/2 |q|^2 - gain sum of ln d, in numpy."""
    distances = np.linalg.norm(planar_points(q)[:, None] - FIELD, axis=2) - RADII
    below = np.maximum(0, 1 - distances / FLOOR)
    return q @ q / 2 + GAIN * (below + below**2 / 2 - np.log(np.maximum(distances, FLOOR))).sum()


def planar_gradient(q):
    gradient = q.copy()
    for j, point in enumerate(planar_points(q)):
        J = np.zeros((2, len(q)))
        J[:, : j + 1] = planar_jacobian(q[: j + 1])
        for center, radius in zip(FIELD, RADII, strict=True):
            x = point - center
            length = np.linalg.norm(x)
            d = length - radius
            derivative = 1 / d if d > FLOOR else (2 - d / FLOOR) / FLOOR
            gradient -= GAIN * J.T @ x / length * derivative
    return gradient


def planar_solver(limit):
    robot = jtik.Robot.planar(10, lower=-limit, upper=limit)
    field = [jtik.Circle(center, radius) for center, radius in zip(FIELD, RADII, strict=True)]
    criteria = JointCentering() + GAIN * ObstacleAvoidance(field)
    return shared_solver(robot, jtik.FrameTask(), criteria=criteria)


def slsqp(H, gradient, error, jacobian, q0, lower, upper):
    bounds = [(a if np.isfinite(a) else None, b if np.isfinite(b) else None) for a, b in zip(lower, upper, strict=True)]
    return minimize(
        H,
        q0,
        jac=gradient,
        bounds=bounds,
        constraints={"type": "eq", "fun": error, "jac": jacobian},
        method="SLSQP",
        options={"maxiter": 200, "ftol": 1e-12},
    )


def kkt_residual(gradient, J, q, lower, upper):
    """Smallest |dH + J' lambda + mu| with mu >= 0 at upper limits, mu <= 0 at lower limits, and zero elsewhere."""
    at_upper, at_lower = np.flatnonzero(q >= upper - 1e-8), np.flatnonzero(q <= lower + 1e-8)
    unit = np.eye(len(q))
    columns = np.hstack([J.T, unit[:, at_upper], -unit[:, at_lower]])
    lowest = np.concatenate([np.full(len(J), -np.inf), np.zeros(len(at_upper) + len(at_lower))])
    fit = lsq_linear(columns, -gradient, bounds=(lowest, np.inf), tol=1e-14)
    return np.linalg.norm(columns @ fit.x + gradient)


def planar_problems(limit, count, seed=0):
    """Starts and targets away from obstacles, within the limits."""
    rng = np.random.default_rng(seed)
    found = 0
    while found < count:
        q0, goal = rng.uniform(-limit, limit, (2, 10)) * 0.6
        if limit < 0.5:  # all joints close to one limit, so that limits are active
            goal = rng.choice([-1, 1]) * rng.uniform(0.5, 1.0, 10) * limit
        clear = [np.linalg.norm(planar_points(q)[:, None] - FIELD, axis=2) - RADII for q in (q0, goal)]
        if min(c.min() for c in clear) > 0.2:
            found += 1
            yield q0, planar_points(goal)[-1]


@pytest.mark.quick(0, slow=1)
@pytest.mark.parametrize("limit", [0.8, *slow(np.inf, 0.25)])
def test_ten_links_with_centering_and_obstacles_are_optimal(limit):
    ik = planar_solver(limit)
    lower, upper = np.full(10, -limit), np.full(10, limit)
    lower_or_same = bound = polishings = 0
    for q0, target in planar_problems(min(limit, 1.0), 20):
        solution = ik.solve(target, q0=q0, max_iterations=3000)
        q = solution.q
        assert solution.position_error <= 1e-6
        assert solution.status is jtik.Status.CONVERGED
        assert solution.cost == pytest.approx(planar_H(q), abs=1e-7)
        assert ((q >= lower) & (q <= upper)).all()
        J, g = planar_jacobian(q), planar_gradient(q)
        assert kkt_residual(g, J, q, lower, upper) <= STATIONARY
        bound += bool(solution.active_limits)

        def error(q, t=target):
            return planar_points(q)[-1] - t

        # an independent solver finds no better solution nearby
        polished = slsqp(planar_H, planar_gradient, error, planar_jacobian, q, lower, upper)
        if np.linalg.norm(error(polished.x)) < 1e-6 and np.linalg.norm(polished.x - q) < 0.1:
            polishings += 1
            assert planar_H(q) <= polished.fun + SAME + 1e-6 * np.linalg.norm(np.linalg.pinv(J).T @ g)
        # usually also none from the same start; H has many minima, and each solver finds one
        other = slsqp(planar_H, planar_gradient, error, planar_jacobian, q0, lower, upper)
        found = other.success and np.linalg.norm(error(other.x)) < 1e-6
        lower_or_same += not found or planar_H(q) <= other.fun + SAME
    assert polishings >= 16
    assert lower_or_same >= 16
    if limit < 0.5:
        assert bound >= 10  # limits are active in many solutions


def test_jtik_and_slsqp_agree_on_a_convex_problem():
    """With joint centering alone and a nearby target, both solvers find the same q."""
    for limit in (np.inf, 0.3):
        robot = jtik.Robot.planar(10, lower=-limit, upper=limit)
        ik = shared_solver(robot, jtik.FrameTask(), criteria=JointCentering())
        lower, upper = np.full(10, -limit), np.full(10, limit)
        rng = np.random.default_rng(1)
        for _ in range(10):
            q0 = rng.uniform(0.0, 0.3, 10)
            target = planar_points(rng.uniform(0.0, 0.3, 10))[-1]
            solution = ik.solve(target, q0=q0, max_iterations=3000, optimality_tolerance=1e-8)
            other = slsqp(
                lambda q: q @ q / 2,
                lambda q: q,
                lambda q, t=target: planar_points(q)[-1] - t,
                planar_jacobian,
                q0,
                lower,
                upper,
            )
            assert other.success
            assert solution.status is jtik.Status.CONVERGED
            assert solution.q == pytest.approx(other.x, abs=1e-5)
            assert solution.cost == pytest.approx(other.fun, abs=SAME)


@pytest.mark.quick(1, slow=2)
@pytest.mark.parametrize("kind", ["position", "pose"])
@pytest.mark.parametrize("limit", [1.2, *slow(np.inf)])
def test_a_spatial_arm_is_optimal(kind, limit):
    robot = dh_arm(8, 3, limit)
    sphere = jtik.Sphere((0.6, 0.6, 0.4), 0.1)
    ik = shared_solver(robot, jtik.FrameTask("tip", kind), criteria=JointCentering() + GAIN * ObstacleAvoidance(sphere))
    # SLSQP evaluates its functions at configurations outside the limits
    free = shared_solver(
        robot,
        jtik.FrameTask("tip", kind),
        criteria=JointCentering() + GAIN * ObstacleAvoidance(sphere),
        limits=False,
    )
    rng = np.random.default_rng(4)
    lower_or_same = 0
    for _ in range(8):
        q0 = rng.uniform(-0.8, 0.8, 8)
        target = robot.pose(q0 + rng.uniform(-0.2, 0.2, 8))
        solution = ik.solve(target, q0=q0, max_iterations=3000)
        assert solution.converged
        points = np.array([robot.position(solution.q, frame) for frame in robot.moving_frames])
        distances = np.linalg.norm(points - sphere.center, axis=1) - sphere.radius
        assert distances.min() > DISTANCE
        H = solution.q @ solution.q / 2 - GAIN * np.log(distances).sum()
        assert solution.cost == pytest.approx(H, abs=1e-9)
        assert kkt_residual(solution.gradient, solution.jacobian, solution.q, robot.lower, robot.upper) <= STATIONARY

        def evaluated(q, t=target):
            return free.solve(t, q0=q, max_iterations=0)

        other = slsqp(
            lambda q: evaluated(q).cost,
            lambda q: evaluated(q).gradient,
            lambda q: evaluated(q).error,
            lambda q: evaluated(q).jacobian,
            q0,
            robot.lower,
            robot.upper,
        )
        found = other.success and np.linalg.norm(evaluated(other.x).error) < 1e-6
        lower_or_same += not found or solution.cost <= other.fun + SAME
    assert lower_or_same >= 7

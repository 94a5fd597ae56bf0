"""Where clearances forbid the task step, the arm moves along them: by oracles of its own, on planar arms.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
import qpsolvers
from scipy.optimize import nnls

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ...conftest import planar, planar_jacobian, planar_points, shared_solver, slow

pytestmark = pytest.mark.thinned

SAFE, MARGIN = 0.05, 0.01
PRIMARIES = ["hybrid+qp", "damped+qp", *slow("newton+qp", "transpose+qp")]


def closest(q, center):
    """The point of each link that is closest to a point, and the link before it."""
    points = np.vstack([[0.0, 0.0], planar_points(q)])
    along = np.diff(points, axis=0)
    share = np.clip(((center - points[:-1]) * along).sum(1) / (along**2).sum(1), 0, 1)
    return points[:-1] + share[:, None] * along, points


def rows(q, center, radius):
    """Distance of each link to a circle, and its Jacobian."""
    near, points = closest(q, center)
    away = near - center
    length = np.linalg.norm(away, axis=1)
    J = np.zeros((len(q), len(q)))
    for i in range(len(q)):
        for j in range(i + 1):
            arm = near[i] - points[j]
            J[i, j] = (away[i] / length[i]) @ [-arm[1], arm[0]]
    return length - radius, J


def remaining_slope(q, target, center, radius):
    """Norm of -dV/dq projected on the motions that keep the distances, relative to |dV/dq|."""
    distance, J = rows(q, center, radius)
    gradient = planar_jacobian(q).T @ (planar_points(q)[-1] - target)
    active = J[distance < SAFE + MARGIN + 2e-3]
    rest = nnls(active.T, gradient)[1] if len(active) else np.linalg.norm(gradient)
    return rest / np.linalg.norm(gradient)


def scenes(count, n, seed):
    """(q, target, centre, radius): start and a posture on target are clear, the straight way between them is not."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        q, p = rng.uniform(-1.5, 1.5, (2, n))
        q[0] = rng.uniform(-3, 3)
        p[0] = q[0] + rng.uniform(-1.5, 1.5)
        angle, radius = rng.uniform(-np.pi, np.pi), rng.uniform(0.2, 0.6)
        center = rng.uniform(0.8, 0.85 * n) * np.array([math.cos(angle), math.sin(angle)])
        way = [rows(q + share * (p - q), center, radius)[0].min() for share in np.linspace(0, 1, 9)]
        if min(way[0], way[-1]) > SAFE + 0.03 and min(way) < SAFE:
            found.append((q, planar_points(p)[-1], center, radius))
    return found


@functools.cache
def solver(strategy, n, criterion=False):
    clearance = jtik.Clearance(ObstacleAvoidance(jtik.Circle((50.0, 0.0), 0.3), bodies="links"), safe=SAFE)
    criteria = JointCentering() if criterion else None
    return shared_solver(planar(n), jtik.FrameTask(), criteria=criteria, strategy=strategy, clearances=clearance)


def with_circle(ik, center, radius):
    ik.parameters["clearance.centers"], ik.parameters["clearance.radii"] = [center], [radius]
    return ik


@pytest.mark.quick(1)
@pytest.mark.parametrize("strategy", PRIMARIES)
def test_a_solve_ends_on_target_or_where_no_motion_along_the_obstacle_helps(strategy):
    reached, ended = 0, 0
    for q, target, center, radius in scenes(40, 4, 0):
        solution = with_circle(solver(strategy, 4), center, radius).solve(target, q0=q, max_iterations=300)
        assert rows(solution.q, center, radius)[0].min() >= SAFE - 1e-9
        reached += solution.position_error <= 1e-6
        if solution.status is jtik.Status.BLOCKED:
            ended += 1
            assert remaining_slope(solution.q, target, center, radius) < 0.02
            assert solution.active_clearances
    assert reached >= 10
    assert ended >= 2


def blocked(seed, n=5):
    """A posture whose last link touches the circle in front of it, and a target behind the circle."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-0.8, 0.8, n)
    points = planar_points(q)
    along = points[-1] - points[-2]
    aside = np.array([-along[1], along[0]])
    center = points[-1] + (0.3 + SAFE + MARGIN) * aside - 0.3 * along
    return q, points[-1] + 0.5 * aside + 0.4 * along, center


@pytest.mark.parametrize("seed", range(4))
def test_the_step_is_the_minimum_of_the_model_within_rows_and_limits(seed):
    """By another solver's optimality conditions, and the rows in closed form."""
    q, target, center = blocked(seed)
    ik = with_circle(solver("damped+qp", 5), center, 0.3)
    problem = ik.build(q, target, qp="task step")
    solution = qpsolvers.solve_problem(problem, solver="daqp", primal_tol=1e-10)
    assert solution.is_optimal(1e-7)
    distance, J = rows(q, center, 0.3)
    active = distance < 0.3
    step = ik.step(q, target)
    dq = step.q - q
    assert (J[active] @ dq >= -0.5 * np.maximum(distance[active] - SAFE - MARGIN, 0) - 1e-6).all()


@pytest.mark.parametrize("strategy", PRIMARIES)
@pytest.mark.parametrize("seed", range(4))
def test_the_error_falls_to_first_order_along_the_obstacle(strategy, seed):
    """The proposed step leads into the circle, what is taken leads along it, and V falls."""
    q, target, center = blocked(seed)
    ik = with_circle(solver(strategy, 5), center, 0.3)
    ik.reset()
    for _ in range(20):
        step = ik.step(q, target)
        if step.accepted:
            break
    dq = step.q - q
    assert np.linalg.norm(dq) > 1e-4
    assert (planar_points(q)[-1] - target) @ planar_jacobian(q) @ dq < 0


@pytest.mark.parametrize("strategy", ["hybrid+qp", "lexicographic_qp"])
def test_the_null_space_part_does_not_move_the_end_effector(strategy):
    """Beside a circle and far from it, to the solver's accuracy."""
    moved = 0
    for seed in range(6):
        q, target, center = blocked(seed)
        for place in (center, np.array([50.0, 0.0])):
            ik = with_circle(solver(strategy, 5, criterion=True), place, 0.3)
            part = qpsolvers.solve_problem(ik.build(q, target, qp="null-space step"), solver="daqp").x
            assert np.linalg.norm(planar_jacobian(q) @ part) <= 1e-9 * (1 + np.linalg.norm(part))
            moved += np.linalg.norm(part) > 1e-3
    assert moved >= 6


@pytest.mark.parametrize("strategy", PRIMARIES)
def test_far_from_obstacles_the_task_step_is_the_one_without_them(strategy):
    plain = shared_solver(planar(4), jtik.FrameTask(), strategy=strategy)
    ik = with_circle(solver(strategy, 4), (50.0, 0.0), 0.3)
    for q, target, *_ in scenes(5, 4, 1):
        plain.reset()
        ik.reset()
        assert ik.step(q, target).q == pytest.approx(plain.step(q, target).q, abs=1e-12)

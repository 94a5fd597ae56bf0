"""The order of convergence of the second-order step against how smooth the criterion is at its optimum.

Springs to a posture that is on target, and a function of one joint added whose derivative is zero there: the posture is
the optimum, whatever that function's second derivative.
"""

from __future__ import annotations

import functools

import casadi
import numpy as np
import pytest

import jtik
from jtik_formulations import ObstacleAvoidance

from ..conftest import planar, planar_points, report_at, shared_solver

REST = np.array([0.3, 0.5, -0.2, 0.4])
TIGHT = {"position_tolerance": 1e-12, "optimality_tolerance": 1e-12}

PIECES = {
    "smooth": lambda x: 3 * x**4,
    "hessian lipschitz": lambda x: 3 * casadi.fabs(x) ** 3,
    "hessian hoelder 1/2": lambda x: 3 * casadi.fabs(x) ** 2.5,
    "hessian jumps": lambda x: casadi.if_else(x > 0, 4 * x**2 + 3 * x**3, 0.5 * x**2 - x**3),
    "hessian oscillates": lambda x: x**2 * (5 + casadi.sin(casadi.log(x**2 + 1e-200))),
    "hessian unbounded": lambda x: 2 * casadi.fabs(x) ** 1.5,
}


@functools.cache
def solver(piece):
    @jtik.criterion
    def springs(q, robot):
        return 0.5 * casadi.sumsqr(q - REST) + PIECES[piece](q[1] - REST[1])

    return shared_solver(planar(4), jtik.FrameTask(), criteria=springs, strategy="hybrid+second_order")


def distances(piece, rng, **options):
    """Distance to the optimum at every iterate."""
    options = {"max_iterations": 100, **TIGHT, **options}
    q0 = REST + rng.uniform(-0.3, 0.3, 4)
    trace = solver(piece).solve(planar_points(REST)[-1], q0=q0, trace=True, **options).trace
    return np.linalg.norm(trace.q - REST, axis=1)


def steps(e, below=3e-2, above=1e-12):
    """The errors before and after each step in the range where the order shows."""
    close = (e[:-1] < below) & (e[:-1] > above)
    return e[:-1][close], e[1:][close]


@pytest.mark.quick(1)
@pytest.mark.parametrize("piece", ["smooth", "hessian lipschitz", "hessian jumps"])
def test_it_is_quadratic_with_a_lipschitz_hessian_and_with_one_that_jumps_between_two(piece, rng):
    """Each side of the jump has its own quadratic model, and both have the same optimum."""
    for _ in range(6):
        before, after = steps(distances(piece, rng))
        assert len(before) >= 2
        assert (after <= 30 * before**2 + 1e-13).all()


def test_a_hessian_of_hoelder_exponent_one_half_leaves_the_order_three_halves(rng):
    orders, worst = [], []
    for _ in range(6):
        before, after = steps(distances("hessian hoelder 1/2", rng))
        assert (after <= 10 * before**1.5 + 1e-13).all()
        exact = after > 1e-11
        orders.extend(np.log(after[exact]) / np.log(before[exact]))
        worst.append((after / before**2).max())
    assert np.median(orders) < 1.8
    assert max(worst) > 300  # no constant bounds it


def test_a_hessian_without_a_limit_on_either_side_leaves_it_linear(rng):
    for _ in range(4):
        before, after = steps(distances("hessian oscillates", rng))
        assert len(before) > 15
        assert np.median(after / before) > 0.1


def test_an_unbounded_hessian_costs_even_that(rng):
    for _ in range(4):
        e = distances("hessian unbounded", rng)
        assert e[-1] > 1e-6  # after a hundred steps


def test_the_distance_of_a_link_keeps_it_where_the_closest_point_is_at_the_end_of_the_link(rng):
    """An obstacle beside the end of the second link, and springs for which the posture is the optimum there."""
    robot, end, direction = planar(4), planar_points(REST)[1], REST[:2].sum()
    across = np.array([-np.sin(direction), np.cos(direction)])
    field = ObstacleAvoidance(jtik.Circle(end + 0.8 * across, 0.2), bodies="links")
    target = planar_points(REST)[-1]
    of_field = shared_solver(robot, jtik.FrameTask(), criteria=field)
    pull = report_at(of_field, REST, target).gradient

    @jtik.criterion
    def springs(q, robot):
        return 2.0 * casadi.sumsqr(q - REST) - casadi.dot(pull, q - REST)

    curvatures = []
    for side in (-1e-7, 1e-7):
        q = REST + side * np.eye(4)[1]
        ahead, behind = (report_at(of_field, q + d * np.eye(4)[1], target).gradient for d in (1e-8, -1e-8))
        curvatures.append(((ahead - behind) / 2e-8)[1])
    assert abs(curvatures[0] - curvatures[1]) > 0.05
    ik = shared_solver(robot, jtik.FrameTask(), criteria=field + springs, strategy="hybrid+second_order")
    for _ in range(6):
        solution = ik.solve(target, q0=REST + rng.uniform(-0.2, 0.2, 4), trace=True, **TIGHT)
        assert solution.q == pytest.approx(REST, abs=1e-9)
        before, after = steps(np.linalg.norm(solution.trace.q - REST, axis=1))
        assert len(before) >= 2
        assert (after <= 30 * before**2 + 1e-12).all()

"""Order of convergence of several levels: quadratic where their rows are independent together, and where that is lost.

The target of each level is the posture of a goal, so that every level can reach its own.
"""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering

from ..conftest import planar, planar_jacobian, planar_points, shared_solver

TIGHT = {"position_tolerance": 1e-13, "optimality_tolerance": 1e-12}

BENT = np.array([0.3, 0.6, -0.5, 0.9, 0.4, -0.3])
STRAIGHT = np.array([0.4, 0.0, 0.0, 0.9, 0.7, 0.5])
"""The first three links are in line: the elbow is as far from the base as it can be, and its level loses a rank."""

SOLVER = 2e-8
"""Accuracy of a quadratic program where a limit is in the way [m]."""

ELBOW = 2
"""The elbow is the end of this link, from 0."""


def rows(q, end=ELBOW):
    """Derivatives of the end effector and of the end of a link, (4, n), in closed form."""
    lower = np.zeros((2, len(q)))
    lower[:, : end + 1] = planar_jacobian(q[: end + 1])
    return np.vstack([planar_jacobian(q), lower])


def errors(goal, q0, *, end=ELBOW, robot=None, criteria=None):
    """Norm of the errors of both levels together at every iterate, and the solution."""
    tasks = [jtik.FrameTask("tip"), jtik.FrameTask(f"link{end + 2}", name="elbow", priority=1)]
    robot = robot or planar(len(goal))
    ik = shared_solver(robot, tasks, criteria=criteria, strategy="lexicographic_qp")
    there = planar_points(goal)
    target = {"tip": there[-1], "elbow": there[end]}
    solution = ik.solve(target, q0=q0, trace=True, max_iterations=100, **TIGHT)
    missed = [planar_points(q)[[-1, end]] - there[[-1, end]] for q in solution.trace.q]
    return np.linalg.norm(missed, axis=(1, 2)), solution


def squares(e, factor=50.0):
    """Whether each error below 0.1 is at most a factor times the square of the one before, to rounding."""
    before, after = e[:-1], e[1:]
    close = (before < 0.1) & (before > 1e-12)
    return close.sum() >= 2 and bool((after[close] <= factor * before[close] ** 2 + 1e-13).all())


def test_independent_rows_converge_quadratically(rng):
    assert np.linalg.matrix_rank(rows(BENT)) == 4
    for _ in range(8):
        e, solution = errors(BENT, BENT + rng.uniform(-0.3, 0.3, 6))
        assert solution.status is jtik.Status.CONVERGED
        assert squares(e)


def test_a_rank_that_is_lost_at_the_target_makes_it_linear(rng):
    """Each step halves the angles by which the elbow is off its greatest distance, and so quarters the error."""
    assert np.linalg.matrix_rank(rows(STRAIGHT), tol=1e-9) == 3
    assert np.linalg.matrix_rank(rows(STRAIGHT + 0.01 * np.arange(6))) == 4
    for _ in range(8):
        e, solution = errors(STRAIGHT, STRAIGHT + rng.uniform(-0.3, 0.3, 6))
        assert solution.status is jtik.Status.CONVERGED
        assert not squares(e)
        ratios = (e[1:] / e[:-1])[(e[:-1] < 1e-4) & (e[:-1] > 1e-11)]
        assert len(ratios) > 5
        assert ratios == pytest.approx(0.25, abs=0.02)


def test_rows_that_depend_on_each_other_everywhere_cost_nothing(rng):
    """The ends of the last two links: three independent rows at every pose, and two targets that agree."""
    ranks = {np.linalg.matrix_rank(rows(BENT + rng.uniform(-0.3, 0.3, 6), 4), tol=1e-9) for _ in range(5)}
    assert ranks == {3}
    for _ in range(8):
        e, solution = errors(BENT, BENT + rng.uniform(-0.3, 0.3, 6), end=4)
        assert solution.status is jtik.Status.CONVERGED
        assert squares(e)


@pytest.mark.thinned
@pytest.mark.parametrize("links", [4, 6])
@pytest.mark.parametrize("joint", range(4))
def test_so_they_do_where_a_joint_is_at_its_limit(links, joint, rng):
    """With no joint to spare, too: the posture is at the limit, the step there is shorter by the square of the error.

    Below 2e-8 the accuracy of the solver of the quadratic programs decides.
    """
    goal, lower, upper, end = BENT[:links], np.full(links, -2.0), np.full(links, 2.0), links // 2 - 1
    assert np.linalg.matrix_rank(rows(goal, end)) == 4
    upper[joint] = goal[joint]
    robot = jtik.Robot.planar(links, lower=lower, upper=upper)
    for _ in range(6):
        e, _ = errors(goal, np.clip(goal + rng.uniform(-0.2, 0.2, links), lower, upper), end=end, robot=robot)
        until = int(np.argmax(e < SOLVER)) + 1
        assert e[until - 1] < SOLVER
        assert squares(e[:until])


def test_the_criterion_below_the_levels_does_not_slow_them(rng):
    for goal, quadratic in ((BENT, True), (STRAIGHT, False)):
        for _ in range(4):
            e, _ = errors(goal, goal + rng.uniform(-0.3, 0.3, 6), criteria=JointCentering())
            reached = e[: int(np.argmax(e < 1e-11)) + 1]
            assert reached[-1] < 1e-11
            assert (len(reached) <= 12) == quadratic

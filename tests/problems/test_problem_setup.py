"""The problem setup: targets, solves and derivatives for the generators."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.problems.problem_setup import ProblemSetup, draw_set
from jtik.problems.start_sampler import StartSampler

from ..conftest import DIFFERENCES, planar, planar_jacobian, planar_points

Q = np.array([0.3, 0.5, -0.9])


def test_the_jacobian_and_its_rate_are_those_of_a_planar_arm():
    setup = ProblemSetup(planar(3), jtik.FrameTask())
    u, h = np.array([0.6, -0.8]), 1e-5
    np.testing.assert_allclose(setup.jacobian(Q), planar_jacobian(Q), atol=1e-12)
    columns = [(planar_jacobian(Q + h * e).T @ u - planar_jacobian(Q - h * e).T @ u) / (2 * h) for e in np.eye(3)]
    np.testing.assert_allclose(setup.jacobian_rate(Q, u), np.column_stack(columns), atol=DIFFERENCES)


def test_a_solution_meets_the_target_within_the_limits_or_is_none():
    setup = ProblemSetup(planar(4, lower=-2.0, upper=2.0), jtik.FrameTask())
    q = setup.solve([2.0, 1.5], np.full(4, 0.3))
    np.testing.assert_allclose(planar_points(q)[-1], [2.0, 1.5], atol=1e-6)
    assert (abs(q) <= 2.0).all()
    assert setup.solve([9.0, 0.0], np.full(4, 0.3), max_iterations=50) is None


def test_joints_are_clamped_to_their_limits():
    setup = ProblemSetup(planar(4, lower=-2.0, upper=2.0), jtik.FrameTask())
    assert setup.clamped(np.array([3.0, -5.0, 0.1, 2.0])).tolist() == [2.0, -2.0, 0.1, 2.0]


def test_the_target_at_a_configuration_is_its_position():
    setup = ProblemSetup(planar(3), jtik.FrameTask())
    np.testing.assert_allclose(setup.target_at(Q), planar_points(Q)[-1], atol=1e-12)


def test_starts_are_given_or_drawn_within_the_limits():
    setup = ProblemSetup(planar(4, lower=-2.0, upper=2.0), jtik.FrameTask())
    generator = np.random.default_rng(0)
    drawn = [StartSampler(setup, None).draw(generator) for _ in range(20)]
    assert np.ptp(drawn, axis=0).min() > 0.5
    assert np.abs(drawn).max() <= 2.0
    given = StartSampler(setup, [0.1, 0.2, 0.3, 0.4])
    start = given.draw(generator)
    start[0] = 9
    assert given.draw(generator).tolist() == [0.1, 0.2, 0.3, 0.4]
    with pytest.raises(jtik.ArgumentError, match="q0"):
        StartSampler(setup, [0.1])


@pytest.mark.parametrize(
    ("count", "seed", "accepted"),
    [(0, 0, "a positive integer"), (1, -1, "a non-negative integer"), (True, 0, "positive")],
)
def test_invalid_counts_and_seeds_are_refused(count, seed, accepted):
    with pytest.raises(jtik.ArgumentError, match=accepted):
        draw_set("kind", count, seed, lambda name, generator: None, "origin")

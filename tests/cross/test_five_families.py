"""A small version of the five-family study: ten unit links, tolerance 1e-6, the hybrid, transpose and newton.

The full study has 200 problems of each family. The medians of its dogleg row are the reference here.
"""

from __future__ import annotations

import functools

import numpy as np
import pytest

import jtik

from ..conftest import ACCEPTED_RISE, planar, planar_points, rises, shared_solver

PROBLEMS, LINKS, ITERATIONS = 25, 10, 1000

DOGLEG_MEDIAN = {"generic": 5, "far": 6, "near-straight 1e-3": 5, "near-straight 1e-6": 5, "boundary": 29}
"""Median iterations of the reference dogleg in the full study."""

ALLOWANCE = 1.2
"""Factor on the reference medians."""


def problems(family):
    """(q0, target) pairs of a family."""
    rng = np.random.default_rng(sorted(DOGLEG_MEDIAN).index(family))
    for _ in range(PROBLEMS):
        if family == "generic":
            yield rng.uniform(-1, 1, LINKS), planar_points(rng.uniform(-1, 1, LINKS))[-1]
        elif family == "far":
            yield rng.uniform(-1, 1, LINKS), planar_points(rng.uniform(-np.pi, np.pi, LINKS))[-1]
        elif family == "boundary":
            angle = rng.uniform(-np.pi, np.pi)
            yield rng.uniform(-1, 1, LINKS), 9.999 * np.array([np.cos(angle), np.sin(angle)])
        else:
            size = float(family.split()[-1])
            yield size * rng.uniform(-1, 1, LINKS), np.array([rng.uniform(2, 9), 0.0])


@functools.cache
def study(family, strategy):
    ik = shared_solver(planar(LINKS), jtik.FrameTask(), strategy=strategy)
    return [ik.solve(x, q0=q0, max_iterations=ITERATIONS, trace=True) for q0, x in problems(family)]


def median(family, strategy):
    """Median iterations; a failed solve counts with the maximum."""
    return float(np.median([s.iterations if s.converged else ITERATIONS for s in study(family, strategy)]))


@pytest.mark.parametrize("family", DOGLEG_MEDIAN)
def test_the_hybrid_solves_all_problems_and_V_never_rises(family):
    solutions = study(family, "hybrid")
    assert [solution.status for solution in solutions] == [jtik.Status.CONVERGED] * PROBLEMS
    for solution, (_, target) in zip(solutions, problems(family), strict=True):
        assert np.linalg.norm(planar_points(solution.q)[-1] - target) <= 1.0000001e-6
        assert rises(solution.trace).max() <= ACCEPTED_RISE


@pytest.mark.parametrize("family", DOGLEG_MEDIAN)
def test_the_hybrid_needs_no_more_iterations_than_the_reference(family):
    assert median(family, "hybrid") <= ALLOWANCE * DOGLEG_MEDIAN[family]


def test_hybrid_needs_fewest_and_transpose_most_iterations():
    transpose, newton, hybrid = (median("generic", name) for name in ("transpose", "newton", "hybrid"))
    assert transpose > 5 * newton
    assert newton >= hybrid


@pytest.mark.thinned
@pytest.mark.parametrize("strategy", ["transpose", "newton"])
@pytest.mark.parametrize("family", DOGLEG_MEDIAN)
def test_V_never_rises_with_backtracking(family, strategy):
    for solution in study(family, strategy)[:10]:
        assert rises(solution.trace).max() <= ACCEPTED_RISE


def test_newton_solves_all_reachable_families():
    for family in ("generic", "far", "near-straight 1e-3", "near-straight 1e-6"):
        assert all(solution.converged for solution in study(family, "newton"))

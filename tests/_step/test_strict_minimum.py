"""The certificate of a strict minimum against the eigenvalues of the reduced Hessian in closed form.

The arm is planar with unit links. H = g' (q - p) + 1/2 (q - p)' K (q - p) with g in the row space of the Jacobian at p:
p is stationary, and the Hessian of the Lagrangian is known.
"""

from __future__ import annotations

import functools

import numpy as np
import pytest
from scipy.linalg import null_space

import jtik
from jtik._loop.minimum_certificate import MinimumCertificate
from jtik._step import strict_minimum
from jtik._step.inputs import Inputs, Settings
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.criterion import CriterionSum, CriterionTerms
from jtik.symbolic import dot
from jtik.symbolic.generated_c import SELDOM
from jtik.task import TaskStack

from ..conftest import planar, planar_jacobian, planar_points

N = 5
ZEROS, IDENTITY = np.zeros(N), np.eye(N).ravel()

CLEAR = 1e-3
"""A lowest eigenvalue of this size, relative to the Hessian, has to be decided at a regular pose."""


@jtik.criterion
def quadratic(q, robot, *, p=ZEROS, g=ZEROS, K=IDENTITY):
    v = q - p
    return dot(g, v) + dot(v, K.reshape((N, N)) @ v) / 2


@pytest.fixture(autouse=True, params=[12, N - 1], ids=["unrolled", "of numbers"])
def unrolled(request, monkeypatch):
    """Most joints for which the certificate factorises its matrix itself."""
    monkeypatch.setattr(strict_minimum, "UNROLLED", request.param)
    return request.param


@functools.cache
def certificate(limit, unrolled):
    robot = planar(N) if limit is None else planar(N, lower=-limit, upper=limit)
    terms = CriterionTerms.of(robot, CriterionSum.of(quadratic), ())
    bounded = tuple((i, i) for i in range(N)) if limit else ()
    problem = SymbolicProblem(robot, TaskStack.of(robot, jtik.FrameTask()), terms, bounded)
    made = MinimumCertificate(problem, None)
    made.warm_up()
    assert made._symbolic.n_out() == 1 + (unrolled < N)
    return problem, made


def certified(p, g, K, limit=None):
    problem, function = certificate(limit, strict_minimum.UNROLLED)
    memory = problem.terms.parameters
    memory["quadratic.p"], memory["quadratic.g"], memory["quadratic.K"] = p, g, K.ravel()
    bound = np.full(N, limit or np.inf)
    inputs = Inputs(planar_points(p)[-1], memory.memory, -bound, bound, np.array(Settings(), dtype=float))
    return function(p, inputs)


def lagrangian_hessian(p, K, mu):
    """K - mu' times the second derivatives of the end effector, which are minus its arms from the later joint."""
    points = np.vstack([np.zeros(2), planar_points(p)])
    later = np.maximum.outer(np.arange(N), np.arange(N))
    return K + np.einsum("k,ijk->ij", mu, (points[-1] - points[later]))


def case(rng, spread):
    p, mu = rng.uniform(-2, 2, N), rng.normal(size=2)
    K = rng.normal(size=(N, N))
    K = (K + K.T) / 2 + spread * np.eye(N)
    return p, mu, K


@pytest.mark.quick(4)
@pytest.mark.parametrize("spread", [-2.0, 0.0, 1.0, 3.0, 6.0])
def test_it_is_given_for_minima_and_for_nothing_else(spread, rng):
    for _ in range(100):
        p, mu, K = case(rng, spread)
        J, W = planar_jacobian(p), lagrangian_hessian(p, K, mu)
        Z = null_space(J)
        lowest = np.linalg.eigvalsh(Z.T @ W @ Z)[0] / np.linalg.norm(W, 2)
        given = certified(p, J.T @ mu, K)
        if lowest <= 0:
            assert not given
        elif lowest > CLEAR and np.linalg.cond(J) < 20:
            assert given


def test_joints_at_a_limit_count_as_fixed_where_they_are_pushed_outward(rng):
    limit, seen = 2.0, set()
    for _ in range(200):
        p, mu, K = case(rng, 1.0)
        p[0] = limit
        J, W = planar_jacobian(p), lagrangian_hessian(p, K, mu)
        Z = null_space(J[:, 1:])
        lowest = np.linalg.eigvalsh(Z.T @ W[1:, 1:] @ Z)[0] / np.linalg.norm(W, 2)
        for multiplier in (-1.0, 0.0, 1.0):  # its negative gradient pushes outward, not at all, inward
            g = J.T @ mu + multiplier * np.eye(N)[0]
            given = certified(p, g, K, limit)
            if multiplier >= 0 or lowest <= 0:
                assert not given
            elif lowest > CLEAR and np.linalg.cond(J[:, 1:]) < 20:
                assert given
                seen.add("given")
    assert seen


def test_a_singular_pose_is_left_to_the_other_test(rng):
    K = np.eye(N)
    assert certified(np.full(N, 0.4), np.zeros(N), K)
    assert certified(np.zeros(N), np.zeros(N), K)  # H has its minimum over all motions
    K[1, 1] = -1.0  # and here over those only that do not move the end effector across
    assert not certified(np.zeros(N), np.zeros(N), K)


def test_where_nothing_is_finite_there_is_none():
    assert not certified(np.full(N, 0.4), ZEROS, np.diag(np.full(N, 1e308)) * 1.7)
    problem, function = certificate(None, strict_minimum.UNROLLED)
    inputs = Inputs(np.ones(2), problem.terms.parameters.memory, -np.ones(N), np.ones(N), np.array(Settings()))
    assert not function(np.full(N, np.nan), inputs)


def test_a_large_one_is_not_optimised(monkeypatch):
    problem, made = certificate(None, strict_minimum.UNROLLED)
    assert made._symbolic.name() == "strict_minimum"
    monkeypatch.setattr(strict_minimum, "OPTIMISED", 10)
    assert strict_minimum.strict_minimum(problem).name() == f"{SELDOM}strict_minimum"

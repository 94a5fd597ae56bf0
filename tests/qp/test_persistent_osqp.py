"""OSQP with a persistent workspace."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from jtik.qp import Conic, PersistentOSQP

from .test_backend import random_qp, solution_of


def test_the_workspace_is_updated_with_each_qp(rng):
    solver = PersistentOSQP().solver(6, 4)
    for _ in range(10):
        qp = random_qp(rng)
        assert solver.solve(qp)[0] == pytest.approx(solution_of(Conic("daqp"), qp)[0], abs=1e-6)


def test_it_solves_the_next_qp_after_one_without_solution(rng):
    solver = PersistentOSQP().solver(6, 4)
    qp = random_qp(rng)
    expected = solution_of(Conic("daqp"), qp)[0]
    assert solver.solve(dataclasses.replace(qp, P=-np.eye(6))) is None
    assert solver.solve(qp)[0] == pytest.approx(expected, abs=1e-6)

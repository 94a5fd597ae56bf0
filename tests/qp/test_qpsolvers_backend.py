"""Solvers of qpsolvers as back ends: the conversion of a QP, its multipliers, dense and sparse, and failures."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import qpsolvers

from jtik.qp import BackendError, NumericQP, QPSolversBackend, as_problem
from jtik.qp.backend import DEFAULT_ACCURACY, PLUGINS, trial_qp

QP = NumericQP(
    P=np.diag([1.0, 2.0, 4.0]),
    q=np.array([-3.0, 0.0, 0.0]),
    C=np.array([[1.0, 1, 0], [0, 1, 1], [1, 0, 1], [1, 1, 1]]),
    low=np.array([0.5, -np.inf, -1.0, -np.inf]),
    high=np.array([0.5, 2.0, np.inf, np.inf]),
    lower=np.array([-1.0, -1, -1]),
    upper=np.array([0.25, 1, 1]),
)
"""Its rows: an equality, an upper bound, a lower bound, no bound. By its first row and bound x = (0.25, 0.25, 0)."""


class TestConversion:
    def test_rows_are_divided_into_equalities_and_upper_bounds(self):
        problem, equal, above, below = as_problem(QP)
        assert equal.tolist() == [True, False, False, False]
        assert above.tolist() == [False, True, False, False]
        assert below.tolist() == [False, False, True, False]
        assert (problem.A.tolist(), problem.b.tolist()) == ([[1, 1, 0]], [0.5])
        assert (problem.G.tolist(), problem.h.tolist()) == ([[0, 1, 1], [-1, 0, -1]], [2, 1])

    def test_the_hessian_is_made_symmetric(self):
        P = as_problem(dataclasses.replace(QP, P=QP.P + np.triu(np.ones((3, 3)), 1)))[0].P
        assert P.tolist() == P.T.tolist()
        assert P[0, 1] == 0.5

    def test_a_qp_without_rows_has_no_matrices(self):
        problem = as_problem(dataclasses.replace(QP, C=np.zeros((0, 3)), low=np.zeros(0), high=np.zeros(0)))[0]
        assert (problem.G, problem.A) == (None, None)

    def test_its_memory_is_not_that_of_the_step(self):
        problem = as_problem(QP)[0]
        for mine, theirs in ((problem.q, QP.q), (problem.lb, QP.lower), (problem.ub, QP.upper)):
            assert not np.shares_memory(mine, theirs)


@pytest.mark.parametrize("name", ["daqp", "osqp"])
def test_solution_and_multipliers_have_jtiks_order_and_signs(name):
    """OSQP takes sparse matrices, DAQP dense ones."""
    x, rows, box = QPSolversBackend(name).solver(3, 4).solve(QP)
    assert x == pytest.approx([0.25, 0.25, 0], abs=1e-6)
    # stationarity of x2: 2 x2 + y1 = 0; of x1: x1 - 3 + y1 + z1 = 0
    assert rows == pytest.approx([-0.5, 0, 0, 0], abs=1e-5)
    assert box == pytest.approx([3.25, 0, 0], abs=1e-5)


@pytest.mark.parametrize("name", ["daqp", "osqp"])
@pytest.mark.parametrize(("side", "low", "high"), [(1, 1.0, np.inf), (-1, -np.inf, -1.0)])
def test_multipliers_of_bounds_on_either_side(name, side, low, high):
    """The point closest to 0 with x1 + x2 at least 1, or at most -1, is (1/2, 1/2) or its negative."""
    infinite = np.full(2, np.inf)
    qp = NumericQP(np.eye(2), np.zeros(2), np.ones((1, 2)), np.array([low]), np.array([high]), -infinite, infinite)
    x, rows, box = QPSolversBackend(name).solver(2, 1).solve(qp)
    assert x == pytest.approx([side / 2] * 2, abs=1e-6)
    assert rows == pytest.approx([-side / 2], abs=1e-6)
    assert box.tolist() == [0, 0]


def test_a_qp_without_solution_has_none():
    impossible = dataclasses.replace(QP, lower=np.array([0.3, 0.25, -1]), upper=np.ones(3))
    assert QPSolversBackend("daqp").solver(3, 4).solve(impossible) is None
    assert QPSolversBackend("daqp").solver(3, 4).solve(dataclasses.replace(QP, P=-QP.P)) is None


def test_a_solver_that_raises_has_none(monkeypatch):
    def solve_problem(*arguments, **options):
        raise RuntimeError("of its own")

    solver = QPSolversBackend("daqp").solver(1, 1)
    assert solver.solve(trial_qp())[0] == pytest.approx([-1])
    monkeypatch.setattr(qpsolvers, "solve_problem", solve_problem)
    assert solver.solve(trial_qp()) is None


def test_accuracies():
    assert QPSolversBackend("daqp").accuracy == PLUGINS["daqp"]
    assert QPSolversBackend("daqp", accuracy=1e-4).accuracy == 1e-4
    others = [name for name in qpsolvers.available_solvers if name not in PLUGINS]
    assert all(QPSolversBackend(name).accuracy == DEFAULT_ACCURACY for name in others)


def test_an_option_that_the_solver_refuses_is_named():
    with pytest.raises(BackendError, match="'daqp': refuses the options {'nonsense': 1}"):
        QPSolversBackend("daqp", nonsense=1)

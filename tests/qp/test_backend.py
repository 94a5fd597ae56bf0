"""Back ends: all return the same solutions, report when there is none, and are found by name."""

from __future__ import annotations

import numpy as np
import pytest
import qpsolvers

import jtik
from jtik.qp import (
    BackendError,
    CalledBackend,
    Conic,
    FusedBackend,
    NumericQP,
    PersistentOSQP,
    QPSolver,
    QPSolversBackend,
    available,
    backend_of,
)
from jtik.symbolic.compile import CompiledFunction
from jtik_formulations import JointCentering

from ..conftest import planar

AGREEMENT = {"daqp": 1e-9, "osqp": 1e-6, "piqp": 1e-6, "proxqp": 1e-6, "qpoases": 1e-9, "highs": 1e-5}
"""Largest difference to the active-set method on well-conditioned QPs."""

SILENT = [name for name in available() if name != "qpoases"]  # it prints its licence

BACKENDS = [
    *[backend_of(name) for name in SILENT],
    QPSolversBackend("daqp"),
    QPSolversBackend("osqp"),
    PersistentOSQP(),
]


def solution_of(backend, qp):
    """x, row multipliers, box multipliers; None if the solver finds no solution."""
    n, rows = len(qp.q), len(qp.low)
    if not isinstance(backend, FusedBackend):
        return backend.solver(n, rows).solve(qp)
    data = (qp.P, qp.q, qp.C, qp.low, qp.high, qp.lower, qp.upper)
    return [column[:, 0] for column in CompiledFunction(backend.function(n, rows))(*data)]


def random_qp(rng, n=6, rows=4):
    """A strictly convex QP with an equality, rows with one or two bounds, and a box with infinite bounds."""
    M = rng.standard_normal((n, n))
    inside = rng.uniform(-0.3, 0.3, n)
    C = rng.standard_normal((rows, n))
    low, high = C @ inside - 0.2, C @ inside + 0.2
    low[0] = high[0] = C[0] @ inside
    low[1], high[2] = -np.inf, np.inf
    lower, upper = np.full(n, -0.5), np.full(n, 0.5)
    lower[0], upper[1] = -np.inf, np.inf
    return NumericQP(M @ M.T + np.eye(n), 3 * rng.standard_normal(n), C, low, high, lower, upper)


def kkt(qp, x, rows, box):
    """The largest violation, stationarity residual and complementarity residual."""
    low, high = np.concatenate([qp.low, qp.lower]), np.concatenate([qp.high, qp.upper])
    value, multiplier = np.concatenate([qp.C @ x, x]), np.concatenate([rows, box])
    equal = low == high
    violation = max((low - value).max(), (value - high).max())
    stationarity = np.abs(qp.P @ x + qp.q + qp.C.T @ rows + box).max()
    slack = np.where(multiplier > 0, high - value, value - low)
    active = ~equal & (np.abs(multiplier) > 1e-5)
    return violation, stationarity, np.abs(slack[active]).max(initial=0)


@pytest.mark.parametrize("backend", BACKENDS, ids=repr)
class TestEveryBackEnd:
    def test_satisfies_the_optimality_conditions(self, backend, rng):
        for _ in range(20):
            qp = random_qp(rng)
            assert max(kkt(qp, *solution_of(backend, qp))) <= max(backend.accuracy, 1e-9)

    def test_agrees_with_the_active_set_method(self, backend, rng):
        for _ in range(20):
            qp = random_qp(rng)
            exact = solution_of(Conic("daqp"), qp)[0]
            tolerance = AGREEMENT.get(backend.name, 1e-5)
            assert solution_of(backend, qp)[0] == pytest.approx(exact, abs=tolerance)

    def test_without_rows(self, backend):
        qp = NumericQP(
            np.eye(3), np.array([1.5, -2, 0.1]), np.zeros((0, 3)), *np.zeros((2, 0)), *[s * np.ones(3) for s in (-1, 1)]
        )
        x, rows, box = solution_of(backend, qp)
        assert x == pytest.approx([-1, 1, -0.1], abs=1e-5)
        assert rows.shape == (0,)
        assert box == pytest.approx([-0.5, 1, 0], abs=1e-4)

    def test_contradictory_rows_do_not_raise_and_are_detected(self, backend, rng):
        """Either there is no solution, or the violation of its rows exceeds the accuracy."""
        qp = random_qp(rng)
        qp.C[3], qp.low[3], qp.high[3] = qp.C[0], qp.low[0] + 1, qp.high[0] + 2
        found = solution_of(backend, qp)
        assert found is None or not kkt(qp, *found)[0] <= backend.accuracy

    @pytest.mark.quick(3)
    def test_solves_inverse_kinematics(self, backend):
        ik = jtik.InverseKinematics(
            planar(6), jtik.FrameTask(), criteria=JointCentering(), strategy="newton+qp", solver=backend
        )
        exact = jtik.InverseKinematics(planar(6), jtik.FrameTask(), criteria=JointCentering(), strategy="newton")
        options = {"q0": np.full(6, 0.2), "optimality_tolerance": 1e-4}
        solution = ik.solve([3.0, 2.0], **options)
        assert solution.converged
        assert solution.cost == pytest.approx(exact.solve([3.0, 2.0], **options).cost, abs=1e-6)


def test_options_pass_through(rng):
    qp = random_qp(rng)
    exact = solution_of(Conic("daqp"), qp)[0]
    one_iteration = Conic("osqp", osqp={"verbose": False, "max_iter": 1, "eps_abs": 1e-9, "eps_rel": 1e-9})
    assert np.abs(solution_of(one_iteration, qp)[0] - exact).max() > 1e-3
    assert solution_of(PersistentOSQP(max_iter=1, polishing=False), qp) is None
    assert solution_of(QPSolversBackend("osqp", max_iter=1, polishing=False), qp) is None


class ClippingBackend(CalledBackend):
    """A third-party back end for QPs without rows: clip the minimiser of a diagonal QP to the box."""

    name = "clipping"
    accuracy = 1e-9

    def solver(self, n, rows):
        class Clip(QPSolver):
            def solve(self, qp):
                x = np.clip(-qp.q / np.diag(qp.P), qp.lower, qp.upper)
                return x, np.zeros(0), -(qp.P @ x + qp.q)

        return Clip()


def test_a_third_party_back_end_needs_one_method():
    qp = NumericQP(2 * np.eye(2), np.array([2.0, -6]), np.zeros((0, 2)), *np.zeros((2, 0)), -np.ones(2), np.ones(2))
    for mine, expected in zip(solution_of(ClippingBackend(), qp), solution_of(Conic(), qp), strict=True):
        assert mine == pytest.approx(expected, abs=1e-9)


class TestNames:
    def test_the_default_is_daqp(self):
        assert backend_of(None).name == "daqp"

    def test_available_names_have_back_ends(self):
        assert {"daqp", "osqp"} <= set(available())
        for name in available():
            assert backend_of(name).name == name

    def test_a_solver_that_is_not_installed(self, monkeypatch):
        monkeypatch.setattr(qpsolvers, "available_solvers", ["daqp"])
        with pytest.raises(
            BackendError, match=r"'gurobi': not installed; there are daqp.*pip install 'qpsolvers\[gurobi\]'"
        ):
            backend_of("gurobi")

    def test_excluded_and_unknown_plugins(self):
        with pytest.raises(BackendError, match="box-constrained"):
            backend_of("qrqp")
        with pytest.raises(BackendError, match="no usable plugin"):
            Conic("nothing")

    def test_another_object_is_refused(self):
        with pytest.raises(BackendError, match="Backend"):
            backend_of(3.0)

    def test_a_strategy_without_qps_takes_no_solver(self):
        with pytest.raises(jtik.ArgumentError, match="solver"):
            jtik.InverseKinematics(planar(3), jtik.FrameTask(), solver="osqp")

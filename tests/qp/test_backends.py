"""Back ends: all of them give the same answers, say when they have none, and are found by name."""

from __future__ import annotations

import numpy as np
import pytest
import qpsolvers

import jtik
from jtik.qp import BackendError, Conic, Foreign, FusedBackend, PersistentOSQP, available, backend_of
from jtik.qp.backend import Numbers
from jtik.symbolic.compile import CompiledFunction
from jtik_formulations import JointCentering

from ..conftest import planar

AGREEMENT = {"daqp": 1e-9, "osqp": 1e-6, "piqp": 1e-6, "proxqp": 1e-6, "qpoases": 1e-9, "highs": 1e-5}
"""How near the answers of a well-conditioned program lie to those of the active-set method."""

SILENT = [name for name in available() if name != "qpoases"]  # which prints its licence

BACKENDS = [*[backend_of(name) for name in SILENT], Foreign("daqp"), Foreign("osqp"), PersistentOSQP()]


def answer(backend, program):
    """x, row multipliers, box multipliers; None where there is no answer."""
    n, rows = len(program.q), len(program.low)
    if not isinstance(backend, FusedBackend):
        return backend.solver(n, rows).solve(program)
    data = (program.P, program.q, program.C, program.low, program.high, program.lower, program.upper)
    return [column[:, 0] for column in CompiledFunction(backend.function(n, rows))(*data)]


def random_program(rng, n=6, rows=4):
    """Strictly convex, with an equality, rows bounded on one and on both sides, and a box open at some places."""
    M = rng.standard_normal((n, n))
    inside = rng.uniform(-0.3, 0.3, n)
    C = rng.standard_normal((rows, n))
    low, high = C @ inside - 0.2, C @ inside + 0.2
    low[0] = high[0] = C[0] @ inside
    low[1], high[2] = -np.inf, np.inf
    lower, upper = np.full(n, -0.5), np.full(n, 0.5)
    lower[0], upper[1] = -np.inf, np.inf
    return Numbers(M @ M.T + np.eye(n), 3 * rng.standard_normal(n), C, low, high, lower, upper)


def kkt(program, x, rows, box):
    """Violation, stationarity, complementarity and signs, each the worst."""
    low, high = np.concatenate([program.low, program.lower]), np.concatenate([program.high, program.upper])
    value, multiplier = np.concatenate([program.C @ x, x]), np.concatenate([rows, box])
    equal = low == high
    violation = max((low - value).max(), (value - high).max())
    stationarity = np.abs(program.P @ x + program.q + program.C.T @ rows + box).max()
    slack = np.where(multiplier > 0, high - value, value - low)
    active = ~equal & (np.abs(multiplier) > 1e-5)
    return violation, stationarity, np.abs(slack[active]).max(initial=0)


@pytest.mark.parametrize("backend", BACKENDS, ids=repr)
class TestEveryBackEnd:
    def test_satisfies_the_optimality_conditions(self, backend, rng):
        for _ in range(20):
            program = random_program(rng)
            assert max(kkt(program, *answer(backend, program))) <= max(backend.accuracy, 1e-9)

    def test_agrees_with_the_active_set_method(self, backend, rng):
        for _ in range(20):
            program = random_program(rng)
            exact = answer(Conic("daqp"), program)[0]
            near = AGREEMENT.get(backend.name, 1e-5)
            assert answer(backend, program)[0] == pytest.approx(exact, abs=near)

    def test_without_rows(self, backend):
        program = Numbers(
            np.eye(3), np.array([1.5, -2, 0.1]), np.zeros((0, 3)), *np.zeros((2, 0)), *[s * np.ones(3) for s in (-1, 1)]
        )
        x, rows, box = answer(backend, program)
        assert x == pytest.approx([-1, 1, -0.1], abs=1e-5)
        assert rows.shape == (0,)
        assert box == pytest.approx([-0.5, 1, 0], abs=1e-4)

    def test_contradictions_do_not_raise_and_do_not_pass(self, backend, rng):
        """Either there is no answer, or the engine's own look at it finds the rows broken."""
        program = random_program(rng)
        program.C[3], program.low[3], program.high[3] = program.C[0], program.low[0] + 1, program.high[0] + 2
        found = answer(backend, program)
        assert found is None or not kkt(program, *found)[0] <= backend.accuracy

    def test_drives_a_solve(self, backend):
        ik = jtik.InverseKinematics(
            planar(6), jtik.FrameTask(), criteria=JointCentering(), strategy="newton+qp", solver=backend
        )
        exact = jtik.InverseKinematics(planar(6), jtik.FrameTask(), criteria=JointCentering(), strategy="newton")
        options = {"q0": np.full(6, 0.2), "optimality_tolerance": 1e-4}
        solution = ik.solve([3.0, 2.0], **options)
        assert solution.converged
        assert solution.cost == pytest.approx(exact.solve([3.0, 2.0], **options).cost, abs=1e-6)


def test_a_persistent_workspace_follows_its_programs(rng):
    solver = PersistentOSQP().solver(6, 4)
    for _ in range(10):
        program = random_program(rng)
        assert solver.solve(program)[0] == pytest.approx(answer(Conic("daqp"), program)[0], abs=1e-6)


def test_options_pass_through(rng):
    program = random_program(rng)
    exact = answer(Conic("daqp"), program)[0]
    hasty = Conic("osqp", osqp={"verbose": False, "max_iter": 1, "eps_abs": 1e-9, "eps_rel": 1e-9})
    assert np.abs(answer(hasty, program)[0] - exact).max() > 1e-3
    assert answer(PersistentOSQP(max_iter=1, polishing=False), program) is None
    assert answer(Foreign("osqp", max_iter=1, polishing=False), program) is None


class TestNames:
    def test_the_default_is_daqp(self):
        assert backend_of(None).name == "daqp"

    def test_what_is_available_can_be_had(self):
        assert {"daqp", "osqp"} <= set(available())
        for name in available():
            assert backend_of(name).name == name

    def test_a_solver_that_is_not_installed(self, monkeypatch):
        monkeypatch.setattr(qpsolvers, "available_solvers", ["daqp"])
        with pytest.raises(
            BackendError, match=r"'gurobi': not installed; there are daqp.*pip install 'qpsolvers\[gurobi\]'"
        ):
            backend_of("gurobi")

    def test_a_plugin_that_is_wrong(self):
        with pytest.raises(BackendError, match="box-constrained"):
            backend_of("qrqp")
        with pytest.raises(BackendError, match="plugin"):
            Conic("nothing")

    def test_something_else(self):
        with pytest.raises(BackendError, match="Backend"):
            backend_of(3.0)

    def test_a_strategy_without_programs_takes_no_solver(self):
        with pytest.raises(jtik.ArgumentError, match="solver"):
            jtik.InverseKinematics(planar(3), jtik.FrameTask(), solver="osqp")

"""QPs that are solved before the step: solved where they are needed, zeros elsewhere, with every kind of back end."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.qp import CalledBackend, Conic, Elastic, QPRecorder, QPSolver, QPSolversBackend, QuadraticProgram, Rows
from jtik.qp.preparation import PreparationCall
from jtik.symbolic import c_source
from jtik.symbolic.compile import CompiledFunction, CompilerError, to_c

EXACT = 1e-7
"""DAQP's solution of a QP of three variables."""

A, FLAG = casadi.SX.sym("a", 3), casadi.SX.sym("flag")


def preparation(elastic=None):
    """The point of the box |x| <= 1 and of sum(x) = 0.3 closest to a; its results are x and twice its first entry."""
    recorder, one = QPRecorder(1e-7), casadi.SX.ones(3, 1)
    rows = [Rows.equal("sum", one.T, casadi.SX(0.3), elastic)]
    program = QuadraticProgram(casadi.SX.eye(3), -A, -one, one, rows, name="closest")
    recorder.prepare(FLAG, program, lambda solution: [solution.x, 2 * solution.x[0]])
    return PreparationCall.of(recorder.preparations[0], [A, FLAG])


def bound(call, backend, a, flag):
    results = [np.full(size, 9.0) for size in call.sizes]
    call.bind(backend, [np.array(a, dtype=float), np.array([float(flag)])], results)()
    return results


def expected(a):
    """The projection on the plane, by bisection of its multiplier."""
    low, high = -10.0, 10.0
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if np.clip(a - middle, -1, 1).sum() > 0.3 else (low, middle)
    return np.clip(a - middle, -1, 1)


BACKENDS = [Conic("daqp"), QPSolversBackend("daqp")]


@pytest.mark.parametrize("backend", BACKENDS, ids=repr)
class TestBackEnds:
    def test_where_it_is_needed_the_results_are_those_of_the_solution(self, backend, rng):
        call = preparation()
        assert call.sizes == [3, 1]
        for a in rng.uniform(-2, 2, (5, 3)):
            x, twice = bound(call, backend, a, 1)
            assert x == pytest.approx(expected(a), abs=EXACT)
            assert twice == pytest.approx(2 * x[:1])

    def test_where_it_is_not_needed_they_are_zero(self, backend):
        for result in bound(preparation(), backend, [1.0, 2.0, 3.0], 0):
            assert (result == 0).all()

    def test_elastic_rows_are_relaxed(self, backend):
        """x = a - y, with the slack s = sum(x) - 0.3 = 1 - 3 y and the multiplier y = 0.1 + 0.1 s of the penalty."""
        a, y = np.array([0.5, 0.6, 0.2]), 0.2 / 1.3
        x, _ = bound(preparation(Elastic(0.1)), backend, a, 1)
        assert x == pytest.approx(a - y, abs=EXACT)


class Counting(CalledBackend):
    """A back end that counts its calls and has no solution."""

    name, accuracy = "counting", 1e-7

    def __init__(self):
        self.calls = 0

    def solver(self, n, rows):
        backend = self

        class Solver(QPSolver):
            def solve(self, qp):
                backend.calls += 1

        return Solver()


def test_the_solver_is_called_only_where_the_qp_is_needed():
    backend, call = Counting(), preparation()
    assert (bound(call, backend, [1, 2, 3], 0)[0] == 0).all()
    assert backend.calls == 0
    assert np.isnan(bound(call, backend, [1, 2, 3], 1)[0]).all()
    assert backend.calls == 1


def test_a_fused_back_end_makes_one_function_of_it(rng):
    solve = CompiledFunction(preparation().solver_function(Conic("daqp")))
    a = rng.uniform(-2, 2, 3)
    assert solve(a, 1)[0].ravel() == pytest.approx(expected(a), abs=EXACT)
    assert not solve(a, 0)[0].any()


def test_generated_c_gives_the_same_results(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    try:
        call = preparation().compiled(to_c)
    except CompilerError as error:
        pytest.skip(str(error))
    a = np.array([0.9, -0.4, 0.7])
    assert bound(call, Conic("daqp"), a, 1)[0] == pytest.approx(expected(a), abs=EXACT)


def test_what_is_seldom_needed_is_not_optimised():
    """Whether the QP is needed is evaluated in each step; its data only then."""
    call = preparation()
    assert [c_source(each).count("JTIK_SELDOM static int") for each in call.functions] == [0, 1, 1]
    joined = c_source(call.solver_function(Conic("daqp")))
    assert joined.count("JTIK_SELDOM static int") == 2

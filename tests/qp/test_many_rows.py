"""QPs of many rows: the same solutions as with few, their rows passed as the matrix that a step has."""

from __future__ import annotations

import casadi
import numpy as np
import pytest
from scipy.optimize import LinearConstraint, minimize

from jtik.qp import Conic, Elastic, QPRecorder, QPSolversBackend, QuadraticProgram, Rows, rows
from jtik.qp.staged import staged
from jtik.symbolic import c_source
from jtik.symbolic.compile import bind

N, K = 4, 30
SOLVED = 1e-6


def step(backend, *, elastic=False, more=0):
    """A step that solves min |x - a|^2 / 2 over C x >= low, |x| <= 1; C, and ``more`` times its first row, are rows."""
    a, C, low = casadi.SX.sym("a", N), casadi.SX.sym("C", K, N), casadi.SX.sym("low", K)
    at = [casadi.SX.sym(f"at{i}", *each.shape) for i, each in enumerate((a, C, low))]
    recorder, one = QPRecorder(SOLVED), casadi.SX.ones(N, 1)
    give = Elastic(1e3, 10.0) if elastic else None
    groups = [Rows("own", at[1], at[2], at[2] + np.inf, give)]
    if more:
        groups.append(
            Rows("sum", casadi.repmat(one.T, more, 1), -0.5 * casadi.SX.ones(more, 1), casadi.SX.inf(more, 1))
        )
    qp = QuadraticProgram(casadi.SX.eye(N), -at[0], -one, one, groups, known_convex=True)
    solution = recorder.solve(qp)
    combination = groups[0].combination(solution.multipliers("own"))
    outputs = [solution.x, recorder.solved(), combination, groups[0].product(solution.x)]
    outputs.append(groups[0].sizes(solution.multipliers("own")))
    return staged([a, C, low], [a, C, low], at, recorder, outputs, backend), qp


def call(parts, a, C, low, how):
    found = [np.zeros(N), np.zeros(1), np.zeros(N), np.zeros(K), np.zeros(K)]
    given = [np.array(a), np.ravel(C, order="F"), np.array(low)]
    if how == "joined":
        bind(parts.joined(), given, found)()
    else:
        parts.bind(given, found)()
    return found


def problem(rng, tight):
    C = rng.normal(size=(K, N))
    return (
        rng.uniform(-2, 2, N) if tight else rng.uniform(-0.5, 0.5, N),
        C,
        -rng.uniform(0.2, 1, K) * (1 if tight else 9),
    )


WAYS = [(Conic(), "joined"), (Conic(), "bound"), (QPSolversBackend("daqp"), "called")]


@pytest.mark.parametrize(("backend", "how"), WAYS, ids=lambda each: str(each))
@pytest.mark.parametrize("more", [0, 2])
@pytest.mark.parametrize("tight", [False, True], ids=["no row is active", "rows are active"])
def test_the_solution_is_the_minimum(backend, how, more, tight, rng, monkeypatch):
    monkeypatch.setattr(rows, "LARGEST_UNROLLED", 50)
    parts, qp = step(backend, more=more)
    assert qp.has_many_rows
    for _ in range(10):
        a, C, low = problem(rng, tight)
        x, good, combination, product, sizes = call(parts, a, C, low, how)
        all_rows, bounds = np.vstack([C, np.ones((more, N))]), np.concatenate([low, np.full(more, -0.5)])
        reference = minimize(
            lambda y, a=a: ((y - a) ** 2).sum() / 2,
            np.zeros(N),
            jac=lambda y, a=a: y - a,
            bounds=[(-1, 1)] * N,
            constraints=LinearConstraint(all_rows, bounds),
            method="SLSQP",
            options={"ftol": 1e-14},
        )
        assert good[0] == 1
        assert x == pytest.approx(reference.x, abs=1e-5)
        assert product == pytest.approx(C @ x)
        inside = np.abs(x) < 1 - 1e-6
        if not more:  # stationary: x - a + C' y = 0
            assert (x - a + combination)[inside] == pytest.approx(np.zeros(inside.sum()), abs=SOLVED)
        if not tight:
            assert sizes == pytest.approx(np.zeros(K), abs=SOLVED)


@pytest.mark.parametrize(("backend", "how"), WAYS, ids=lambda each: str(each))
def test_they_are_those_of_few_rows(backend, how, rng, monkeypatch):
    found = []
    for largest in (50, 1000):
        monkeypatch.setattr(rows, "LARGEST_UNROLLED", largest)
        found.append(step(backend, elastic=True)[0])
    for tight in (False, True):
        for _ in range(5):
            given = problem(rng, tight)
            one, other = (call(parts, *given, how) for parts in found)
            for each, same in zip(one, other, strict=True):
                assert each == pytest.approx(same, abs=SOLVED)


def broken(rng, what):
    a, C, low = problem(rng, tight=False)
    if what == "a row":
        C[3, 2] = np.nan
    elif what == "an infinite row":
        C[3, 2] = np.inf
    elif what == "the cost":
        a[1] = np.nan
    elif what == "a bound":
        low[4] = np.nan
    else:
        low[4] = 1e3
    return a, C, low


@pytest.mark.parametrize(("backend", "how"), WAYS, ids=lambda each: str(each))
@pytest.mark.parametrize("what", ["a row", "an infinite row", "the cost", "a bound", "a bound out of reach"])
def test_what_is_not_finite_or_infeasible_is_not_solved(backend, how, what, rng, monkeypatch):
    monkeypatch.setattr(rows, "LARGEST_UNROLLED", 50)
    parts, _ = step(backend)
    for _ in range(5):
        a, C, low = broken(rng, what)
        assert call(parts, a, C, low, how)[1][0] == 0


def test_rows_that_the_step_has_are_not_written_entry_by_entry(monkeypatch):
    lengths = []
    for largest in (50, 1000):
        monkeypatch.setattr(rows, "LARGEST_UNROLLED", largest)
        lengths.append(c_source(step(Conic())[0].joined()).count("\n"))
    assert lengths[0] < 0.7 * lengths[1]

"""Elastic rows: satisfied where possible, relaxed with a penalty elsewhere, and reported."""

from __future__ import annotations

import casadi
import numpy as np
import pytest
from scipy.optimize import linprog, minimize

import jtik
from jtik.qp import (
    Elastic,
    FusedBackend,
    PersistentOSQP,
    QPRecorder,
    QPSolversBackend,
    QuadraticProgram,
    Rows,
    available,
    backend_of,
)
from jtik.qp.call import QPCall
from jtik.qp.staged import staged
from jtik.strategy import Strategy, Update
from jtik.symbolic.compile import bind

from ..conftest import planar, shared_solver

BACKENDS = [
    *[backend_of(name) for name in available() if name != "qpoases"],
    QPSolversBackend("daqp"),
    PersistentOSQP(),
]
AGREEMENT = {"daqp": 1e-8, "osqp": 2e-5, "highs": 2e-5}


def solved(qp, backend=None, joined=None):
    """x, row multipliers, slack of the group "soft", and whether the solution passes the check."""
    backend = backend_of(backend)
    number, cut = casadi.SX.sym("number"), casadi.SX.sym("cut")
    recorder = QPRecorder(backend.accuracy)
    solution = recorder.solve(qp)
    outputs = [solution.x, solution.row_multipliers, solution.slack("soft"), recorder.solved()]
    parts = staged([number], [number], [cut], recorder, outputs, backend)
    results = [np.zeros(output.numel()) for output in outputs]
    joined = isinstance(backend, FusedBackend) if joined is None else joined
    (bind(parts.joined(), [np.zeros(1)], results) if joined else parts.bind([np.zeros(1)], results))()
    return *results[:3], bool(results[3][0])


def random_data(rng, n=5, k=4):
    """P, q, C, lower, upper, lb, ub: rows around 0, some of which conflict strongly with q."""
    M, C = rng.standard_normal((n, n)), rng.standard_normal((k, n))
    low, high = -rng.uniform(0.1, 0.5, k), rng.uniform(0.1, 0.5, k)
    low[0], high[1] = -np.inf, np.inf
    return M @ M.T + np.eye(n), 4 * rng.standard_normal(n), C, low, high, np.full(n, -0.8), np.full(n, 0.8)


def quadratic_program(data, elastic, hard=()):
    P, q, C, low, high, lower, upper = map(casadi.SX, map(np.asarray, data))
    soft = Rows("soft", C, low, high, elastic)
    rows = [Rows("hard", *map(casadi.SX, hard)), soft] if hard else [soft]
    return QuadraticProgram(P, q, lower, upper, rows)


def slsqp(data, penalty, curvature, max_slack=np.inf):
    """The x of smallest cost over x and slacks, by SciPy."""
    P, q, C, low, high, lower, upper = data
    n, k = len(q), len(C)

    def cost(z):
        x, s = z[:n], z[n:]
        return x @ P @ x / 2 + q @ x + penalty * s.sum() + curvature * (s @ s) / 2

    def gradient(z):
        return np.concatenate([P @ z[:n] + q, penalty + curvature * z[n:]])

    A, B = np.hstack([C, np.eye(k)]), np.hstack([C, -np.eye(k)])
    constraints = [
        {"type": "ineq", "fun": lambda z, r=row, b=b: r @ z - b, "jac": lambda z, r=row: r}
        for row, b in zip([*A, *-B], [*low, *-high], strict=True)
        if np.isfinite(b)
    ]
    box = [*zip(lower, upper, strict=True), *[(0, None if np.isinf(max_slack) else max_slack)] * k]
    found = minimize(
        cost,
        np.zeros(n + k),
        jac=gradient,
        bounds=box,
        constraints=constraints,
        options={"ftol": 1e-14, "maxiter": 500},
    )
    assert found.success or found.status == 8  # 8: no further descent in floating point
    return found.x[:n]


@pytest.mark.slow
def test_equals_the_hard_qp_where_the_penalty_exceeds_its_multipliers(rng):
    for _ in range(8):
        data = random_data(rng)
        x, y, slack, good = solved(quadratic_program(data, Elastic(1e4)))
        P, q, C, low, high, lower, upper = map(casadi.SX, map(np.asarray, data))
        hard = QuadraticProgram(P, q, lower, upper, [Rows("soft", C, low, high)])
        exact, multipliers = hard_answer(hard)
        assert good
        assert np.abs(multipliers).max() < 1e4
        assert x == pytest.approx(exact, abs=1e-8)
        assert y == pytest.approx(multipliers, abs=1e-6)
        assert slack == pytest.approx(np.zeros(4), abs=1e-9)


def hard_answer(qp):
    recorder = QPRecorder(1e-9)
    solution = recorder.solve(qp)
    symbols = casadi.SX.sym("a"), casadi.SX.sym("b")
    outputs = [solution.x, solution.row_multipliers, recorder.solved()]
    results = [np.zeros(output.numel()) for output in outputs]
    parts = staged([symbols[0]], [symbols[0]], [symbols[1]], recorder, outputs, backend_of("daqp"))
    bind(parts.joined(), [np.zeros(1)], results)()
    assert results[2][0]
    return results[:2]


@pytest.mark.quick(1)
@pytest.mark.parametrize("penalty", [0.2, 1.0])
def test_with_a_smaller_penalty_rows_are_relaxed_as_by_scipy(penalty, rng):
    relaxed = 0
    for _ in range(10):
        data = random_data(rng)
        x, y, slack, good = solved(quadratic_program(data, Elastic(penalty, curvature=2.0)))
        assert good
        assert x == pytest.approx(slsqp(data, penalty, 2.0), abs=2e-6)
        used = data[2] @ x
        assert slack == pytest.approx(np.clip(np.maximum(data[3] - used, used - data[4]), 0, None), abs=1e-9)
        relaxed_rows = slack > 1e-7
        assert np.abs(y[relaxed_rows]) == pytest.approx(penalty + 2 * slack[relaxed_rows], abs=1e-6)
        assert (np.abs(y) <= penalty + 2 * slack + 1e-6).all()
        relaxed += relaxed_rows.any()
    assert relaxed >= 5


@pytest.mark.slow
def test_no_slack_exceeds_its_upper_bound(rng):
    relaxed = 0
    for _ in range(10):
        data = random_data(rng)
        x, _, slack, good = solved(quadratic_program(data, Elastic(0.2, curvature=2.0, max_slack=0.1)))
        assert good
        assert slack.max() <= 0.1 + 1e-8
        assert x == pytest.approx(slsqp(data, 0.2, 2.0, 0.1), abs=2e-6)
        relaxed += (slack > 0.1 - 1e-8).any()
    assert relaxed >= 5


@pytest.mark.quick(3)
@pytest.mark.parametrize("backend", BACKENDS, ids=repr)
def test_every_back_end_returns_the_same_solution(backend, rng):
    for _ in range(5):
        qp = quadratic_program(random_data(rng), Elastic(1.0, curvature=2.0))
        x, _, slack, good = solved(qp, backend)
        exact = solved(qp)
        assert good
        assert x == pytest.approx(exact[0], abs=AGREEMENT.get(backend.name, 1e-5))
        assert slack == pytest.approx(exact[2], abs=AGREEMENT.get(backend.name, 1e-5))


def test_the_joined_function_and_the_separate_calls_agree(rng):
    qp = quadratic_program(random_data(rng), Elastic(1.0))
    assert np.concatenate(solved(qp, joined=False)[:3]) == pytest.approx(np.concatenate(solved(qp)[:3]))


def test_contradictory_rows_have_the_smallest_total_slack(rng):
    """Four rows that cannot be satisfied together: the total slack is that of a linear program."""
    for _ in range(10):
        C = rng.standard_normal((4, 3))
        low = np.abs(rng.standard_normal(4)) + 1
        data = (np.eye(3), np.zeros(3), C, low, np.full(4, np.inf), np.full(3, -0.3), np.full(3, 0.3))
        _, _, slack, good = solved(quadratic_program(data, Elastic(1e3, curvature=1.0)))
        smallest = linprog(
            np.r_[np.zeros(3), np.ones(4)],
            A_ub=-np.hstack([C, np.eye(4)]),
            b_ub=-low,
            bounds=[(-0.3, 0.3)] * 3 + [(0, None)] * 4,
        )
        assert good
        assert slack.sum() == pytest.approx(smallest.fun, abs=1e-3)


def test_equalities_may_be_relaxed_to_either_side():
    """x = 1 and x = -0.5 with the penalties 2 and 3: 2 |x - 1| + 3 |x + 0.5| is smallest at x = -0.5."""
    rows = casadi.SX([[1.0], [1.0]])
    qp = QuadraticProgram(
        casadi.SX(1e-9),
        casadi.SX(0),
        casadi.SX(-np.inf),
        casadi.SX(np.inf),
        [Rows.equal("soft", rows, casadi.SX([1, -0.5]), Elastic([2.0, 3.0], curvature=1e-9))],
    )
    x, y, slack, good = solved(qp)
    assert good
    assert x == pytest.approx([-0.5], abs=1e-7)
    assert slack == pytest.approx([1.5, 0], abs=1e-7)
    assert y == pytest.approx([-2, 2], abs=1e-6)


@pytest.mark.slow
def test_hard_rows_beside_them_stay_hard(rng):
    for _ in range(10):
        data, C = random_data(rng), rng.standard_normal((2, 5))
        hard = C, np.full(2, -0.01), np.full(2, 0.01)
        x, _, slack, good = solved(quadratic_program(data, Elastic(0.3), hard))
        assert good
        assert np.abs(C @ x).max() <= 0.01 + 1e-8
        assert len(slack) == 4


def test_multipliers_are_checked_against_the_penalty():
    """x >= 3 with the penalty 1 beside |x|^2 / 2: the solution is x = 1 with the multiplier 1."""
    qp = quadratic_program(
        (np.eye(1), np.zeros(1), np.ones((1, 1)), [3.0], [np.inf], [-9.0], [9.0]), Elastic(1.0, curvature=1e-6)
    )
    data = [*qp.data(), *qp.penalties]

    def check(*solution):
        return QPCall.of(qp, 1e-6).check(*data, *solution)

    assert float(check(1.0, -1.0 - 2e-6, 2e-6)) == 1
    assert float(check(1.5, -1.5, 0)) == 0  # a larger slack costs less
    assert float(check(0.5, -0.5, 0)) == 0  # a smaller slack costs less
    assert float(check(3.0, -3.0, 0)) == 0


class Conflicting(Strategy):
    """A third-party strategy: each joint by 1 and by -1, the second with three times the penalty, within 0.4."""

    def uses_qp(self, has_criterion):
        return True

    def update(self, model, state):
        n = model.robot.n
        both = casadi.SX([1.0] * n + [-1.0] * n)
        elastic = Elastic([1.0] * n + [3.0] * n)
        rows = [Rows.equal("soft", casadi.vertcat(*[casadi.SX.eye(n)] * 2), both, elastic)]
        box = casadi.SX([-0.4] * n), casadi.SX([0.4] * n)
        answer = model.solve(QuadraticProgram(1e-6 * casadi.SX.eye(n), casadi.SX(n, 1), *box, rows, name="conflicting"))
        return Update(answer.x)


@pytest.mark.parametrize("solver", ["daqp", QPSolversBackend("daqp"), PersistentOSQP()], ids=str)
def test_a_strategy_may_use_them_and_build_shows_the_slack_variables(solver):
    ik = shared_solver(planar(2), jtik.FrameTask(), strategy=Conflicting(), solver=solver)
    q = np.array([0.3, 0.5])
    assert ik.step(q, [1.0, 1.0]).q - q == pytest.approx([-0.4, -0.4], abs=1e-6)
    problem = ik.build(q, [1.0, 1.0])
    assert problem.P.shape == (10, 10)  # two joints, and up and down of four rows
    assert problem.lb[2:] == pytest.approx(np.zeros(8))
    assert problem.q[2:] == pytest.approx([1, 1, 3, 3] * 2)


class TestWrongInput:
    @pytest.mark.parametrize(
        ("options", "named"),
        [
            ({"penalty": 0.0}, "penalty"),
            ({"penalty": np.nan}, "penalty"),
            ({"penalty": 1.0, "curvature": -1.0}, "curvature"),
            ({"penalty": 1.0, "max_slack": -1.0}, "max_slack: given -1.0; accepted: a non-negative"),
            ({"penalty": 1.0, "max_slack": np.nan}, "max_slack"),
            ({}, "penalty"),
        ],
    )
    def test_values(self, options, named):
        with pytest.raises(jtik.ArgumentError, match=named):
            Elastic(**options)

    def test_the_number_of_penalties(self, rng):
        with pytest.raises(jtik.ArgumentError, match=r"penalty.*\(4, 1\)"):
            quadratic_program(random_data(rng), Elastic([1.0, 2.0]))

    def test_slack_of_hard_rows(self):
        qp = QuadraticProgram(*map(casadi.SX, (1, 0, -1, 1)), [Rows("hard", *map(casadi.SX, (1, -1, 1)))])
        with pytest.raises(jtik.ArgumentError, match="elastic"):
            QPRecorder(1e-9).solve(qp).slack("hard")


def test_a_single_elastic_row_with_two_bounds():
    """minimise x^2/2 - 3 x with the elastic equality x = 0.5: x = 3 - y, y = 1 + (x - 0.5)."""
    P, q, low, high, row, to = (casadi.SX(value) for value in (1, -3, -9, 9, 1, 0.5))
    qp = QuadraticProgram(P, q, low, high, [Rows.equal("soft", row, to, Elastic(1.0))])
    x, y, slack, good = solved(qp)
    assert good
    assert [x.item(), y.item(), slack.item()] == pytest.approx([1.25, 1.75, 0.75], abs=1e-8)


class TestDeprecatedNames:
    def test_arguments(self):
        with pytest.warns(DeprecationWarning, match="'price' is deprecated; use 'penalty'"):
            assert Elastic(price=2.0) == Elastic(2.0)
        with pytest.warns(DeprecationWarning, match="'give' is deprecated; use 'max_slack'"):
            assert Elastic(2.0, give=0.5) == Elastic(2.0, max_slack=0.5)

    def test_attributes(self):
        elastic = Elastic(2.0, max_slack=0.5)
        with pytest.warns(DeprecationWarning, match="penalty"):
            assert elastic.price == 2.0
        with pytest.warns(DeprecationWarning, match="max_slack"):
            assert elastic.give == 0.5

"""Quadratic programs as data: shapes, names, the check of solutions, and QPs of a strategy."""

from __future__ import annotations

import casadi
import numpy as np
import pytest
import qpsolvers

import jtik
from jtik.qp import PersistentOSQP, QPRecorder, QPSolversBackend, QuadraticProgram, Rows
from jtik.strategy import Strategy, Update
from jtik.symbolic import function, gram
from jtik_formulations import JointCentering

from ..conftest import planar, shared_solver


def quadratic_program(**changes):
    data = {
        "P": casadi.SX.eye(3),
        "q": casadi.SX([1.0, -2.0, 0.5]),
        "lower": casadi.SX([-1.0] * 3),
        "upper": casadi.SX([1.0] * 3),
        "rows": [Rows.equal("sum", casadi.SX.ones(1, 3), casadi.SX([0.5]))],
    }
    return QuadraticProgram(**data | changes)


def test_groups_of_rows_are_stacked_and_found_by_name():
    more = Rows("more", casadi.SX([[1, 0, 0], [0, 1, 0]]), casadi.SX([-1, -2]), casadi.SX([1, 2]))
    stacked = quadratic_program(rows=[*quadratic_program().rows, more])
    assert stacked.row_count == 3
    assert stacked.data()[2].shape == (3, 3)
    solution = QPRecorder(1e-9).solve(stacked)
    assert solution.multipliers("more").shape == (2, 1)
    with pytest.raises(jtik.ArgumentError, match="'sum', 'more'"):
        solution.multipliers("most")


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"P": casadi.SX.eye(2)}, "P"),
        ({"lower": casadi.SX([0.0])}, "lower"),
        ({"known_convex": 1}, "known_convex"),
        ({"rows": [Rows.equal("tight", casadi.SX.ones(1, 2), casadi.SX([0]))]}, "tight"),
    ],
)
def test_shapes_are_checked(change, named):
    with pytest.raises(jtik.ArgumentError, match=named):
        quadratic_program(**change)


def test_build_returns_the_qp_for_another_solver():
    arm, q = planar(5, lower=-1.0, upper=1.0), np.array([0.3, 0.4, 0.95, 0.2, -0.1])
    ik = shared_solver(arm, jtik.FrameTask(), criteria=JointCentering(), strategy="newton+qp")
    problem = ik.build(q, arm.position(q))
    assert isinstance(problem, qpsolvers.Problem)
    assert pytest.approx(np.eye(2)) == problem.A @ problem.A.T
    assert problem.lb == pytest.approx(-1 - q)
    assert problem.ub == pytest.approx(1 - q)
    step = qpsolvers.solve_problem(problem, solver="daqp").x
    assert ik.step(q, arm.position(q)).q == pytest.approx(q + step, abs=1e-9)


def test_build_needs_a_strategy_with_a_qp_of_that_name():
    ik = shared_solver(planar(3), jtik.FrameTask())
    with pytest.raises(jtik.ArgumentError, match="newton\\+qp"):
        ik.build(np.zeros(3), [1.0, 1.0])
    pair = shared_solver(planar(3), jtik.FrameTask(), criteria=JointCentering(), strategy="newton+qp")
    with pytest.raises(jtik.UnknownNameError, match="second"):
        pair.build(np.zeros(3), [1.0, 1.0], qp="second")


class Contradiction(Strategy):
    """A third-party strategy whose QP is infeasible."""

    def uses_qp(self, has_criterion):
        return True

    def update(self, model, state):
        n = model.robot.n
        ones = casadi.SX.ones(1, n)
        rows = [Rows.equal("one", ones, casadi.SX([1])), Rows.equal("two", ones, casadi.SX([2]))]
        open_box = [casadi.SX([side * np.inf] * n) for side in (-1, 1)]
        x = model.solve(QuadraticProgram(casadi.SX.eye(n), casadi.SX(n, 1), *open_box, rows)).x
        return Update(x)


@pytest.mark.parametrize("solver", ["daqp", "osqp", QPSolversBackend("daqp"), PersistentOSQP()], ids=str)
def test_an_infeasible_qp_ends_a_solve_with_a_status(solver):
    ik = shared_solver(planar(3), jtik.FrameTask(), strategy=Contradiction(), solver=solver)
    solution = ik.solve([1.0, 1.0], q0=[0.1, 0.2, 0.3])
    assert solution.status is jtik.Status.UNSOLVED
    assert solution.q == pytest.approx([0.1, 0.2, 0.3])
    assert not ik.step([0.1, 0.2, 0.3], [1.0, 1.0]).accepted


class Saddle(Strategy):
    """A third-party strategy whose P is not convex."""

    def uses_qp(self, has_criterion):
        return True

    def update(self, model, state):
        n = model.robot.n
        box = [casadi.SX([side * 2.0] * n) for side in (-1, 1)]
        P = gram(model.J) - 0.1 * casadi.SX.eye(n)
        return Update(model.solve(QuadraticProgram(P, model.J.T @ model.here.residual, *box)).x)


@pytest.mark.parametrize("n", [3, 16])
def test_a_qp_that_is_not_convex_has_no_solution(n):
    ik = shared_solver(planar(n), jtik.FrameTask(), strategy=Saddle())
    solution = ik.solve([1.0, 1.0], q0=np.full(n, 0.1))
    assert solution.status is jtik.Status.UNSOLVED
    assert solution.q.tolist() == [0.1] * n


class TwoQPs(Strategy):
    """First the shortest step, then the one closest to (1, 1, 1, 1) among those with the same task motion."""

    def uses_qp(self, has_criterion):
        return True

    def update(self, model, state):
        n, r, J = model.robot.n, model.here.residual, model.J
        open_box = [casadi.SX([side * np.inf] * n) for side in (-1, 1)]
        task = Rows.equal("task", J, -r)
        first = model.solve(QuadraticProgram(casadi.SX.eye(n), casadi.SX(n, 1), *open_box, [task], name="first"))
        again = Rows.equal("again", J, J @ first.x)
        second = model.solve(QuadraticProgram(casadi.SX.eye(n), -casadi.SX.ones(n), *open_box, [again], name="second"))
        return Update(second.x)


@pytest.mark.parametrize("solver", ["daqp", QPSolversBackend("daqp")], ids=str)
def test_a_qp_may_use_the_solution_of_the_one_before(solver):
    arm, q, target = planar(4), np.array([0.3, 0.4, 0.5, 0.2]), np.array([2.0, 2.5])
    ik = shared_solver(arm, jtik.FrameTask(), strategy=TwoQPs(), solver=solver)
    J = arm.jacobian(q)[:2]
    shortest = np.linalg.pinv(J) @ (target - arm.position(q))
    expected = shortest + (np.eye(4) - np.linalg.pinv(J) @ J) @ np.ones(4)
    assert ik.step(q, target).q - q == pytest.approx(expected, abs=1e-9)
    assert ik.build(q, target, qp="second").b == pytest.approx(target - arm.position(q), abs=1e-9)


class TestSolutionWithoutSolver:
    """The unconstrained minimiser, and whether it satisfies rows and box and so solves the QP."""

    def of(self, P, q, lower, upper, rows=()):
        x, solves = QuadraticProgram(*map(casadi.SX, (P, q, lower, upper)), rows=rows).solution_without_solver()
        x, solves = function("f", [], [x, solves])()["o0"].full()[:, 0], function("f", [], [solves])()["o0"]
        return x, bool(solves)

    def test_inside(self):
        x, solves = self.of(np.diag([2.0, 4.0]), [2.0, -2.0], [-1, -1], [1, 1])
        assert (x.tolist(), solves) == ([-1.0, 0.5], True)

    @pytest.mark.parametrize("lower", [-0.5, -1 + 1e-9])
    def test_outside(self, lower):
        assert not self.of(np.diag([2.0, 4.0]), [2.0, -2.0], [lower, -1], [1, 1])[1]

    @pytest.mark.parametrize(("bound", "solves"), [(-0.5, True), (-0.51, False)])
    def test_rows(self, bound, solves):
        rows = [Rows("r", *map(casadi.SX, ([[1.0, 1.0]], [-np.inf], [bound])))]
        assert self.of(np.diag([2.0, 4.0]), [2.0, -2.0], [-5, -5], [5, 5], rows)[1] is solves

    def test_singular(self):
        assert not self.of(np.diag([1.0, 0.0]), [0.0, 1.0], [-1, -1], [1, 1])[1]

    def test_not_convex(self):
        pivot = casadi.SX.sym("pivot")
        P = casadi.diag(casadi.vertcat(1, pivot))
        found = QuadraticProgram(P, *map(casadi.SX, ([0.1, 0.1], [-1, -1], [1, 1]))).solution_without_solver()[1]
        solves = function("solves", [pivot], [found])
        assert [float(solves(each)) for each in (2.0, -2.0)] == [1, 0]

    @pytest.mark.parametrize(("n", "tried"), [(15, True), (16, False)])
    def test_it_is_tried_where_its_factorisation_is_cheap(self, n, tried, rng):
        A = rng.normal(size=(n, n))
        P, q, bounds = A @ A.T + np.eye(n), rng.normal(size=n), np.full(n, 100.0)
        x, solves = self.of(P, q, -bounds, bounds)
        assert solves is tried
        assert not tried or x == pytest.approx(-np.linalg.solve(P, q), abs=1e-9)
        assert self.of(casadi.SX.eye(n), q, -bounds, bounds)[1], "the identity has no factorisation to compute"

    def test_a_solve_is_the_same_as_with_a_back_end_that_always_solves(self):
        for strategy in ("newton+qp", "weighted_qp"):
            ends = []
            for solver in ("daqp", QPSolversBackend("daqp")):
                ik = shared_solver(
                    planar(6, lower=-0.7, upper=0.7),
                    jtik.FrameTask(),
                    criteria=JointCentering(),
                    strategy=strategy,
                    solver=solver,
                )
                ends.append(ik.solve([3.0, 3.0], q0=np.full(6, 0.2), max_iterations=40).q)
            assert ends[0] == pytest.approx(ends[1], abs=1e-6)

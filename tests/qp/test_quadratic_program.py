"""Programs as data: shapes, names, what the engine checks of an answer, and how a strategy asks."""

from __future__ import annotations

import casadi
import numpy as np
import pytest
import qpsolvers

import jtik
from jtik.qp import QPRecorder, QuadraticProgram, Rows
from jtik.strategy import Strategy, Update
from jtik_formulations import JointCentering

from ..conftest import planar


def program(**changes):
    data = {
        "P": casadi.SX.eye(3),
        "q": casadi.SX([1.0, -2.0, 0.5]),
        "lower": casadi.SX([-1.0] * 3),
        "upper": casadi.SX([1.0] * 3),
        "rows": [Rows.equal("sum", casadi.SX.ones(1, 3), casadi.SX([0.5]))],
    }
    return QuadraticProgram(**data | changes)


def test_groups_lie_below_each_other_and_are_found_by_name():
    more = Rows("more", casadi.SX([[1, 0, 0], [0, 1, 0]]), casadi.SX([-1, -2]), casadi.SX([1, 2]))
    whole = program(rows=[*program().rows, more])
    assert whole.row_count == 3
    assert whole.data()[2].shape == (3, 3)
    solution = QPRecorder(1e-9).solve(whole)
    assert solution.multipliers("more").shape == (2, 1)
    with pytest.raises(jtik.ArgumentError, match="'sum', 'more'"):
        solution.multipliers("most")


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"P": casadi.SX.eye(2)}, "P"),
        ({"lower": casadi.SX([0.0])}, "lower"),
        ({"rows": [Rows.equal("tight", casadi.SX.ones(1, 2), casadi.SX([0]))]}, "tight"),
    ],
)
def test_shapes_are_checked(change, named):
    with pytest.raises(jtik.ArgumentError, match=named):
        program(**change)


def test_an_answer_is_not_believed():
    recorder = QPRecorder(accuracy=1e-6)
    solution = recorder.solve(program())
    check = casadi.Function(
        "check",
        [solution.x, solution.row_multipliers, solution.box_multipliers],
        [solution.violation, solution.stationarity, recorder.solved()],
    )
    # x = -q - y where the box is open: y from the sum, -1 + 2 - 0.5 - 3 y = 0.5 with the second at its bound
    x, y, z = np.array([-0.5, 1.0, 0.0]), np.array([-0.5]), np.array([0.0, 1.5, 0.0])
    assert [float(v) for v in check(x, y, z)] == pytest.approx([0, 0, 1], abs=1e-15)
    assert float(check([-0.4, 1.0, 0.0], y, z)[0]) == pytest.approx(0.1)
    assert float(check([-0.5, 1.2, -0.2], y, z)[0]) == pytest.approx(0.2)
    assert float(check(x, y + 1, z)[2]) == 0
    assert float(check([np.nan] * 3, y, z)[2]) == 0


def test_a_user_can_look_at_the_program_and_solve_it_elsewhere():
    arm, q = planar(5, lower=-1.0, upper=1.0), np.array([0.3, 0.4, 0.95, 0.2, -0.1])
    ik = jtik.InverseKinematics(arm, jtik.FrameTask(), criteria=JointCentering(), strategy="newton+qp")
    problem = ik.build(q, arm.position(q))
    assert isinstance(problem, qpsolvers.Problem)
    assert pytest.approx(np.eye(2)) == problem.A @ problem.A.T
    assert problem.lb == pytest.approx(-1 - q)
    assert problem.ub == pytest.approx(1 - q)
    step = qpsolvers.solve_problem(problem, solver="daqp").x
    assert ik.step(q, arm.position(q)).q == pytest.approx(q + step, abs=1e-9)


def test_there_is_none_without_a_strategy_that_has_one():
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask())
    with pytest.raises(jtik.ArgumentError, match="newton\\+qp"):
        ik.build(np.zeros(3), [1.0, 1.0])
    pair = jtik.InverseKinematics(planar(3), jtik.FrameTask(), criteria=JointCentering(), strategy="newton+qp")
    with pytest.raises(jtik.UnknownNameError, match="second"):
        pair.build(np.zeros(3), [1.0, 1.0], qp="second")


class Contradiction(Strategy):
    """A third party's law whose program has no answer."""

    def uses_qp(self, has_criterion):
        return True

    def update(self, model, state):
        n = model.robot.n
        ones = casadi.SX.ones(1, n)
        rows = [Rows.equal("one", ones, casadi.SX([1])), Rows.equal("two", ones, casadi.SX([2]))]
        open_box = [casadi.SX([side * np.inf] * n) for side in (-1, 1)]
        x = model.solve(QuadraticProgram(casadi.SX.eye(n), casadi.SX(n, 1), *open_box, rows)).x
        return Update(model.moved(-x), 1, {}, -x, -x, casadi.SX(n, 1))


@pytest.mark.parametrize("solver", ["daqp", "osqp", jtik.qp.Foreign("daqp"), jtik.qp.PersistentOSQP()], ids=str)
def test_a_program_without_an_answer_ends_a_solve_with_a_status(solver):
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=Contradiction(), solver=solver)
    solution = ik.solve([1.0, 1.0], q0=[0.1, 0.2, 0.3])
    assert solution.status is jtik.Status.UNSOLVED
    assert solution.q == pytest.approx([0.1, 0.2, 0.3])
    assert not ik.step([0.1, 0.2, 0.3], [1.0, 1.0]).accepted


class TwoPrograms(Strategy):
    """First the shortest step, then the one nearest to (1, 1, 1) among those that bring the tip as near."""

    def uses_qp(self, has_criterion):
        return True

    def update(self, model, state):
        n, r, J = model.robot.n, model.here.residual, model.J
        open_box = [casadi.SX([side * np.inf] * n) for side in (-1, 1)]
        task = Rows.equal("task", J, -r)
        first = model.solve(QuadraticProgram(casadi.SX.eye(n), casadi.SX(n, 1), *open_box, [task], name="first"))
        again = Rows.equal("again", J, J @ first.x)
        second = model.solve(QuadraticProgram(casadi.SX.eye(n), -casadi.SX.ones(n), *open_box, [again], name="second"))
        return Update(model.moved(-second.x), 1, {}, -second.x, -second.x, casadi.SX(n, 1))


@pytest.mark.parametrize("solver", ["daqp", jtik.qp.Foreign("daqp")], ids=str)
def test_a_program_may_use_the_answer_of_the_one_before(solver):
    arm, q, target = planar(4), np.array([0.3, 0.4, 0.5, 0.2]), np.array([2.0, 2.5])
    ik = jtik.InverseKinematics(arm, jtik.FrameTask(), strategy=TwoPrograms(), solver=solver)
    J = arm.jacobian(q)[:2]
    shortest = np.linalg.pinv(J) @ (target - arm.position(q))
    expected = shortest + (np.eye(4) - np.linalg.pinv(J) @ J) @ np.ones(4)
    assert ik.step(q, target).q - q == pytest.approx(expected, abs=1e-9)
    assert ik.build(q, target, qp="second").b == pytest.approx(target - arm.position(q), abs=1e-9)

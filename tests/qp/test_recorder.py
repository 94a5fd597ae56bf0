"""The recorder: QPs and computations in order, the symbols of their results, and the check of all of them."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.qp import QPRecorder, QuadraticProgram, Rows
from jtik.symbolic import function, symvar


def quadratic_program(name="program", n=2):
    """minimise |x|^2/2 - sum(x) with sum(x) <= 1 in the box |x| <= 1; the solution is x = 1/n, multiplier 1 - 1/n."""
    ones = casadi.SX.ones(n, 1)
    rows = [Rows("sum", ones.T, casadi.SX(-np.inf), casadi.SX(1))]
    return QuadraticProgram(casadi.SX.eye(n), -ones, -ones, ones, rows, name=name)


def names(columns):
    return {variable.name() for column in columns for variable in symvar(casadi.vec(column))}


class TestOrder:
    def test_qps_and_computations_are_recorded_in_the_order_of_their_use(self):
        recorder = QPRecorder(1e-6)
        recorder.solve(quadratic_program("first"))
        recorder.compute("second", lambda _: None, [casadi.SX(1)], [(1, 1)])
        recorder.solve(quadratic_program("third"))
        assert [each.name for each in recorder.calls] == ["first", "second", "third"]
        assert [each.name for each, _ in recorder.solutions()] == ["first", "third"]

    def test_results_are_symbols_of_their_own(self):
        recorder = QPRecorder(1e-6)
        one, other = recorder.solve(quadratic_program()), recorder.solve(quadratic_program())
        answers = recorder.compute("mine", lambda _: None, [], [(2, 3), (1, 1)])
        assert [answer.shape for answer in answers] == [(2, 3), (1, 1)]
        groups = [names([each.x, each.row_multipliers, each.box_multipliers]) for each in (one, other)] + [
            names(answers)
        ]
        assert [len(group) for group in groups] == [5, 5, 7]
        assert len(set.union(*groups)) == 17

    def test_a_recorded_qp_gives_its_data_and_the_symbols_of_its_solution(self):
        recorder = QPRecorder(1e-6)
        solution = recorder.solve(quadratic_program())
        (recorded,) = recorder.calls
        assert [part.shape for part in recorded.data()] == [(2, 2), (2, 1), (1, 2), (1, 1), (1, 1), (2, 1), (2, 1)]
        found = [solution.x, solution.row_multipliers, solution.box_multipliers]
        assert recorded.result_symbols == [*found, recorded.good]

    def test_a_recorded_computation_keeps_its_arguments_and_its_function(self):
        recorder, compute, argument = QPRecorder(1e-6), lambda _: None, casadi.SX.sym("a", 2)
        recorder.compute("mine", compute, [argument], [(1, 1)])
        (recorded,) = recorder.calls
        assert recorded.compute is compute
        assert recorded.data() == [argument]


class TestCheck:
    @staticmethod
    def checked(good, computed):
        """Whether a QP that its solver reports as ``good`` and two results of a computation pass together."""
        recorder = QPRecorder(1e-6)
        recorder.solve(quadratic_program())
        answers = recorder.compute("mine", lambda _: None, [], [(2, 1)])
        (qp, _) = recorder.calls
        return bool(function("check", [qp.good, *answers], [recorder.solved()])(good, computed))

    def test_a_solution_and_results_that_are_numbers_pass(self):
        assert self.checked(1, [1.0, -np.inf])

    def test_a_wrong_solution_does_not(self):
        assert not self.checked(0, [1.0, 1.0])

    @pytest.mark.parametrize("at", [0, 1])
    def test_a_result_that_is_nan_does_not(self, at):
        computed = np.array([0.0, 1.0])
        computed[at] = np.nan
        assert not self.checked(1, computed)

    def test_nothing_recorded_passes(self):
        assert QPRecorder(1e-6).solved() == 1


class TestPreparations:
    def test_they_stand_apart_from_the_qps_of_the_step(self):
        recorder = QPRecorder(1e-6)
        answers = recorder.prepare(1, quadratic_program("before"), lambda solution: [solution.x, 2 * solution.x[0]])
        assert [answer.shape for answer in answers] == [(2, 1), (1, 1)]
        assert recorder.calls == []
        assert recorder.solved() == 1
        (preparation,) = recorder.preparations
        assert preparation.solution.qp.name == "before"
        assert not names(preparation.results) & names(answers)

    def test_several_have_symbols_of_their_own(self):
        recorder = QPRecorder(1e-6)
        one, other = (recorder.prepare(1, quadratic_program(), lambda solution: [solution.x])[0] for _ in range(2))
        assert not names([one]) & names([other])

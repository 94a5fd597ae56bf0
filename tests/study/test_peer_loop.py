"""The loop over single steps of a library: attempts, stopping rules and traces, with a library of known steps."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.study import Setting
from jtik.study.peers.base import Goal
from jtik.study.peers.loop import PATIENCE, StepLoop

ARM, TASK = jtik.Robot.planar(2), jtik.FrameTask("tip")


class Halving(StepLoop):
    """Each step halves the distance to the origin of joint space; the error is that distance [m]."""

    factor = 0.5

    def set_target(self, target):
        self.target = target

    def set_configuration(self, q):
        self.current = np.array(q, dtype=float)

    def q(self):
        return self.current.copy()

    def error(self):
        return float(np.linalg.norm(self.current)), 0.0

    def step(self):
        if self.factor is None:
            return None
        before = self.current
        self.current = self.factor * before
        return float(np.linalg.norm(self.current - before))


def loop(factor=0.5, restarted=10, **options):
    made = Halving(Goal.of(Setting(robot=ARM, task=TASK, **options), "halving"), restarted=restarted)
    made.factor = factor
    return made


def test_an_attempt_ends_at_the_first_configuration_within_tolerance():
    answer = loop(position_tolerance=1e-3).solve(None, np.array([1.0, 0.0]))
    assert (answer.status, answer.claimed, answer.iterations) == ("REACHED", True, 10)
    assert np.linalg.norm(answer.q) == 2.0**-10


def test_the_iteration_limit_ends_an_attempt():
    answer = loop(max_iterations=3).solve(None, np.array([1.0, 0.0]))
    assert (answer.status, answer.claimed, answer.iterations) == ("ITERATION_LIMIT", False, 3)
    answer = loop(factor=0.999).solve(None, np.array([1.0, 0.0]))
    assert answer.iterations == PATIENCE


def test_an_attempt_that_does_not_move_is_stalled():
    assert loop(factor=1.0).solve(None, np.array([1.0, 0.0])).status == "STALLED"


def test_a_step_without_a_solution_ends_an_attempt():
    assert loop(factor=None).solve(None, np.array([1.0, 0.0])).status == "UNSOLVED"


def test_restarts_are_the_same_at_every_call_and_the_best_attempt_is_returned():
    solver = loop(factor=0.9, restarted=2, restarts=4)
    first, second = (solver.solve(None, np.array([3.0, 3.0])) for _ in range(2))
    np.testing.assert_array_equal(first.q, second.q)
    assert first.iterations == 5 * 2
    starts = [np.linalg.norm(q) for q in solver.goal.starts(np.array([3.0, 3.0]))]
    assert np.linalg.norm(first.q) == pytest.approx(0.81 * min(starts))


def test_a_trace_has_every_configuration_and_the_attempt():
    answer, trace = loop(factor=0.9, restarted=2, restarts=1).traced(None, np.array([0.1, 0.0]))
    assert trace.figures["attempt"].tolist() == [0, 0, 0, 1, 1]
    assert len(trace.q) == 6
    assert trace.error == pytest.approx(np.linalg.norm(trace.q, axis=1))
    assert any((row == answer.q).all() for row in trace.q)

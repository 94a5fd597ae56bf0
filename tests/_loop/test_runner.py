"""The runner: two memories in turn, a fresh start, and the record."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik._loop.runner import Runner
from jtik._step.fused_step import fused_step
from jtik._step.stopping import OUTCOME, Code
from jtik_formulations import Newton

from ..conftest import planar, planar_points

Q = np.array([0.4, -0.3, 0.8])
TARGET = planar_points(Q)[-1] + np.array([-0.2, 0.3])


@pytest.fixture
def runner():
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=Newton())
    ik._engine.memory.inputs.target[:] = TARGET
    fused = fused_step(ik._engine.problem, Newton(), recorded=True)
    return Runner(fused, ik._engine.memory.inputs, 3)


def test_calls_alternate_between_two_memories(runner):
    runner.start(Q)
    errors = []
    for k in range(4):
        before = runner.q[k % 2].copy()
        runner.calls[k % 2]()
        assert runner.q[k % 2].tolist() == before.tolist()
        errors.append(np.linalg.norm(planar_points(runner.q[1 - k % 2])[-1] - TARGET))
        assert runner.outcome[OUTCOME.position_error] == pytest.approx(errors[-1], abs=1e-12)
    assert errors == sorted(errors, reverse=True)


def test_the_outcome_can_be_read_through_its_view(runner):
    runner.start(Q)
    runner.calls[0]()
    assert runner.view.tolist() == runner.outcome.tolist()
    assert runner.view[OUTCOME.code] == Code.CONTINUE


def test_a_start_forgets_the_attempt_before(runner):
    runner.start(Q, patience=7)
    patience = runner.fused.state.slices["patience"]
    assert runner.state[0][patience] == 7
    runner.calls[0]()
    first = runner.q[1].copy()
    runner.calls[1]()
    runner.at = 1
    runner.start(Q)
    assert (runner.at, runner.state[0][patience].item()) == (0, math.inf)
    rest = np.delete(runner.state[0], patience)
    assert rest.tolist() == np.delete(runner.first_state, patience).tolist()
    runner.calls[0]()
    assert runner.q[1].tolist() == first.tolist()


def test_the_record_is_that_of_the_last_call(runner):
    runner.start(Q)
    runner.calls[0]()
    dq = runner.record[runner.fused.record.slices["dq"]]
    assert dq == pytest.approx(runner.q[1] - Q)


def test_without_a_record_it_is_empty(runner):
    plain = fused_step(jtik.InverseKinematics(planar(3), jtik.FrameTask())._engine.problem, Newton())
    assert Runner(plain, runner.inputs, 3).record.size == 0

"""The fused step: one call against the same update by NumPy, refusals, errors of the outcome, its state and record."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import jtik
from jtik._step.fused_step import STRATEGY_PREFIX, fused_step
from jtik._step.stopping import Code, StepOutcome
from jtik.qp import backend_of
from jtik.qp.fast_path import StepPath
from jtik.strategy import Strategy, Update
from jtik.symbolic.compile import CompiledFunction
from jtik_formulations import JointCentering

from ..conftest import planar, planar_jacobian, planar_points
from .conftest import inputs_of, problem_of

Q = np.array([0.4, -0.3, 0.8])
TARGET = planar_points(Q)[-1] + np.array([-0.2, 0.3])
NEWTON = -np.linalg.pinv(planar_jacobian(Q)) @ (planar_points(Q)[-1] - TARGET)


class GaussNewton(Strategy):
    """-J+ r, accepted or not, counting its calls; with the candidate evaluated or not."""

    def __init__(self, accepted=1, evaluates=True):
        self.accepted, self._evaluates = accepted, evaluates

    def initial_state(self, shape):
        return {"calls": np.zeros(1)}

    def evaluates_candidate(self, has_criterion):
        return self._evaluates

    def update(self, model, state):
        dq = model.row_space_free.least_squares(-model.here.residual).vector
        return Update(dq, accepted=self.accepted, state={"calls": state["calls"] + 1})


def called(strategy, q=Q, target=TARGET, *, robot=None, criteria=None, memory=None, settings=None, **options):
    """The fused step, and q', state by name, outcome and record by name of one call."""
    problem = problem_of(robot or planar(3), criteria=criteria)
    fused = fused_step(problem, strategy, **options)
    memory = fused.first_state if memory is None else memory
    results = CompiledFunction(fused.function)(q, *inputs_of(problem, target, **(settings or {})), memory)
    after, state, outcome, *record = (part.ravel() for part in results)
    named = {name: state[where] for name, where in fused.state.slices.items()}
    figures = {name: record[0][where] for name, where in fused.record.slices.items()} if record else {}
    return fused, after, named, StepOutcome(*outcome), figures


def test_an_accepted_step_is_the_displacement_of_the_strategy():
    _, q, state, outcome, _ = called(GaussNewton())
    assert q == pytest.approx(Q + NEWTON)
    assert (outcome.code, outcome.tried, outcome.accepted) == (Code.CONTINUE, 1, 1)
    assert state[STRATEGY_PREFIX + "calls"].item() == 1


def test_its_outcome_has_the_error_where_it_ends():
    _, q, _, outcome, _ = called(GaussNewton())
    error = np.linalg.norm(planar_points(q)[-1] - TARGET)
    assert (outcome.position_error, outcome.orientation_error) == (pytest.approx(error), 0)
    assert pytest.approx(error**2 / 2) == outcome.V


def test_a_refused_step_changes_the_state_only():
    _, q, state, outcome, _ = called(GaussNewton(accepted=0))
    assert q.tolist() == Q.tolist()
    assert (outcome.tried, outcome.accepted) == (1, 0)
    assert (state[STRATEGY_PREFIX + "calls"].item(), state["refused"].item()) == (1, 1)
    assert outcome.position_error == pytest.approx(np.linalg.norm(planar_points(Q)[-1] - TARGET))


class TestWithoutEvaluation:
    """A strategy that accepts every step saves the kinematics where it ends."""

    def test_the_error_is_that_before_the_step(self):
        _, q, state, outcome, _ = called(GaussNewton(evaluates=False))
        assert q == pytest.approx(Q + NEWTON)
        assert outcome.position_error == pytest.approx(np.linalg.norm(planar_points(Q)[-1] - TARGET))
        assert "V" in state

    def test_on_demand_it_is_that_after_the_step(self):
        _, q, _, outcome, _ = called(GaussNewton(evaluates=False), evaluated=True)
        assert outcome.position_error == pytest.approx(np.linalg.norm(planar_points(q)[-1] - TARGET))


def test_on_the_target_no_step_is_tried():
    _, q, _, outcome, _ = called(GaussNewton(), target=planar_points(Q)[-1])
    assert q.tolist() == Q.tolist()
    assert (outcome.code, outcome.tried) == (Code.DONE, 0)


def test_a_step_that_arrives_ends_the_solve():
    tolerance = np.linalg.norm(planar_points(Q + NEWTON)[-1] - TARGET)
    for factor, code in ((1.01, Code.DONE), (0.99, Code.CONTINUE)):
        assert called(GaussNewton(), settings={"position_tolerance": factor * tolerance})[3].code == code


@pytest.mark.parametrize("limits", [{}, {"lower": -2.0, "upper": 2.0}], ids=["free", "limited"])
def test_nan_has_a_code_and_no_step(limits):
    _, _, _, outcome, _ = called(GaussNewton(), q=np.array([0.4, np.nan, 0.8]), robot=planar(3, **limits))
    assert (outcome.code, outcome.tried, outcome.accepted) == (Code.NOT_FINITE, 0, 0)


def test_a_start_outside_the_limits_is_clamped_before_the_step():
    robot = planar(3, lower=-0.5, upper=0.5)
    outside, inside = (called(GaussNewton(), q=q, robot=robot)[1] for q in (Q, np.clip(Q, -0.5, 0.5)))
    assert outside.tolist() == inside.tolist()
    assert (np.abs(outside) <= 0.5).all()


class TestState:
    def test_the_parts_of_the_engine_come_first_then_those_of_the_strategy(self):
        fused = called(GaussNewton(), robot=planar(3, lower=-2, upper=2), criteria=JointCentering())[0]
        names = list(fused.state.slices)
        assert names[-1] == STRATEGY_PREFIX + "calls"
        assert {"refused", "stagnant", "without_progress", "best", "patience", "neighbourhood", "active"} == set(
            names[:-1]
        )
        assert fused.state.size == fused.first_state.size
        assert all(first.stop == second.start for first, second in pairwise(fused.state.slices.values()))

    def test_the_neighbourhood_of_the_first_step_is_kept(self):
        fused, q, state, _, _ = called(GaussNewton(), criteria=JointCentering())
        memory = np.concatenate([state[name] for name in fused.state.slices])
        after = called(GaussNewton(), q=q, criteria=JointCentering(), memory=memory)[2]
        assert state["neighbourhood"].item() > 0
        assert after["neighbourhood"].tolist() == state["neighbourhood"].tolist()
        assert after[STRATEGY_PREFIX + "calls"].item() == 2


def test_a_record_is_given_on_demand():
    fused, _, _, _, figures = called(GaussNewton(), recorded=True)
    assert figures["dq"] == pytest.approx(NEWTON)
    assert figures["V"].item() == pytest.approx(np.sum((planar_points(Q)[-1] - TARGET) ** 2) / 2)
    assert called(GaussNewton())[0].record.size == 0
    assert fused.relaxation.entries == ()


def test_a_strategy_with_quadratic_programs_has_parts():
    strategy = jtik.strategies["weighted_qp"]()
    fused = fused_step(problem_of(planar(3, lower=-1, upper=1)), strategy, backend=backend_of("daqp"))
    assert fused.parts is not None
    assert fused.parts.fusible
    assert called(GaussNewton())[0].parts is None


def test_bound_memory_is_read_and_written():
    problem = problem_of(planar(3))
    fused = fused_step(problem, GaussNewton())
    q, state, outcome = np.zeros(3), np.zeros(fused.state.size), np.zeros(len(StepOutcome._fields))
    start = Q.copy()
    call = fused.bind(
        [start, *inputs_of(problem, TARGET), fused.first_state.copy()], [q, state, outcome], [StepPath.FAST]
    )
    call()
    assert q == pytest.approx(Q + NEWTON)
    start[:] = q
    call()
    assert outcome[StepOutcome._fields.index("position_error")] < 0.1

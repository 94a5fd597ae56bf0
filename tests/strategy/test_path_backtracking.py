"""A refused step is followed by a smaller one, for every strategy that supports clearances."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np
import pytest

import jtik
from jtik.qp import QuadraticProgram
from jtik.strategy import Backtracking, Composition, Programmed, Proposal, TaskDisplacement, TaskStep
from jtik.strategy.backtracking import path_backtracking
from jtik.symbolic import identity
from jtik_formulations import ObstacleAvoidance, QPSecondary, WeightedQP

from ..conftest import planar, shared_solver

Q, TARGET = np.array([-1.7, 1.7, 0.5]), np.array([-1.5, -1.5])
CIRCLE = jtik.Circle((2.2, -0.5), 0.3)


def solver(strategy, criteria=None):
    clearance = jtik.Clearance(ObstacleAvoidance(CIRCLE, bodies="links"), safe=0.05)
    return shared_solver(planar(3), jtik.FrameTask(), criteria=criteria, strategy=strategy, clearances=clearance)


def without_backtracking():
    """Every registered strategy that supports clearances, none with backtracking where that is an option."""
    for name in jtik.strategies:
        strategy = jtik.strategies[name]()
        options = {}
        names = {each.name for each in fields(strategy)}
        if "backtracking" in names:
            options["backtracking"] = False
        if isinstance(strategy, Composition) and "secondary" in names:
            options["secondary"] = QPSecondary()
        strategy = replace(strategy, **options)
        if strategy.supports_clearances():
            yield pytest.param(strategy, id=name)


@pytest.mark.quick(4)
@pytest.mark.parametrize("strategy", list(without_backtracking()))
def test_no_solve_stalls_at_its_start(strategy):
    solution = solver(strategy).solve(TARGET, q0=Q, max_iterations=300)
    assert solution.status is not jtik.Status.STALLED
    assert np.linalg.norm(solution.q - Q) > 0.5


def test_a_step_that_is_not_safe_is_halved_until_it_is():
    """The example of an arm that tried the same step 40 times."""
    solution = solver(WeightedQP(backtracking=False)).solve(TARGET, q0=Q, trace=True)
    assert solution
    accepted = solution.trace.accepted
    assert not accepted[0]
    assert accepted[:5].any()


@dataclass(frozen=True, kw_only=True)
class FixedStep(TaskStep):
    """A task step that no refusal shortens."""

    def propose(self, model, state):
        return TaskDisplacement(model.row_space_free.least_squares(-model.here.residual).vector)


@dataclass(frozen=True, kw_only=True)
class Stubborn(Composition):
    """A composition that takes every step and shortens none."""

    def task_step(self):
        return FixedStep()

    def secondary_term(self):
        return QPSecondary()

    def acceptance(self):
        return "always"


@dataclass(frozen=True, kw_only=True)
class StubbornQP(Programmed):
    """The same from one quadratic program, without the rows of the clearances."""

    def propose(self, model, state):
        J = model.J
        P = J.T @ J + 1e-6 * identity(model.robot.n)
        low, high = model.box
        return Proposal(model.solve(QuadraticProgram(P, J.T @ model.here.residual, low, high)).x)

    def merit(self):
        return None

    def supports_clearances(self):
        return True


@pytest.mark.parametrize("strategy", [Stubborn(), StubbornQP()], ids=lambda each: type(each).__name__)
def test_strategies_without_any_shortening_move(strategy):
    ik, q, accepted = solver(strategy), Q, []
    for _ in range(25):
        step = ik.step(q, TARGET)
        accepted.append(step.accepted)
        q = step.q
    assert not accepted[0]
    assert sum(accepted) >= 3


def test_without_clearances_there_is_no_state_for_it():
    assert path_backtracking("always", False) == Backtracking(active=False, name="path_fraction")
    assert path_backtracking("merit", True).initial_state() == {}
    assert list(path_backtracking("always", True).initial_state()) == ["path_fraction"]

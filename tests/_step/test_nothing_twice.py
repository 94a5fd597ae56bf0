"""The graph of a step is written once: what the elimination of common subexpressions finds is little.

It takes most of the time of building a large step.
"""

from __future__ import annotations

import casadi
import pytest

import jtik
from jtik._step import fused_step as fused_step_module
from jtik.qp import partition
from jtik.symbolic import once_for_each
from jtik_formulations import ObstacleBarrier

from ..conftest import planar
from .conftest import problem_of

TWICE = 0.2
"""Share of the graph of a criterion that may be there twice: the kinematics of task and criterion, and a seventh for
what its value and its gradient have in common."""

OF_ROWS = 0.3
"""Share of that of clearances: parts of their Jacobian. A path that is checked twice makes it 0.6."""


def field(count):
    return [jtik.Circle((1.0 + 0.3 * i, 1.0), 0.2) for i in range(count)]


@pytest.fixture
def counts(monkeypatch):
    """Of each large function that is built: its name, its instructions, and those that it would have without cse."""
    found = []
    for module in (fused_step_module, partition):
        built = module.function

        def counted(name, inputs, outputs, *rest, built=built, **options):
            made = built(name, inputs, outputs, *rest, **options)
            if all(isinstance(each, casadi.SX) for each in outputs):
                plain = built(name, inputs, outputs, *rest, cse=False)
                found.append((name, made.n_instructions(), plain.n_instructions()))
            return made

        monkeypatch.setattr(module, "function", counted)
    return found


def test_of_a_criterion(counts):
    criterion = ObstacleBarrier(field(6), bodies="links")
    jtik.InverseKinematics(planar(6), jtik.FrameTask(), criteria=criterion)
    sizes = [(after, before) for name, after, before in counts if name == "jtik_step"]
    assert sizes
    assert all(before <= (1 + TWICE) * after for after, before in sizes), sizes


def test_of_clearances(counts):
    clearance = jtik.Clearance(ObstacleBarrier(field(6), bodies="links"))
    jtik.InverseKinematics(planar(6), jtik.FrameTask(), clearances=clearance, strategy="hybrid+qp")
    sizes = [(after, before) for name, after, before in counts if name == "joined"]
    assert sizes
    assert all(before <= (1 + OF_ROWS) * after for after, before in sizes), sizes


def test_of_the_values_and_the_distances():
    barrier = ObstacleBarrier(field(6), bodies="links")
    problem = problem_of(planar(6), criteria=barrier, clearances=[jtik.Clearance(barrier)])
    q, target, parameters = problem.symbols()
    for made in (problem.report(), problem.measured.clearance):
        inputs = [q, target, parameters] if made.n_in() == 3 else [q, parameters]
        less = casadi.Function("less", inputs, made.call(inputs), {"cse": True})
        assert made.n_instructions() <= (1 + OF_ROWS) * less.n_instructions()


def test_the_same_expression_gives_the_same_result():
    calls, x = [], casadi.SX.sym("x", 2)
    doubled = once_for_each(lambda each: calls.append(each) or 2 * each)
    first, second = doubled(x), doubled(casadi.SX(x))
    assert casadi.is_equal(first, second)
    assert len(calls) == 1
    assert casadi.is_equal(doubled(x[0]), 2 * x[0], 1)
    assert not casadi.is_equal(doubled(x + 1), first)
    assert len(calls) == 3


def test_of_a_step_at_its_velocity_limits():
    """Its parts, between which it is fitted into the limits, are together little more than the one function of others.

    What is constant, such as the gradient of no criterion, is no symbol between them: it made them 1.4 times as large.
    """
    arm = jtik.Robot.builtin("panda")
    ik = jtik.InverseKinematics(arm, jtik.FrameTask(kind="pose"), limits=jtik.Limits(velocity=1.0), compiled=False)
    parts = ik._engine.runners.timed_step[0].fused.parts
    together = sum(each.n_instructions() for each in (parts.local, *parts.stages))
    assert together <= 1.2 * parts.fast_path.n_instructions()

"""The fast path (no QP needed) and the QP path of a step: both give the same result."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import jtik
from jtik.qp import FusedBackend, QPSolversBackend
from jtik.qp.call import output_memory
from jtik.symbolic import MX, function
from jtik.symbolic.compile import bind
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import planar, planar_points, shared_solver

STRATEGIES = ["newton+qp", "hybrid+qp", "weighted_qp", "sns_qp", "lexicographic_qp"]


@functools.cache
def solver(strategy, limit, preferred):
    return shared_solver(
        planar(5, lower=-limit, upper=limit),
        jtik.FrameTask(),
        criteria=JointCentering(preferred=preferred),
        strategy=strategy,
    )


def both_paths(strategy, q, limit, preferred=None):
    """Whether a first step from q needs no QP; its outputs by the fast path, the QP path and the joined function."""
    ik = solver(strategy, limit, preferred)
    fused = ik._engine.runners.solve.fused
    parts = fused.parts
    ik._engine.memory.inputs.target[:] = planar_points(q)[-1] + 0.01  # a step that no strategy shortens
    arguments = [q.copy(), *ik._engine.memory.inputs, fused.first_state.copy()]
    outputs = output_memory(parts.fast_path)
    bind(parts.fast_path, arguments, outputs)()
    ends = parts.stages[-1].n_out()
    fast, no_qp_needed, between = outputs[:ends], outputs[ends], outputs[ends + 1 :]
    solved, joined = ([np.zeros_like(part) for part in fast] for _ in range(2))
    bind(parts.qp_path, [*arguments, *between], solved)()
    bind(fused.function, arguments, joined)()
    return bool(no_qp_needed[0]), fast, solved, joined


@pytest.mark.quick(2)
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_far_from_limits_no_qp_is_needed_and_the_paths_agree(strategy, rng):
    for _ in range(5):
        no_qp_needed, fast, solved, joined = both_paths(strategy, rng.uniform(0.2, 0.5, 5), 3.0)
        assert no_qp_needed
        assert joined[0] == pytest.approx(fast[0], abs=1e-12)
        assert solved[0] == pytest.approx(fast[0], abs=1e-7)


@pytest.mark.quick(2)
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_at_limits_the_qp_is_solved(strategy, rng):
    count = 0
    for _ in range(5):
        no_qp_needed, _, solved, joined = both_paths(
            strategy, rng.uniform(0.45, 0.5, 5), 0.5, preferred=(0.9, 0.3, 0.9, 0.2, 0.9)
        )
        if not no_qp_needed:
            count += 1
            assert joined[0] == pytest.approx(solved[0], abs=1e-12)
            assert (np.abs(solved[0]) <= 0.5 + 1e-9).all()
    assert count


def test_a_step_with_clearances_has_no_fast_path():
    """Most steps with clearances need the QP, and the fast path would cost as much as the QP path."""
    field = ObstacleAvoidance(jtik.Circle((2.0, 1.0), 0.3), bodies="links")
    ik = shared_solver(
        planar(4),
        jtik.FrameTask(),
        criteria=JointCentering(),
        strategy="newton+qp",
        clearances=jtik.Clearance(field, safe=0.1),
    )
    assert ik._engine.runners.solve.fused.parts.fast_path is None


class Failing(FusedBackend):
    """A fused back end whose solutions are NaN; the QP of the step below needs a solver, because of the limits."""

    name = "failing"
    accuracy = 1e-6

    def __init__(self, fallback=None):
        self.fallback = fallback

    def function(self, n, rows):
        sizes = [(n, n), (n, 1), (rows, n), (rows, 1), (rows, 1), (n, 1), (n, 1)]
        data = [MX.sym(f"d{i}", *size) for i, size in enumerate(sizes)]
        return function("failing", data, [np.nan * MX.ones(size, 1) for size in (n, rows, n)])


class TestFallback:
    q = np.array([0.49, 0.46, 0.5, 0.48, 0.47])

    def step(self, solver):
        ik = shared_solver(
            planar(5, lower=-0.5, upper=0.5),
            jtik.FrameTask(),
            criteria=JointCentering(preferred=(0.9, 0.3, 0.9, 0.2, 0.9)),
            strategy="newton+qp",
            solver=solver,
        )
        return ik.step(self.q, planar_points(self.q)[-1])

    def test_it_solves_what_the_back_end_does_not(self):
        expected = self.step("daqp")
        assert np.abs(expected.q - self.q).max() > 1e-3
        assert self.step(Failing(QPSolversBackend("daqp"))).q == pytest.approx(expected.q, abs=1e-7)

    def test_without_one_the_step_is_refused(self):
        step = self.step(Failing())
        assert not step.accepted
        assert step.q.tolist() == self.q.tolist()

"""A step that needs no solver is one function; one that does goes on from there, and both say the same."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.qp.call import outputs_of
from jtik.symbolic.compile import bind
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import planar, planar_points

STRATEGIES = ["newton+qp", "hybrid+qp", "weighted_qp", "sns_qp", "lexicographic_qp"]


def ways(strategy, q, limit, preferred=None):
    """Whether a first step from q needs no solver; its outputs by the short way, by the solver's, and as joined."""
    ik = jtik.InverseKinematics(
        planar(5, lower=-limit, upper=limit),
        jtik.FrameTask(),
        criteria=JointCentering(preferred=preferred),
        strategy=strategy,
    )
    fused = ik._engine.runners.plain.fused
    parts = fused.parts
    ik._engine.memory.inputs.target[:] = planar_points(q)[-1] + 0.01  # a step that no law shortens
    arguments = [q.copy(), *ik._engine.memory.inputs, fused.first_state.copy()]
    near = outputs_of(parts.near)
    bind(parts.near, arguments, near)()
    ends = parts.stages[-1].n_out()
    short, holds, between = near[:ends], near[ends], near[ends + 1 :]
    solved, joined = ([np.zeros_like(part) for part in short] for _ in range(2))
    bind(parts.far(), [*arguments, *between], solved)()
    bind(fused.function, arguments, joined)()
    return bool(holds[0]), short, solved, joined


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_in_the_freeno_solver_is_needed_and_it_would_say_the_same(strategy, rng):
    for _ in range(5):
        free, short, solved, joined = ways(strategy, rng.uniform(0.2, 0.5, 5), 3.0)
        assert free
        assert joined[0] == pytest.approx(short[0], abs=1e-12)
        assert solved[0] == pytest.approx(short[0], abs=1e-7)


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_at_limits_the_solver_is_asked(strategy, rng):
    asked = 0
    for _ in range(5):
        free, _, solved, joined = ways(
            strategy, rng.uniform(0.45, 0.5, 5), 0.5, preferred=np.array([0.9, 0.3, 0.9, 0.2, 0.9])
        )
        if not free:
            asked += 1
            assert joined[0] == pytest.approx(solved[0], abs=1e-12)
            assert (np.abs(solved[0]) <= 0.5 + 1e-9).all()
    assert asked


def test_a_step_with_clearances_has_no_short_way():
    """It would seldom be open, and it is as long as the other."""
    field = ObstacleAvoidance(jtik.Circle((2.0, 1.0), 0.3), bodies="links")
    ik = jtik.InverseKinematics(
        planar(4),
        jtik.FrameTask(),
        criteria=JointCentering(),
        strategy="newton+qp",
        clearances=jtik.Clearance(field, safe=0.1),
    )
    assert ik._engine.runners.plain.fused.parts.near is None

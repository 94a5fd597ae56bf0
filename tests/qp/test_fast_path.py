"""The fast path (no QP needed) and the QP path of a step: both give the same result."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.qp.call import output_memory
from jtik.symbolic.compile import bind
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import planar, planar_points

STRATEGIES = ["newton+qp", "hybrid+qp", "weighted_qp", "sns_qp", "lexicographic_qp"]


def both_paths(strategy, q, limit, preferred=None):
    """Whether a first step from q needs no QP; its outputs by the fast path, the QP path and the joined function."""
    ik = jtik.InverseKinematics(
        planar(5, lower=-limit, upper=limit),
        jtik.FrameTask(),
        criteria=JointCentering(preferred=preferred),
        strategy=strategy,
    )
    fused = ik._runner.fused
    parts = fused.parts
    ik._target[:] = planar_points(q)[-1] + 0.01  # a step that no strategy shortens
    arguments = [q.copy(), *ik._inputs, fused.first_state.copy()]
    outputs = output_memory(parts.fast_path)
    bind(parts.fast_path, arguments, outputs)()
    ends = parts.stages[-1].n_out()
    fast, no_qp_needed, between = outputs[:ends], outputs[ends], outputs[ends + 1 :]
    solved, joined = ([np.zeros_like(part) for part in fast] for _ in range(2))
    bind(parts.qp_path(), [*arguments, *between], solved)()
    bind(fused.function, arguments, joined)()
    return bool(no_qp_needed[0]), fast, solved, joined


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_far_from_limits_no_qp_is_needed_and_the_paths_agree(strategy, rng):
    for _ in range(5):
        no_qp_needed, fast, solved, joined = both_paths(strategy, rng.uniform(0.2, 0.5, 5), 3.0)
        assert no_qp_needed
        assert joined[0] == pytest.approx(fast[0], abs=1e-12)
        assert solved[0] == pytest.approx(fast[0], abs=1e-7)


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_at_limits_the_qp_is_solved(strategy, rng):
    count = 0
    for _ in range(5):
        no_qp_needed, _, solved, joined = both_paths(
            strategy, rng.uniform(0.45, 0.5, 5), 0.5, preferred=np.array([0.9, 0.3, 0.9, 0.2, 0.9])
        )
        if not no_qp_needed:
            count += 1
            assert joined[0] == pytest.approx(solved[0], abs=1e-12)
            assert (np.abs(solved[0]) <= 0.5 + 1e-9).all()
    assert count


def test_a_step_with_clearances_has_no_fast_path():
    """Most steps with clearances need the QP, and the fast path would cost as much as the QP path."""
    field = ObstacleAvoidance(jtik.Circle((2.0, 1.0), 0.3), bodies="links")
    ik = jtik.InverseKinematics(
        planar(4),
        jtik.FrameTask(),
        criteria=JointCentering(),
        strategy="newton+qp",
        clearances=jtik.Clearance(field, safe=0.1),
    )
    assert ik._runner.fused.parts.fast_path is None

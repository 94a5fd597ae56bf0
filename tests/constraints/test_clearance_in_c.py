"""Steps beside clearances in generated C are those of the virtual machine, also after obstacles have moved."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.symbolic import compile as compile_module
from jtik.symbolic.compile import CompilerError, compiler
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import planar, slow

try:
    compiler()
except CompilerError:
    pytest.skip("needs a C compiler", allow_module_level=True)

EQUAL = 1e-10
FEW, TARGETS = 60, 12


def solver(strategy, *, compiled):
    obstacles = [jtik.Circle((1.5, 1.5), 0.4), jtik.Circle((2.5, -1.0), 0.5), jtik.Circle((-8.0, 0.0), 0.5)]
    return jtik.InverseKinematics(
        planar(5, lower=-2.5, upper=2.5),
        jtik.FrameTask("tip", kind="position"),
        criteria=0.1 * JointCentering(),
        strategy=strategy,
        limits=jtik.Limits(velocity=2.0),
        clearances=jtik.Clearance(ObstacleAvoidance(obstacles, bodies="links"), safe=0.05),
        compiled=compiled,
    )


@pytest.mark.quick(0, slow=1)
@pytest.mark.parametrize("strategy", ["weighted_qp", *slow("hybrid+qp")])
def test_steps_and_statuses_are_those_of_the_virtual_machine(strategy, rng, monkeypatch):
    fast, other = solver(strategy, compiled=True), solver(strategy, compiled=False)
    both = fast, other
    centers = np.array(other.parameters["clearance.centers"])
    q, restored = other.robot.home, 0
    for each in both:
        each.step(q, [2.0, 1.0], dt=0.05)
    monkeypatch.setattr(compile_module, "compile_library", forbidden)
    for _ in range(TARGETS):
        moved = centers + rng.normal(size=centers.shape)
        for each in both:
            each.parameters["clearance.centers"] = moved
        target, q = rng.uniform(-4, 4, 2), rng.uniform(-2, 2, q.size)
        one, two = (each.solve(target, q0=q, max_iterations=40) for each in both)
        assert one.status is two.status
        assert np.abs(one.q - two.q).max() < 1e-7  # after up to 40 steps
        for _ in range(FEW // TARGETS):
            one, two = (each.step(q, target, dt=0.05) for each in both)
            assert np.abs(one.q - two.q).max() < EQUAL
            assert one.accepted == two.accepted
            restored += bool(np.linalg.norm(one.q - q) > 0)
            q = two.q
    assert restored > FEW / 2


def forbidden(*arguments, **options):
    """Nothing is compiled when an obstacle moves."""
    raise AssertionError("compiled again")

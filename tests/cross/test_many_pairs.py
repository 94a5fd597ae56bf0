"""Solves and steps with clearances of many pairs: with loops over them, written out, and in generated C the same."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.constraints import many_distances
from jtik.qp import rows
from jtik.symbolic.compile import CompilerError, compiler
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import dh_arm, planar

SAFE = 0.02
PROBLEMS = 12
STRATEGIES = ["weighted_qp", "lexicographic_qp", "hybrid+qp", "damped+qp"]


def solver(robot, obstacles, strategy, *, compiled=False):
    measure = ObstacleAvoidance(obstacles, bodies="links")
    return jtik.InverseKinematics(
        robot,
        jtik.FrameTask("tip", "position"),
        criteria=JointCentering(),
        clearances=jtik.Clearance(measure, safe=SAFE, influence=0.5),
        strategy=strategy,
        compiled=compiled,
    )


def with_loops(monkeypatch):
    """From here on all pairs have loops."""
    monkeypatch.setattr(rows, "LARGEST_UNROLLED", 0)
    monkeypatch.setattr(many_distances, "FEW", 0)


def written_out(monkeypatch):
    """From here on nothing has loops."""
    monkeypatch.setattr(rows, "LARGEST_UNROLLED", 10**9)
    monkeypatch.setattr(many_distances, "FEW", 10**9)


def scene(kind, rng):
    """An arm, ten obstacles around it, a start that is clear of them, and targets."""
    robot = planar(4, lower=-2.5, upper=2.5) if kind == "planar" else dh_arm(6, 1)
    d = robot.dimension
    while True:
        q0 = rng.uniform(-1.5, 1.5, robot.nq)
        centers = rng.uniform(-2.5, 2.5, (40, d))
        ends = np.array([robot.position(q0, frame)[:d] for frame in robot.moving_frames])
        near = np.linalg.norm(centers[:, None] - ends, axis=2).min(axis=1)
        clear = centers[near > 0.9][:10]
        if len(clear) == 10:
            break
    ball = jtik.Circle if d == 2 else jtik.Sphere
    obstacles = [ball(center, 0.15) for center in clear[:6]]
    obstacles += [jtik.Capsule(center, center + 0.1, 0.1) for center in clear[6:]]
    targets = [robot.position(q0 + rng.normal(size=robot.nq) * size)[:d] for size in (0.2, 0.5, 1.0)]
    return robot, obstacles, q0, targets


def compared(one, other, q0, targets):
    """How the solves of two solvers end, and by how much their first steps differ at most."""
    ends, largest = [], 0.0
    for target in targets:
        steps = [ik.step(q0, target).q for ik in (one, other)]
        largest = max(largest, np.abs(np.subtract(*steps)).max())
        for ik in (one, other):
            ik.reset()
        solutions = [ik.solve(target, q0=q0, max_iterations=60) for ik in (one, other)]
        ends.append(tuple(solution.status for solution in solutions))
    return ends, largest


@pytest.mark.quick(1)
@pytest.mark.parametrize("kind", ["planar", "spatial"])
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_loops_change_nothing(strategy, kind, rng, monkeypatch):
    ends, largest = [], 0.0
    with_loops(monkeypatch)
    robot, obstacles, *_ = scene(kind, rng)
    loops = solver(robot, obstacles, strategy)
    assert loops._engine.problem.measured.rows
    written_out(monkeypatch)
    written = solver(robot, obstacles, strategy)
    for _ in range(PROBLEMS):
        _, obstacles, q0, targets = scene(kind, rng)
        for ik in (loops, written):
            for name, value in ObstacleAvoidance(obstacles, bodies="links").parameters(robot).items():
                if name != "gain":
                    ik.parameters[f"clearance.{name}"] = value
        found, difference = compared(loops, written, q0, targets)
        ends += found
        largest = max(largest, difference)
    assert largest < 1e-6, largest  # the accuracy of the solver
    different = sum(one != other for one, other in ends)
    assert different <= 0.05 * len(ends), (different, len(ends))
    arrived = (jtik.Status.CONVERGED, jtik.Status.COMPROMISE)
    assert sum(one in arrived for one, _ in ends) > 0.2 * len(ends)


@pytest.mark.quick(0, slow=2)
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_generated_c_is_the_same(strategy, rng, monkeypatch):
    with_loops(monkeypatch)
    try:
        compiler()
    except CompilerError:
        pytest.skip("needs a C compiler")
    robot, obstacles, q0, targets = scene("planar", rng)
    c, vm = (solver(robot, obstacles, strategy, compiled=compiled) for compiled in (True, False))
    for _ in range(PROBLEMS):
        ends, largest = compared(c, vm, q0, targets)
        assert all(one == other for one, other in ends)
        assert largest < 1e-10
        q0 = q0 + rng.normal(size=robot.nq) * 0.02

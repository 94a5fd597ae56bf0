"""The transpose method with Barzilai and Borwein's gain: whole solves replayed in numpy, with and without monotony."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, TransposeBB

from ..conftest import dh_arm, planar, planar_jacobian, planar_points, rises, shared_solver


def energy(q, target):
    return np.sum((planar_points(q)[-1] - target) ** 2) / 2


def replayed(q, target, calls, *, q_limit=0.5, memory=None):
    """Iterates, one a call, refused ones too; ``memory`` is None for the monotone strategy."""
    visited, last, fraction, energies = [q], None, 1.0, []
    for _ in range(calls):
        J = planar_jacobian(q)
        r = planar_points(q)[-1] - target
        g = J.T @ r
        image = J @ g
        optimal = g @ g / (image @ image)
        alpha = optimal
        if last is not None:
            step, change = q - last[0], g - last[1]
            if step @ change > 0:
                alpha = step @ change / (change @ change)
        if memory is None:
            alpha = min(alpha, 1.9 * optimal)
        alpha = fraction * min(alpha, q_limit / np.linalg.norm(g))
        V, V_next = energy(q, target), energy(q - alpha * g, target)
        if memory is None:
            promised = V - np.sum((r - alpha * image) ** 2) / 2
            taken = V - V_next >= 1e-4 * promised > 0
        else:
            kept = [V, *energies[-memory + 1 :]] if memory > 1 else [V]
            taken = max(kept) - V_next >= 1e-4 * alpha * g @ g
        if taken:
            energies.append(V)
            last, q, fraction = (q, g), q - alpha * g, min(1, 2 * fraction)
        else:
            fraction /= 2
        visited.append(q)
    return np.array(visited)


@pytest.mark.thinned
@pytest.mark.parametrize("bend", [1.0, 1e-3, 1e-6])
@pytest.mark.parametrize("memory", [None, 1, 2, 10])
def test_the_steps_of_a_whole_solve(memory, bend, rng):
    """A short solve is compared to its end; a long one amplifies rounding, so the first steps are."""
    strategy = TransposeBB() if memory is None else TransposeBB(monotone=False, memory=memory)
    ik = shared_solver(planar(5), jtik.FrameTask("tip"), strategy=strategy)
    for _ in range(10):
        q0 = np.append(rng.uniform(-3, 3), bend * rng.uniform(-1, 1, 4))
        target = rng.uniform(-3, 3, 2)
        visited = ik.solve(target, q0=q0, max_iterations=8, trace=True).trace.q
        assert visited == pytest.approx(replayed(q0, target, len(visited) - 1, memory=memory), abs=1e-6)


def test_the_first_step_is_the_transpose_method_s(rng):
    for _ in range(5):
        q, target = rng.uniform(-1, 1, 5), rng.uniform(-3, 3, 2)
        steps = [
            shared_solver(planar(5), jtik.FrameTask("tip"), strategy=name).step(q, target).q
            for name in ("transpose", "transpose_bb")
        ]
        assert steps[1] == pytest.approx(steps[0], abs=1e-13)


def test_it_takes_a_third_of_the_transpose_method_s_steps_or_less(rng):
    counts = {}
    problems = [(rng.uniform(-1, 1, 10), planar_points(rng.uniform(-1, 1, 10))[-1]) for _ in range(20)]
    for name in ("transpose", "transpose_bb"):
        ik = shared_solver(planar(10), jtik.FrameTask("tip"), strategy=name)
        solutions = [ik.solve(target, q0=q0, max_iterations=1000) for q0, target in problems]
        counts[name] = np.median([s.iterations if s.converged else math.inf for s in solutions])
    assert counts["transpose_bb"] < counts["transpose"] / 3


def test_only_without_monotony_V_rises(rng):
    highest = {}
    problems = [(rng.uniform(-1, 1, 10), planar_points(rng.uniform(-1, 1, 10))[-1]) for _ in range(20)]
    for monotone in (True, False):
        strategy = TransposeBB(monotone=monotone)
        ik = shared_solver(planar(10), jtik.FrameTask("tip"), strategy=strategy)
        traces = [ik.solve(target, q0=q0, trace=True).trace for q0, target in problems]
        highest[monotone] = max(rises(trace).max() for trace in traces)
    assert highest[True] <= 1e-13
    assert highest[False] > 0.1


@pytest.mark.parametrize("monotone", [True, False])
def test_beside_a_criterion_and_within_limits_it_arrives(monotone, rng):
    robot = dh_arm(7, 3, limit=1.5)
    strategy = TransposeBB(monotone=monotone)
    ik = shared_solver(robot, jtik.FrameTask("tip"), criteria=JointCentering(), strategy=strategy)
    for _ in range(5):
        goal = rng.uniform(-1, 1, 7)
        solution = ik.solve(robot.pose(goal), q0=goal + rng.uniform(-0.3, 0.3, 7), until="reached", trace=True)
        assert solution.converged
        assert np.abs(solution.trace.q).max() <= 1.5


def test_exactly_straight_with_the_target_on_the_line_it_is_freed():
    """J' r is zero there, and so would be every gain times it: the engine's escape is what moves the arm."""
    ik = shared_solver(planar(4), jtik.FrameTask("tip"), strategy="transpose_bb")
    assert ik.solve([2.0, 0.0], q0=np.zeros(4), max_iterations=500).converged


@pytest.mark.parametrize(("option", "value"), [("q_limit", 0.0), ("q_limit", math.inf), ("memory", 0), ("memory", 2.5)])
def test_options_are_checked(option, value):
    with pytest.raises(jtik.ArgumentError, match=option):
        TransposeBB(**{option: value})

"""The fast path (no QP needed) and the QP path of a step: both give the same result."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import jtik
from jtik.qp import Conic, FusedBackend, QPSolversBackend, QuadraticProgram
from jtik.qp.call import output_memory
from jtik.qp.fast_path import StepPath, fast_or_qp_path
from jtik.qp.recorder import QPRecorder
from jtik.qp.staged import staged
from jtik.symbolic import MX, function, symbol, zeros
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


KNOWN, DIRECT, EVALUATED = 1.0, 2.0, 3.0
"""Results of the function below, which show where they come from."""


def step_with_a_direct_result(arguments, results):
    """(c, d) -> the result of a function: known for c > 2, direct for c > 1; then x = d, or 1 by a QP for d <= 2."""
    recorder, (c, d, e) = QPRecorder(1e-6), (symbol(name, 1) for name in "cde")
    direct = function("direct", [e], [zeros(1) + DIRECT, e > 1])
    f = recorder.evaluate("f", function("f", [e], [zeros(1) + EVALUATED]), [c], (zeros(1) + KNOWN, c > 2), direct)
    one = zeros(1) + 1
    qp = QuadraticProgram(P=2 * one, q=-4 * one, lower=-one, upper=one, closed_form=(d + zeros(1), d > 2))
    x = recorder.solve(qp).x
    inputs = [symbol(name, 1) for name in "ab"]
    parts = staged(inputs, inputs, [c, d], recorder, [f, x, recorder.solved()], Conic())
    return fast_or_qp_path(parts.joined(), parts, -5, arguments, results, [StepPath.FAST])


def test_a_function_takes_what_is_known_then_what_is_direct_and_else_evaluates(rng):
    """Whatever the steps before it have needed."""
    arguments, results = ([np.zeros(1) for _ in range(count)] for count in (2, 3))
    step = step_with_a_direct_result(arguments, results)
    sources = {2.5: KNOWN, 1.5: DIRECT, 0.5: EVALUATED}
    for c, d in zip(rng.choice([0.5, 1.5, 2.5], 200), np.repeat(rng.choice([0.5, 2.5], 20), 10), strict=True):
        arguments[0][:], arguments[1][:] = c, d
        step()
        assert results[0][0] == sources[c]
        assert results[1][0] == pytest.approx(d if d > 2 else 1.0, abs=1e-9)


@pytest.mark.parametrize("criteria", [None, JointCentering()], ids=["task", "criterion"])
@pytest.mark.parametrize(
    ("arm", "kind", "strategy"),
    [
        (4, "position", "hybrid"),
        (10, "position", "damped"),
        ("panda", "pose", "hybrid"),
        ("panda", "pose", "hybrid+qp"),
        ("ur5e", "pose", "hybrid"),
    ],
)
def test_at_limits_of_velocity_a_step_is_that_of_the_qp_path(arm, kind, strategy, criteria, rng):
    """Along motions on which joints saturate and are released again."""
    robot = planar(arm) if isinstance(arm, int) else jtik.Robot.builtin(arm)
    limits = jtik.Limits(velocity=1.0)
    tasks = jtik.FrameTask(kind=kind)
    ik = shared_solver(robot, tasks, criteria=criteria, strategy=strategy, limits=limits, compiled=False)
    runner, _ = ik._engine.runners.timed_step
    parts, saturated, released = runner.fused.parts, 0, 0
    for _ in range(3):
        q, goal = robot.random_configuration(rng), robot.random_configuration(rng)
        ik.reset()
        for k in range(30):
            between = q + 0.02 * (1 + np.sin(k)) * (goal - q)
            target = robot.position(between) if kind == "position" else robot.pose(between)
            at, state = runner.at, runner.state[runner.at].copy()
            ik.step(q, target, dt=0.01)
            expected = [np.zeros_like(each) for each in (runner.q[0], state, runner.outcome)]
            parts.bind([q, *runner.inputs, state], expected)()
            assert runner.q[1 - at] == pytest.approx(expected[0], abs=1e-9)
            assert runner.outcome[:3].tolist() == expected[2][:3].tolist()
            fastest = np.abs(expected[0] - q).max() / 0.01
            saturated += fastest > 0.999
            released += fastest < 0.9
            q = expected[0]
    assert saturated > 5
    assert released > 5


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

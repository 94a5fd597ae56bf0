"""Attempts in lanes: the rule which one wins, its independence of the width, and what is left to the other searches."""

from __future__ import annotations

import copy
import functools
import math
import os
import pickle
import signal
import threading

import numpy as np
import pytest

import jtik
from jtik._loop.lanes import lanes as all_lanes
from jtik._loop.lanes import search as lane_search
from jtik._loop.lanes import search_source
from jtik._loop.lanes.attempts_source import TOGETHER
from jtik._loop.runner import Runner
from jtik._loop.search.search import IN_LANES as PATIENCE
from jtik._loop.search.start_bank import SIZE, StartBanks
from jtik._step.fused_step import fused_step
from jtik._step.stopping import OUTCOME, Code
from jtik.robot import Joint, JointType
from jtik.symbolic.lanes import maths
from jtik.symbolic.lanes.maths import Level
from jtik_formulations import JointCentering

from ...conftest import ball_arm, dh_arm, planar, slow

ON_TARGET = 1e-6 + 1e-12
"""Tolerance of a solve, and rounding."""


@functools.cache
def solver(robot="panda", strategy="damped"):
    arm = jtik.Robot.builtin(robot)
    return jtik.InverseKinematics(arm, jtik.FrameTask(arm.tip, "pose"), strategy=strategy, compiled=True)


def poses(robot, rng, count):
    """Poses within reach, a tenth of them at a singularity or close to one."""
    made_of = np.array([robot.random_configuration(rng) for _ in range(count)])
    made_of[::20, [1, 2, 4]] = 0.0
    made_of[10::20, [1, 2, 4]] = 1e-7
    return [robot.pose(q) for q in np.clip(made_of, robot.lower, robot.upper)]


def rotation_angle(R):
    return np.linalg.norm([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2


def same(a, b):
    """Bitwise the same result of a search in lanes."""
    assert np.array_equal(a.q, b.q)
    assert (a.iterations, a.restarts, a.status) == (b.iterations, b.restarts, b.status)


@pytest.mark.thinned
@pytest.mark.parametrize("nearest", [False, True])
@pytest.mark.parametrize(("robot", "strategy"), [("panda", "damped"), ("ur5", "hybrid")])
@pytest.mark.parametrize("count", [40, *slow(2000)])
def test_every_target_is_reached_within_the_limits(robot, strategy, nearest, count, rng):
    """By the robot's own forward kinematics."""
    ik = solver(robot, strategy)
    arm, q0 = ik.robot, (ik.robot.lower + ik.robot.upper) / 2
    failed = 0
    for pose in poses(arm, rng, count):
        found = ik.solve(pose, q0=q0, restarts=100, lanes=True, nearest=nearest)
        assert found.converged == (found.status is jtik.Status.CONVERGED)
        assert (found.q >= arm.lower - 1e-9).all()
        assert (found.q <= arm.upper + 1e-9).all()
        at = arm.pose(found.q)
        if found.converged:
            assert np.linalg.norm(at[:3, 3] - pose[:3, 3]) <= ON_TARGET
            assert rotation_angle(at[:3, :3].T @ pose[:3, :3]) <= ON_TARGET
            assert found.position_error <= ON_TARGET
        failed += not found.converged
    assert failed <= count // 500


@functools.cache
def replaceable_step():
    """The runner of one attempt on CasADi's virtual machine, with memory of its own."""
    ik = copy.copy(solver())
    runners = ik._solving._runners
    fused = fused_step(runners._problem, ik.strategy.in_lanes(), replaceable=True)
    return ik, Runner(fused, runners.search_inputs, ik.robot.nq), StartBanks(runners._problem).of(0)


def test_an_interrupted_preparation_is_repeated(monkeypatch, rng):
    """Ctrl-C while the bank of another seed is drawn: the next solve has that bank, not the one before."""
    ik, other, pose = copy.copy(solver()), copy.copy(solver()), poses(solver().robot, rng, 2)[1]
    ik.solve(pose, restarts=100, lanes=True, seed=11)
    of = StartBanks.of

    def interrupted(*given):
        raise KeyboardInterrupt

    monkeypatch.setattr(StartBanks, "of", interrupted)
    with pytest.raises(KeyboardInterrupt):
        ik.solve(pose, restarts=50, lanes=True, seed=12)
    monkeypatch.setattr(StartBanks, "of", of)
    same(ik.solve(pose, restarts=50, lanes=True, seed=12), other.solve(pose, restarts=50, lanes=True, seed=12))


def by_the_rule(target, q0, restarts, nearest):
    """The rule of formulations/restarts.md, carried out one attempt after the other.

    Returns:
        Where it ends, its iterations and the restarts begun; None where no attempt arrives.
    """
    ik, runner, bank = replaceable_step()
    runner.inputs.target[:] = ik.tasks.read_target(target)
    order = np.argsort(bank.distances(runner.inputs.target), kind="stable")
    starts = [q0, *bank.configurations[order[:restarts]]]
    free, ended, number = [0] * TOGETHER, [], 0  # the rounds after which places become free
    while True:
        if number <= restarts:
            place = min(range(TOGETHER), key=lambda p: (free[p], p))
            arrived = [each for each in ended if each[1] is Code.DONE and each[0] <= free[place]]
            if not arrived:
                code, tried, _ = ik._solving._search._attempts.run(runner, starts[number], 1000, None, PATIENCE)
                begun, q = free[place], runner.q[runner.at].copy()
                free[place] += tried + (not runner.view[OUTCOME.tried])
                ended.append((free[place], code, number, begun, tried, q))
                number += 1
                continue
        arrived = sorted(each[:3] for each in ended if each[1] is Code.DONE)
        if not arrived:
            return None
        last, _, winner = arrived[0]
        if nearest and ended[0][0] >= last:
            last = ended[0][0]
            winner = 0 if ended[0][1] is Code.DONE else winner
        begun = [each for each in ended if each[3] < arrived[0][0]]
        iterations = sum(each[4] if each[0] <= last else last - each[3] for each in begun)
        return ended[winner][5], iterations, len(begun) - 1


@pytest.mark.thinned
@pytest.mark.parametrize("nearest", [False, True])
@pytest.mark.parametrize("restarts", [1, 2, 100])
def test_the_answer_is_that_of_the_rule(restarts, nearest, rng):
    ik = solver()
    q0, agreed, decided = (ik.robot.lower + ik.robot.upper) / 2, 0, 0
    targets = poses(ik.robot, rng, 40)
    for pose in targets:
        expected = by_the_rule(pose, q0, restarts, nearest)
        found = ik.solve(pose, q0=q0, restarts=restarts, lanes=True, nearest=nearest)
        if expected is None:
            assert np.array_equal(found.q, ik.solve(pose, q0=q0, restarts=restarts).q)
            agreed += 1
            continue
        q, iterations, begun = expected
        close = np.abs(found.q - q).max() < 1e-6
        agreed += close and (found.iterations, found.restarts) == (iterations, begun)
        decided += begun >= min(restarts, TOGETHER - 1)
    assert agreed >= len(targets) - 1  # rounding can end an attempt a call earlier
    assert decided > 30


def test_nearest_is_the_attempt_from_q0_where_it_arrives_and_else_the_first_arrival(monkeypatch, rng):
    """Bit by bit that of the search for several targets in double precision, whose first attempt is the same."""
    build = all_lanes.lane_library
    monkeypatch.setattr(
        all_lanes, "lane_library", lambda *of_step, **flags: build(*of_step, **{**flags, "single": False})
    )
    ik = solver.__wrapped__()
    q0, own = (ik.robot.lower + ik.robot.upper) / 2, 0
    targets = poses(ik.robot, rng, 60)
    alone = ik.solve_batch(targets, q0=q0, restarts=100, lanes=True)
    for pose, q, restarts in zip(targets, alone.q, alone.restarts, strict=True):
        first = ik.solve(pose, q0=q0, restarts=100, lanes=True)
        nearest = ik.solve(pose, q0=q0, restarts=100, lanes=True, nearest=True)
        assert np.array_equal(nearest.q, first.q if restarts else q)
        assert nearest.iterations >= first.iterations
        own += np.array_equal(first.q, q)
    assert 0 < own < (alone.restarts == 0).sum()


LEVELS = {
    "one lane": Level("", 1),
    "two lanes": Level("", 2),
    "four lanes": Level("", 4),
    "eight lanes": Level("", 8),
    "AVX2": maths.LEVELS[1],
    "AVX-512": maths.LEVELS[2],
}


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", ["one lane", "eight lanes", *slow("two lanes", "four lanes", "AVX2", "AVX-512")])
def test_a_result_does_not_depend_on_instructions_and_number_of_lanes(name, monkeypatch, rng):
    level = LEVELS[name]
    if level in maths.LEVELS and maths.LEVELS.index(level) > lane_search.highest_level():
        pytest.skip("a processor without these instructions")
    robot = jtik.Robot.builtin("panda")
    targets = poses(robot, rng, 40)

    def solutions():
        ik = jtik.InverseKinematics(robot, jtik.FrameTask("tip", "pose"), strategy="damped")
        options = [{"restarts": restarts, "nearest": nearest} for restarts in (2, 40) for nearest in (False, True)]
        return [ik.solve(pose, q0=robot.neutral, lanes=True, **each) for each in options for pose in targets]

    expected = solutions()
    assert max(each.restarts for each in expected) > TOGETHER  # some places took another attempt
    monkeypatch.setattr("jtik._loop.lanes.lanes.highest_with", lambda lanes: level)
    for one, other in zip(expected, solutions(), strict=True):
        same(one, other)


def test_wide_registers_are_not_used_where_they_would_be_half_empty():
    assert lane_search.highest_with(TOGETHER).lanes <= TOGETHER
    assert lane_search.highest_with(math.inf) == maths.LEVELS[lane_search.highest_level()]


@pytest.mark.parametrize("k", [1, 2, 3, 4, 7, 8, 40, SIZE])
def test_restarts_follow_in_the_order_of_their_distances(k, rng):
    """Where only the k-th nearest configuration is on target and attempts have one iteration, its turn comes."""
    ik = copy.copy(solver())
    robot = ik.robot
    banks = StartBanks(ik._solving._runners._problem)
    bank, answer = banks.of(0), robot.random_configuration(rng)
    pose = robot.pose(answer)
    order = bank.order(ik.tasks.read_target(pose))
    elsewhere = np.tile(robot.neutral, (SIZE, 1))
    elsewhere[order[k - 1]] = answer
    banks._latest = 0, bank._replace(configurations=elsewhere)
    ik._solving._lanes.attempts._starts = banks
    found = ik.solve(pose, q0=robot.neutral, restarts=SIZE, max_iterations=1, lanes=True)
    assert np.array_equal(found.q, answer)
    assert found.restarts == min((k // TOGETHER + 1) * TOGETHER - 1, SIZE)
    assert found.iterations == found.restarts  # all but the one that had arrived


def test_what_they_do_not_reach_ends_as_without_lanes():
    """A straight arm escapes from a saddle point; a target out of reach is diagnosed; limits of iterations hold."""
    ik = jtik.InverseKinematics(planar(4), jtik.FrameTask(kind="position"), strategy="hybrid")
    for target in ([9.0, 1.0], [4.5, 0.0]):
        one, lanes = (ik.solve(target, q0=np.zeros(4), restarts=5, lanes=each) for each in (False, True))
        assert (lanes.status, lanes.iterations, lanes.restarts) == (one.status, one.iterations, one.restarts)
        assert np.array_equal(lanes.q, one.q)
        assert lanes.status.depends_on_start
    for limit in (0, 1):
        one, lanes = (
            ik.solve([1.5, 2.5], q0=np.full(4, 0.3), restarts=1, max_iterations=limit, lanes=each)
            for each in (False, True)
        )
        assert (lanes.status, lanes.iterations) == (one.status, one.iterations)
        assert np.array_equal(lanes.q, one.q)


@pytest.mark.parametrize("q0", [[0.0] * 4, [0.3] * 4])
def test_a_singular_start_is_left_by_the_others(q0):
    """From a straight arm no attempt of `damped` leads to a target on its line; the restarts do."""
    ik = jtik.InverseKinematics(planar(4), jtik.FrameTask(kind="position"), strategy="hybrid")
    for target in ([2.0, 0.0], [0.0, 0.0], [4.0, 0.0]):
        found = ik.solve(target, q0=q0, restarts=20, lanes=True, nearest=True)
        assert found.converged
        assert np.linalg.norm(ik.robot.pose(found.q)[:2, 3] - target) <= ON_TARGET


def test_a_search_that_takes_long_goes_on_in_python(monkeypatch, rng):
    targets, q0 = rng.uniform(-3, 3, (10, 2)), np.full(4, 0.3)

    def solutions(lanes):
        ik = jtik.InverseKinematics(planar(4), jtik.FrameTask(kind="position"), strategy="hybrid")
        return [ik.solve(target, q0=q0, restarts=3, lanes=lanes) for target in targets]

    one = solutions(False)
    monkeypatch.setattr(search_source, "LONGEST", 0)
    for before, after in zip(one, solutions(True), strict=True):
        same(before, after)


@pytest.mark.parametrize("nearest", [False, True])
def test_a_signal_ends_it(nearest):
    """A target out of reach, with more restarts than can be tried."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    ik, far = solver(), np.eye(4)
    far[0, 3] = 3.0
    timer = threading.Timer(0.2, os.kill, [os.getpid(), signal.SIGINT])
    try:
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            ik.solve(far, restarts=10**9, lanes=True, nearest=nearest)
    finally:
        timer.cancel()
        signal.signal(signal.SIGINT, before)
    pose = ik.robot.pose(ik.robot.neutral)
    assert ik.solve(pose, restarts=10, lanes=True, nearest=nearest).converged


@pytest.mark.parametrize("nearest", [False, True])
def test_with_a_criterion_the_result_is_a_minimum(nearest, rng):
    ik = jtik.InverseKinematics(
        planar(5), jtik.FrameTask(kind="position"), criteria=JointCentering(), strategy="hybrid", compiled=True
    )
    for target in rng.uniform(-2, 2, (20, 2)):
        found = ik.solve(target, q0=np.full(5, 0.3), restarts=20, lanes=True, nearest=nearest)
        assert found.status is jtik.Status.CONVERGED
        assert np.linalg.norm(ik.robot.pose(found.q)[:2, 3] - target) <= ON_TARGET
        assert found.null_space_residual <= 1e-6 * max(1.0, np.linalg.norm(found.gradient))
        again = ik.solve(target, q0=found.q)
        assert again.q == pytest.approx(found.q, abs=1e-5)


def test_restarts_that_depend_on_the_start_are_drawn_about_it(rng):
    """On a rail without limits a search that begins elsewhere ends there in the same posture."""
    rail = Joint("rail", JointType.PRISMATIC, "world", "base", axis=(1, 0, 0))
    arm = jtik.Robot.planar(3, lower=-0.5, upper=2.0)
    robot = jtik.Robot([rail, *arm.joints], base="world", planar=True)
    ik = jtik.InverseKinematics(robot, jtik.FrameTask("tip", kind="pose"), strategy="damped")
    assert ik._solving._search._restarts.depend_on_start
    others = 0
    for _ in range(10):
        q = np.array([0.0, *arm.random_configuration(rng)])
        found, moved = (
            ik.solve(robot.pose(q + np.eye(4)[0] * x), q0=[x, 0.3, 0.2, 0.1], restarts=20, lanes=True)
            for x in (0.0, 8.0)
        )
        assert found.converged
        assert robot.pose(found.q) == pytest.approx(robot.pose(q), abs=3e-6)
        assert moved.q - np.eye(4)[0] * 8.0 == pytest.approx(found.q, abs=1e-5)
        assert (moved.iterations, moved.restarts) == (found.iterations, found.restarts)
        alone = ik.solve_batch([robot.pose(q)], q0=[0.0, 0.3, 0.2, 0.1], lanes=True)
        others += np.abs(alone.q[0] - found.q).max() > 1e-3
    assert others > 3  # another attempt than that from q0 has won


def test_turning_joints_are_brought_back(rng):
    robot = dh_arm(6, 1, limit=math.pi)
    ik = jtik.InverseKinematics(robot, jtik.FrameTask("tip", "pose"), strategy="damped")
    for pose in poses(robot, rng, 20):
        found = ik.solve(pose, q0=np.full(6, 3.0), restarts=100, lanes=True)
        assert found.converged
        assert (np.abs(found.q) <= math.pi).all()


def test_ball_joints(rng):
    robot = ball_arm()
    ik = jtik.InverseKinematics(robot, jtik.FrameTask(robot.tip, "pose"), strategy="damped")
    for _ in range(5):
        pose = robot.pose(robot.random_configuration(rng))
        found = ik.solve(pose, restarts=50, lanes=True)
        assert found.converged
        assert robot.pose(found.q) == pytest.approx(pose, abs=3e-6)


def test_the_same_arguments_give_the_same_solution(rng):
    ik = solver()
    for pose in poses(ik.robot, rng, 8):
        first = ik.solve(pose, restarts=20, seed=4, lanes=True)
        ik.solve(pose, restarts=20, seed=5, lanes=True, nearest=True)
        same(first, ik.solve(pose, restarts=20, seed=4, lanes=True))
        same(first, copy.copy(ik).solve(pose.tolist(), restarts=20, seed=4, lanes=True))


def test_a_solution_is_complete():
    ik = solver()
    pose = ik.robot.pose(np.array([0.3, 0.4, -0.2, -1.5, 0.1, 1.7, 0.6]))
    found = ik.solve(pose, restarts=20, lanes=True)
    assert found.trace is None
    assert found.alternatives == ()
    assert found.seconds > 0
    assert found.iterations > 0
    assert found.restarts == TOGETHER - 1
    assert "CONVERGED" in repr(found).upper()
    restored = pickle.loads(pickle.dumps(found))
    assert np.array_equal(restored.q, found.q)
    assert restored.position_error == found.position_error <= 1e-6


def test_live_numbers_are_read_where_they_are():
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(kind="position"), criteria=JointCentering())
    options = {"q0": [0.3, 0.4, 0.5], "restarts": 5, "lanes": True}
    first = ik.solve([1.5, 1.5], **options)
    ik.parameters["joint_centering.preferred"] = [1.0, -1.0, 1.0]
    moved = ik.solve([1.5, 1.5], **options)
    assert np.abs(moved.q - first.q).max() > 1e-2
    rough = ik.solve([1.5, 1.5], position_tolerance=0.05, until="reached", **options)
    assert 1e-6 < rough.position_error <= 0.05
    assert ik.solve([1.5, 1.5], **options).position_error <= 1e-6


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "lanes: given True; accepted: False; True with restarts"),
        ({"restarts": 5, "best_of": 2}, "best_of: given 2; accepted: 1 with lanes=True"),
        ({"restarts": 5, "jump_limit": 1.0}, "jump_limit: given 1.0; accepted: None with lanes=True"),
        ({"restarts": 5, "trace": True}, "trace: given True; accepted: False with lanes=True"),
        ({"restarts": 5, "trace": 3}, "trace: given 3"),
        ({"restarts": -5}, "restarts: given -5"),
        ({"restarts": 5, "nearest": 1}, "nearest: given 1"),
        ({"restarts": 5, "lanes": "yes"}, "lanes: given yes"),
        ({"restarts": 5, "lanes": False, "nearest": True}, "nearest: given True; accepted: False; True with lanes"),
        ({"restarts": 5, "q0": [math.nan] * 3}, "q0"),
        ({"restarts": 5, "q0": np.full(3, math.inf)}, "q0"),
        ({"restarts": 5, "q0": np.zeros(4)}, "q0"),
    ],
)
def test_wrong_options_say_what_is_possible(options, message):
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(kind="position"), strategy="damped")
    with pytest.raises(jtik.ArgumentError) as error:
        ik.solve([1.0, 1.0], **{"lanes": True, **options})
    assert message in str(error.value)


@pytest.mark.parametrize("target", [np.array([math.nan, 1.0]), [1.0, math.inf], [1.0]])
def test_wrong_targets_are_named(target):
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(kind="position"), strategy="damped")
    with pytest.raises(jtik.ArgumentError, match="target"):
        ik.solve(target, restarts=5, lanes=True)


def test_a_strategy_without_lanes_says_what_is_possible():
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(kind="position"), strategy="weighted_qp")
    with pytest.raises(jtik.ArgumentError, match="lanes: given True; accepted: False; True where"):
        ik.solve([1.0, 1.0], restarts=5, lanes=True)


def test_numbers_of_numpy_are_flags_and_false_is_without_lanes(rng):
    ik = solver()
    pose = ik.robot.pose(ik.robot.random_configuration(rng))
    same(ik.solve(pose, restarts=5, lanes=np.True_), ik.solve(pose, restarts=5, lanes=True))
    same(ik.solve(pose, restarts=5, lanes=np.False_), ik.solve(pose, restarts=5))

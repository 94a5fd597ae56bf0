"""The search in lanes ends as the other searches do, reproducibly, and leaves to Python what it cannot do."""

from __future__ import annotations

import functools
import os
import signal
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import jtik
from jtik._loop.lanes import search as lane_search
from jtik._loop.lanes import search_source
from jtik._loop.native import search_source as native_source
from jtik._loop.search import search as all_searches
from jtik._step.stopping import Code
from jtik.symbolic.lanes import maths
from jtik.symbolic.lanes.maths import Level
from jtik_formulations import Damped, JointCentering

from ...conftest import dh_arm, planar, slow

COLUMNS = ("q", "converged", "position_error", "orientation_error", "iterations", "escapes", "restarts")


def rotation_angle(R):
    return np.linalg.norm([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2


@functools.cache
def solver(robot="panda", kind="pose", strategy="hybrid", criteria=None, count=0):
    arm = planar(count) if count else jtik.Robot.builtin(robot)
    task = jtik.FrameTask("tip" if count else arm.tip, kind)
    return jtik.InverseKinematics(arm, task, strategy=strategy, criteria=criteria, compiled=True)


def problems(ik, rng, count):
    """Targets that can be reached, a tenth of them at a singularity or close to one, and where to begin."""
    robot = ik.robot
    made_of = np.array([robot.random_configuration(rng) for _ in range(count)])
    made_of[::20, [1, 2, 4]] = 0.0
    made_of[10::20, [1, 2, 4]] = 1e-7
    poses = np.array([robot.pose(q) for q in np.clip(made_of, robot.lower, robot.upper)])
    targets = poses[:, :2, 3].copy() if ik.tasks.tasks[0].kind == "position" else poses
    return targets, np.array([robot.random_configuration(rng) for _ in range(count)])


CASES = {
    "panda": {"strategy": "damped"},
    "ur5": {"robot": "ur5", "strategy": "hybrid"},
    "ten links, with a criterion": {"count": 10, "kind": "position", "strategy": "hybrid"},
}
COUNTS = [60, *slow(800)]


def check_answers(ik, targets, found):
    """Every answer that counts is on target and within the limits, by the robot's own forward kinematics."""
    robot = ik.robot
    assert (found.q >= robot.lower - 1e-9).all()
    assert (found.q <= robot.upper + 1e-9).all()
    for q, target, converged in zip(found.q, targets, found.converged, strict=True):
        pose = robot.pose(q)
        wanted, place = (target, 2) if target.ndim == 1 else (target[:3, 3], 3)
        if converged:
            assert np.linalg.norm(pose[:place, 3] - wanted) <= 1e-6 + 1e-12
            assert target.ndim == 1 or rotation_angle(pose[:3, :3].T @ target[:3, :3]) <= 1e-6 + 1e-12


@pytest.mark.quick(1)
@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("case", CASES)
def test_without_restarts_or_with_a_criterion_every_target_ends_as_in_the_other_searches(case, count, rng):
    criteria = JointCentering() if "criterion" in case else None
    ik = solver(**CASES[case], criteria=criteria)
    targets, q0 = problems(ik, rng, count)
    options = {"restarts": 20 if criteria else 0, "seed": 3}
    one, lanes = (ik.solve_batch(targets, q0=q0, lanes=each, **options) for each in (False, True))
    assert lanes.status == one.status
    assert np.mean(lanes.restarts == one.restarts) > 0.98  # rounding can end an attempt a call earlier
    assert np.median(np.abs(lanes.iterations - one.iterations)) == 0
    close = (lanes.restarts == one.restarts) & one.converged
    assert np.median(np.abs(lanes.q - one.q)[close].max(axis=1)) < 1e-6
    check_answers(ik, targets, lanes)
    assert lanes.converged.mean() > (0.9 if criteria else 0.4)


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("case", ["panda", "ur5"])
def test_with_restarts_every_target_is_reached_that_the_other_searches_reach(case, count, rng):
    ik = solver(**CASES[case])
    targets, q0 = problems(ik, rng, count)
    one, lanes = (ik.solve_batch(targets, q0=q0, lanes=each, restarts=100, seed=3) for each in (False, True))
    for before, status in zip(one.status, lanes.status, strict=True):
        assert status is before or status is jtik.Status.CONVERGED
    check_answers(ik, targets, lanes)
    assert lanes.converged.mean() > 0.98
    assert (lanes.restarts[~lanes.converged] == 100).all()


def test_pressed_joints_stay_within_their_limits(rng):
    """Targets of configurations on their limits: most joints of an answer are at a limit on the way."""
    ik = solver(strategy="damped")
    robot = ik.robot
    made_of = np.where(rng.random((60, 7)) < 0.4, robot.lower, robot.upper)
    inside = rng.random((60, 7)) < 0.5
    made_of[inside] = rng.uniform(robot.lower, robot.upper, (60, 7))[inside]
    targets = np.array([robot.pose(q) for q in made_of])
    found = ik.solve_batch(targets, restarts=100, lanes=True)
    assert (found.q >= robot.lower).all()
    assert (found.q <= robot.upper).all()
    check_answers(ik, targets, found)
    assert found.converged.mean() > 0.9


def same(a, b, rows=slice(None)):
    for name in COLUMNS:
        assert np.array_equal(getattr(a, name)[rows], getattr(b, name)), name


def test_a_result_depends_neither_on_what_is_beside_it_nor_on_threads_nor_on_the_order(rng):
    ik = solver(strategy="damped")
    targets, q0 = problems(ik, rng, 70)
    together = ik.solve_batch(targets, q0=q0, restarts=20, lanes=True)
    same(together, ik.solve_batch(targets, q0=q0, restarts=20, lanes=True))
    same(together, ik.solve_batch(targets, q0=q0, restarts=20, lanes=True, threads=2))
    order = rng.permutation(len(targets))
    same(together, ik.solve_batch(targets[order], q0=q0[order], restarts=20, lanes=True), order)
    for i in (0, 33):
        alone = ik.solve_batch(targets[i : i + 1], q0=q0[i : i + 1], restarts=20, lanes=True)
        same(together, alone, slice(i, i + 1))


LEVELS = {
    "one lane": Level("", 1),
    "two lanes": Level("", 2),
    "four lanes": Level("", 4),
    "AVX2": maths.LEVELS[1],
    "AVX-512": maths.LEVELS[2],
}


@pytest.mark.thinned
@pytest.mark.parametrize("kind", ["position", *slow("pose")])
@pytest.mark.parametrize("name", LEVELS)
def test_a_result_does_not_depend_on_instructions_and_number_of_lanes(name, kind, monkeypatch, rng):
    level = LEVELS[name]
    if level in maths.LEVELS and maths.LEVELS.index(level) > lane_search.highest_level():
        pytest.skip("a processor without these instructions")
    robot = dh_arm(5, 3) if kind == "position" else jtik.Robot.builtin("panda")
    poses = np.array([robot.pose(robot.random_configuration(rng)) for _ in range(40)])
    targets = poses[:, :3, 3] if kind == "position" else poses

    def batch():
        ik = jtik.InverseKinematics(robot, jtik.FrameTask("tip", kind), strategy="damped")
        return ik.solve_batch(targets, q0=np.full(robot.nq, 0.3), restarts=10, lanes=True)

    expected = batch()
    assert (expected.restarts > 0).any() == (kind == "pose")
    monkeypatch.setattr(lane_search, "LEVELS", [level] * len(maths.LEVELS))
    same(expected, batch())


def test_what_is_unusual_is_left_to_python():
    """A straight arm escapes from a saddle point; a target out of reach is diagnosed; limits of iterations hold."""
    arm = planar(4)
    ik = jtik.InverseKinematics(arm, jtik.FrameTask(kind="position"), strategy="hybrid")
    targets = np.array([[2.0, 0.0], [9.0, 1.0], [1.5, 1.5], [4.0, 0.0], [0.0, 0.0]])
    for restarts in (0, 5):
        one, lanes = (ik.solve_batch(targets, q0=np.zeros(4), restarts=restarts, lanes=each) for each in (False, True))
        assert lanes.status == one.status
        assert np.array_equal(lanes.escapes, one.escapes)
        assert lanes.q == pytest.approx(one.q, abs=1e-5)
    assert lanes.status[1] is jtik.Status.LOCAL_MINIMUM
    for limit in (0, 1, 3):
        one, lanes = (
            ik.solve_batch(targets, q0=np.full(4, 0.3), max_iterations=limit, lanes=each) for each in (False, True)
        )
        assert lanes.status == one.status
        assert np.array_equal(lanes.iterations, one.iterations)
        assert lanes.q == pytest.approx(one.q, abs=1e-9)


@pytest.mark.slow
def test_angles_of_many_turns(rng):
    """Beyond the range of the reduction sine and cosine are those of the C library."""
    arm = planar(3)
    ik = jtik.InverseKinematics(arm, jtik.FrameTask(kind="position"), strategy="damped")
    q0 = np.array([[2e5, -3e5, 1e6], [0.3, 0.4, 0.5], [9e4, -9.9e4, 1e5], [1e300, 0.1, 0.1]])
    targets = np.array([[1.5, 1.0]] * 4)
    one, lanes = (ik.solve_batch(targets, q0=q0, lanes=each) for each in (False, True))
    assert lanes.status == one.status
    assert np.array_equal(lanes.iterations[:3], one.iterations[:3])


def test_live_numbers_are_read_where_they_are():
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(kind="position"), criteria=JointCentering())
    first = ik.solve_batch([[1.5, 1.5]], q0=[0.3, 0.4, 0.5], lanes=True)
    ik.parameters["joint_centering.preferred"] = [1.0, -1.0, 1.0]
    moved = ik.solve_batch([[1.5, 1.5]], q0=[0.3, 0.4, 0.5], lanes=True)
    assert np.abs(moved.q - first.q).max() > 1e-2
    assert moved.q == pytest.approx(ik.solve_batch([[1.5, 1.5]], q0=[0.3, 0.4, 0.5]).q, abs=1e-6)


@pytest.mark.slow
def test_a_signal_ends_it(monkeypatch):
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    ik, batch = solver(strategy="damped"), lane_search.LaneSearch.batch
    calls = []

    def with_signal(*arguments):
        calls.append(0)
        if len(calls) == 2:
            threading.Timer(0.01, os.kill, [os.getpid(), signal.SIGINT]).start()
        return batch(*arguments)

    try:
        monkeypatch.setattr(lane_search.LaneSearch, "batch", with_signal)
        far = np.tile(np.eye(4), (200_000, 1, 1))
        far[:, 0, 3] = 0.6
        found = ik.solve_batch(far, lanes=True, restarts=3)
    finally:
        signal.signal(signal.SIGINT, before)
    assert not found.complete
    assert 0 < len(found) < 200_000


@pytest.mark.parametrize(("until", "kept"), [(0.0, "converged"), (1e300, "solved"), (np.inf, "all")])
def test_after_ctrl_c_python_goes_on_with_what_is_solved_only_and_not_for_long(until, kept, monkeypatch, rng):
    """Rows come converged, ended otherwise, and not reached in lanes, which a search in Python begins anew."""
    ik = solver(strategy="damped")
    targets, q0 = problems(ik, rng, 12)
    targets[::3, 0, 3] += 3.0
    of_python = []

    def interrupted(solves, count, **_):
        batch = solves[0](0, count)
        batch.tallies[1, 0] = Code.STALLED
        yield 0, batch, until
        if until < np.inf:
            raise KeyboardInterrupt

    find = all_searches.Search.find

    def counted(*arguments, **options):
        of_python.append(0)
        return find(*arguments, **options)

    monkeypatch.setattr(all_searches, "in_threads", interrupted)
    monkeypatch.setattr(all_searches.Search, "find", counted)
    found = ik.solve_batch(targets, q0=q0, restarts=20, lanes=True, threads=2)
    reached = {i for i in range(12) if i % 3}
    expected = {"converged": reached - {1}, "solved": reached, "all": {*range(12)}}
    assert {*found.indices.tolist()} == expected[kept]
    assert found.complete == (kept == "all")
    assert len(of_python) == (4 if kept == "all" else 0)


@pytest.mark.slow
def test_a_search_that_takes_long_goes_on_in_python(monkeypatch, rng):
    targets, q0 = rng.uniform(-4, 4, (30, 2)), np.full(4, 0.3)

    def batch(lanes):
        ik = jtik.InverseKinematics(planar(4), jtik.FrameTask(kind="position"), strategy="hybrid")
        return ik.solve_batch(targets, q0=q0, restarts=3, lanes=lanes)

    one = batch(False)
    monkeypatch.setattr(search_source, "LONGEST", 0)
    same(one, batch(True))
    assert 0 < one.converged.sum() < len(targets)


@pytest.mark.parametrize("restarts", [0, 20])
@pytest.mark.parametrize("strategy", ["damped", "hybrid"])
def test_no_result_depends_on_time(strategy, restarts, monkeypatch, rng):
    """A call whose time is over at once takes no more targets; those that it has are solved as ever."""
    targets, q0 = problems(solver(), rng, 60)
    targets[::9, 2, 3] += 2.0  # out of reach

    def batch():
        ik = solver.__wrapped__(strategy=strategy)
        return ik.solve_batch(targets, q0=q0, restarts=restarts, lanes=True)

    expected = batch()
    monkeypatch.setattr(native_source, "BUDGET", 0.0)
    found, reached = batch(), expected.converged
    assert found.status == expected.status
    assert reached.mean() > 0.4
    for name in COLUMNS:  # what is not reached is left to the search without lanes
        assert np.array_equal(getattr(found, name)[reached], getattr(expected, name)[reached]), name


@pytest.mark.parametrize("options", [{"strategy": "weighted_qp"}, {"strategy": "hybrid+qp", "criteria": "centering"}])
def test_a_strategy_without_lanes_says_what_is_possible(options):
    options = {**options, **({"criteria": JointCentering()} if "criteria" in options else {})}
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(kind="position"), **options)
    with pytest.raises(jtik.ArgumentError, match="lanes: given True; accepted: False; True where"):
        ik.solve_batch([[1.0, 1.0]], lanes=True)
    assert ik.solve_batch([[1.0, 1.0]]).converged is not None


def test_targets_are_checked():
    ik = solver(strategy="damped")
    poses = np.array([np.eye(4)] * 3)
    poses[1, 0, 3] = np.nan
    with pytest.raises(jtik.ArgumentError, match=r"targets\[1\]"):
        ik.solve_batch(poses, lanes=True)
    with pytest.raises(jtik.ArgumentError, match="q0"):
        ik.solve_batch(poses[:1], q0=np.full((1, 7), np.inf), lanes=True)


def test_damped_without_backtracking_too(rng):
    ik = solver(strategy=Damped(backtracking=False))
    targets, q0 = problems(ik, rng, 40)
    one, lanes = (ik.solve_batch(targets, q0=q0, restarts=20, lanes=each) for each in (False, True))
    assert lanes.status == one.status


def test_an_executor_solves_in_lanes_too(rng):
    ik = jtik.InverseKinematics(planar(4), jtik.FrameTask(kind="position"), strategy="damped")
    targets, q0 = rng.uniform(-2, 2, (30, 2)), np.full(4, 0.3)
    with ThreadPoolExecutor(1) as pool:
        spread = ik.solve_batch(targets, q0=q0, lanes=True, executor=pool, block=7)
    same(spread, ik.solve_batch(targets, q0=q0, lanes=True))

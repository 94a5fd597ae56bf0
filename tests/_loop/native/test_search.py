"""The search in C gives the result of the search in Python to the last bit, and falls back to it where needed."""

from __future__ import annotations

import threading

import numpy as np
import pytest

import jtik
from jtik._loop.native import search as native_search
from jtik._loop.native import search_source as native_source
from jtik_formulations import Damped, JointCentering

from ...conftest import dh_arm, planar, shared_solver

ARM = dh_arm(7, 3, limit=1.5)


def pair(robot=ARM, kind="pose", strategy="damped", build=shared_solver, **options):
    """Two solvers with the same compiled step, one of them without its search in C."""
    native, plain = (
        build(robot, jtik.FrameTask("tip", kind), strategy=strategy, compiled=True, **options) for _ in range(2)
    )
    assert native._engine.search.native is not None
    plain._engine.search.native = None
    plain._solving.adopted()
    return native, plain


def same(a, b):
    assert np.array_equal(a.q, b.q)
    for name in ("status", "converged", "iterations", "escapes", "restarts", "position_error", "orientation_error"):
        assert getattr(a, name) == getattr(b, name)


@pytest.mark.thinned
@pytest.mark.parametrize("strategy", ["damped", "hybrid", Damped(backtracking=False)], ids=str)
@pytest.mark.parametrize("restarts", [0, 3, 100])
def test_every_target_ends_the_same(strategy, restarts, rng):
    native, plain = pair(strategy=strategy)
    for _ in range(40):
        target, q0 = ARM.pose(ARM.random_configuration(rng)), ARM.random_configuration(rng)
        options = {"q0": q0, "restarts": restarts, "seed": 4, "max_iterations": 300}
        same(native.solve(target, **options), plain.solve(target, **options))


def test_a_call_whose_time_is_over_leaves_no_attempt_out(rng, monkeypatch):
    monkeypatch.setattr(native_source, "BUDGET", 0.0)
    native, plain = pair(strategy="hybrid", build=jtik.InverseKinematics)
    for _ in range(20):
        target, q0 = ARM.pose(ARM.random_configuration(rng)), ARM.random_configuration(rng)
        options = {"q0": q0, "restarts": 20, "seed": 4, "max_iterations": 300}
        same(native.solve(target, **options), plain.solve(target, **options))


@pytest.mark.parametrize("restarts", [1, 3, 300])
def test_a_target_whose_V_is_infinite_ends_the_same(restarts):
    native, plain = pair(ARM)
    target = np.eye(4)
    target[0, 3] = 1e200
    found = native.solve(target, restarts=restarts)
    same(found, plain.solve(target, restarts=restarts))
    assert found.status is jtik.Status.NOT_FINITE


def test_with_a_criterion_too(rng):
    native, plain = pair(criteria=JointCentering(), strategy="hybrid")
    for _ in range(10):
        target = ARM.pose(ARM.random_configuration(rng))
        same(native.solve(target, restarts=20), plain.solve(target, restarts=20))


def test_a_saddle_escape_falls_back_to_the_search_in_python():
    native, plain = pair(planar(4), "position", "hybrid")
    for restarts in (0, 5):
        solution = native.solve([2.0, 0.0], q0=np.zeros(4), restarts=restarts)
        assert (solution.converged, solution.escapes) == (True, 1)
        same(solution, plain.solve([2.0, 0.0], q0=np.zeros(4), restarts=restarts))


def test_out_of_reach_falls_back_to_the_search_in_python():
    native, plain = pair(planar(4), "position", "hybrid")
    for restarts in (0, 5):
        solution = native.solve([9.0, 1.0], q0=np.full(4, 0.3), restarts=restarts)
        assert solution.status is jtik.Status.LOCAL_MINIMUM
        same(solution, plain.solve([9.0, 1.0], q0=np.full(4, 0.3), restarts=restarts))


def test_limits_of_iterations_hold():
    native, plain = pair()
    target = ARM.pose(np.full(7, 0.8))
    for limit in (0, 1, 2, 5):
        options = {"q0": np.full(7, -0.5), "max_iterations": limit}
        same(native.solve(target, **options), plain.solve(target, **options))
        same(native.solve(target, restarts=2, **options), plain.solve(target, restarts=2, **options))


def test_patience_is_one_attempts_own():
    """After a search with restarts a solve without any is as patient as that of a new solver."""
    native, plain = pair()
    start, far = np.full(7, -0.5), ARM.pose(np.full(7, 2.8))
    native.solve(ARM.pose(np.full(7, 0.8)), restarts=30)
    plain.solve(ARM.pose(np.full(7, 0.8)), restarts=30)
    fresh = pair()[0].solve(far, q0=start)
    assert fresh.iterations > 10
    same(native.solve(far, q0=start), fresh)
    same(plain.solve(far, q0=start), fresh)


def test_live_numbers_are_read_where_they_are():
    native, _ = pair(planar(3), "position", "hybrid", criteria=JointCentering())
    target, q0 = [1.5, 1.5], [0.3, 0.4, 0.5]
    first = native.solve(target, q0=q0)
    native.parameters["joint_centering.preferred"] = [1.0, -1.0, 1.0]
    moved = native.solve(target, q0=q0)
    assert np.abs(moved.q - first.q).max() > 1e-2
    assert first.cost != moved.cost
    assert native.solve(target, q0=q0, position_tolerance=1e-3).iterations <= moved.iterations


@pytest.mark.parametrize("each", [False, True], ids=["one start", "a start each"])
def test_a_batch_in_one_call_is_the_same_as_solving_one_by_one(each, rng):
    native, plain = pair()
    targets = [ARM.pose(ARM.random_configuration(rng)) for _ in range(20)]
    lost = np.eye(4)
    lost[:3, 3] = 50.0
    targets.insert(7, lost)  # left to the search in Python
    starts = np.array([ARM.random_configuration(rng) for _ in targets])
    batch = native.solve_batch(targets, q0=starts if each else starts[0], restarts=10)
    for i, target in enumerate(targets):
        same(batch[i], plain.solve(target, q0=starts[i if each else 0], restarts=10))
    assert batch.position_error == pytest.approx([s.position_error for s in batch], abs=1e-14)
    assert (batch.seconds > 0).all()
    watched = native.solve_batch(targets, q0=starts if each else starts[0], restarts=10, progress=lambda *_: None)
    assert np.array_equal(watched.q, batch.q)


def test_it_starts_from_home_by_default():
    robot = planar(3, lower=0.0, upper=2.0)
    native, plain = pair(robot, kind="position")
    for _ in range(2):  # from the second solve on, options are not read again
        same(native.solve([0.5, 1.5]), plain.solve([0.5, 1.5], q0=[1.0, 1.0, 1.0]))
    same(native.solve_batch([[0.5, 1.5]])[0], plain.solve([0.5, 1.5], q0=[1.0, 1.0, 1.0]))


def test_a_second_solve_with_the_same_options_is_the_same(rng):
    """From the second solve with the same options on, arguments that cannot have changed are not checked again."""
    native, plain = pair(strategy=Damped(backtracking=False))
    first = ARM.pose(ARM.random_configuration(rng))
    for options in ({"restarts": 20}, {"restarts": 0}, {"restarts": 20, "position_tolerance": 1e-3}):
        native.solve(first, **options)
        for _ in range(15):
            target, q0 = ARM.pose(ARM.random_configuration(rng)), ARM.random_configuration(rng)
            same(native.solve(target, q0=q0, **options), plain.solve(target, q0=q0, **options))
            same(native.solve(target, **options), plain.solve(target, **options))
            traced = native.solve(target, q0=q0, trace=True, **options)
            assert traced.trace is not None
    with pytest.raises(jtik.ArgumentError, match=r"q0.*nan"):
        native.solve(first, q0=np.full(7, np.nan), **options)
    with pytest.raises(jtik.ArgumentError, match="q0"):
        native.solve(first, q0=np.zeros(6), **options)
    with pytest.raises(jtik.ArgumentError, match="target"):
        native.solve(np.eye(3), **options)
    kept = native.solve(first, **options)
    native.solve(ARM.pose(np.zeros(7)), **options)
    assert kept.position_error <= 1e-3  # its own target's


THREADS_OF = {
    "damped, restarts": (ARM, {"strategy": "damped"}, {"restarts": 10}),
    "quadratic programs": (
        dh_arm(4, 3, limit=1.5),
        {"kind": "position", "strategy": "hybrid+qp", "criteria": JointCentering()},
        {"max_iterations": 200},
    ),
}


@pytest.mark.quick(1)
@pytest.mark.parametrize("case", THREADS_OF)
def test_threads_change_nothing(case, rng):
    arm, solver, options = THREADS_OF[case]
    native, _ = pair(arm, **solver)
    poses = np.array([arm.pose(arm.random_configuration(rng)) for _ in range(100)])
    poses[40, :3, 3] = 50.0  # left to the search in Python
    targets = poses[:, :3, 3] if "kind" in solver else poses
    starts = np.array([arm.random_configuration(rng) for _ in targets])
    alone = native.solve_batch(targets, q0=starts, **options)
    for threads in (2, 3, 1000):
        spread = native.solve_batch(targets, q0=starts, threads=threads, **options)
        for name in ("q", "converged", "position_error", "orientation_error", "iterations", "restarts", "targets"):
            assert np.array_equal(getattr(spread, name), getattr(alone, name)), name
        assert spread.status == alone.status
        assert spread.complete
    reached = np.array([arm.pose(q) for q in spread.q])[spread.converged]
    found = reached[:, :3, 3] if "kind" in solver else reached
    assert found == pytest.approx(targets[spread.converged], abs=1e-6)
    assert 0 < spread.converged.sum() < len(targets)


def test_threads_run_at_the_same_time():
    """Each waits within its call of C until the other is within its own."""
    native, _ = pair()
    targets = np.array([ARM.pose(np.full(7, 0.8))] * 64)
    both, search = threading.Barrier(2, timeout=60), native_search.NativeSearch.batch
    waited = set()

    def batch(self, *arguments):
        if threading.get_ident() not in waited:
            waited.add(threading.get_ident())
            both.wait()
        return search(self, *arguments)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(native_search.NativeSearch, "batch", batch)
        assert native.solve_batch(targets, threads=2).converged.all()
    assert len(waited) == 2


def test_an_error_in_a_thread_is_raised(monkeypatch):
    native, _ = pair()

    def fails(*_):
        raise MemoryError("no more")

    monkeypatch.setattr(native_search.NativeSearch, "batch", fails)
    with pytest.raises(MemoryError, match="no more"):
        native.solve_batch([ARM.pose(np.full(7, 0.8))] * 64, threads=2)

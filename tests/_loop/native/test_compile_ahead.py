"""``compiled="auto"``: the virtual machine answers at once, generated C takes over, and nothing else changes."""

from __future__ import annotations

import copy
import gc
import logging
import os
import pickle
import subprocess
import sys
import time
import weakref

import numpy as np
import pytest

import jtik
from jtik._loop.native import compile_ahead
from jtik.symbolic.compilation import c_compiler
from jtik.symbolic.compile import CompilerError, compiler
from jtik_formulations import JointCentering

from ...conftest import EXACT, dh_arm, planar, slow

try:
    compiler()
except CompilerError:
    pytest.skip("needs a C compiler", allow_module_level=True)

PATIENCE = 60.0
"""Longest time that a compilation may take here [s]."""


def wait_for_compilers():
    """Wait until nothing is compiled any more: no compiler of one test runs beside the next."""
    done = []
    compile_ahead._jobs.put(lambda: done.append(True))
    when(lambda: done or not compile_ahead._worker)


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    wait_for_compilers()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("JTIK_COMPILED", "auto")
    monkeypatch.setattr(c_compiler, "OPTIONS", ("-O0",))  # which compiles faster
    yield tmp_path / "jtik"
    wait_for_compilers()


@pytest.fixture(autouse=True)
def untold():
    compile_ahead._reported.clear()


@pytest.fixture
def eager(monkeypatch):
    """A step pays for its compilation at its first call."""
    monkeypatch.setattr(compile_ahead, "PAYS", 0.0)


def solver(*, compiled="auto", strategy="hybrid", **options):
    arm = dh_arm(4, limit=2.0)
    return jtik.InverseKinematics(
        arm, jtik.FrameTask("tip", kind="position"), strategy=strategy, compiled=compiled, **options
    )


def targets(count, seed=0):
    arm, rng = dh_arm(4, limit=2.0), np.random.default_rng(seed)
    return [arm.position(rng.uniform(-2, 2, arm.n), "tip") for _ in range(count)]


def when(ready):
    """Wait until ``ready()``."""
    end = time.monotonic() + PATIENCE
    while not ready():
        assert time.monotonic() < end
        time.sleep(0.01)


def compiled_by(ik, call):
    """Repeat a call until the step of ``solve`` runs in C; its results."""
    results = []

    def ready():
        results.append(call())
        return ik._engine.search.native is not None

    when(ready)
    return results


def test_a_solver_that_is_used_for_a_moment_compiles_nothing(cache):
    ik = solver()
    for T in targets(5):
        ik.solve(T, q0=ik.robot.neutral)
    assert not ik._engine._ahead.waiting
    assert not cache.exists()


@pytest.mark.parametrize("strategy", ["hybrid", *slow("weighted_qp")])
def test_solves_are_the_same_before_and_after(eager, strategy):
    options = {"strategy": strategy, "criteria": 0.1 * JointCentering()}
    ik, other = solver(**options), solver(compiled=False, **options)
    goals = targets(10)

    def solved(which):
        return [which.solve(T, q0=which.robot.neutral, restarts=2, seed=1) for T in goals]

    expected = solved(other)
    rounds = compiled_by(ik, lambda: solved(ik))
    rounds.append(solved(ik))
    assert len(rounds) > 2
    for found in rounds:
        for one, two in zip(found, expected, strict=True):
            assert one.status is two.status
            assert one.iterations == two.iterations
            assert np.abs(one.q - two.q).max() < EXACT


@pytest.mark.parametrize("dt", [None, *slow(0.02)])
def test_steps_are_the_same_before_and_after(eager, dt):
    ik, other = solver(), solver(compiled=False)
    goal, q = targets(1)[0], ik.robot.neutral
    ahead, fused = ik._engine._ahead, None
    for k in range(100_000):
        one, two = ik.step(q, goal, dt=dt), other.step(q, goal, dt=dt)
        assert np.abs(one.q - two.q).max() < EXACT
        q = one.q if k % 50 else ik.robot.neutral + 0.1 * np.sin(k)
        if k and not ahead.waiting:
            runners = ik._engine.runners
            fused = (runners.step if dt is None else runners.timed_step[0]).fused
            break
        time.sleep(0.001)
    assert fused is not None
    assert fused.library is not None
    assert ik._stepping.call != ik._stepping._step_ahead  # nothing is left on the way of a step
    for _ in range(20):
        one, two = ik.step(q, goal, dt=dt), other.step(q, goal, dt=dt)
        assert np.abs(one.q - two.q).max() < EXACT
        q = one.q


@pytest.mark.slow
def test_a_batch_changes_over_on_its_way(monkeypatch):
    goals = targets(40) * 50
    expected = solver(compiled=False).solve_batch(goals[:40], q0=np.zeros(4))
    ik, rows = solver(), []

    def waited(done, total):
        if len(rows) == 30:  # the rest in C, so that the batch does not depend on the speed of the compiler
            when(lambda: not ik._engine._ahead._ready.empty())
        rows.append((done, total))

    ik.warm_up()
    batch = ik.solve_batch(goals, q0=np.zeros(4), progress=waited)
    assert ik._engine.search.native is not None
    assert np.abs(batch.q - np.tile(expected.q, (50, 1))).max() < EXACT
    assert batch.status[:40] == expected.status


@pytest.mark.slow
def test_a_path_changes_over_between_two_paths(eager):
    ik, other = solver(), solver(compiled=False)
    q0, arm = ik.robot.neutral + 0.3, ik.robot
    path = [arm.position(q0 + 0.002 * k, "tip") for k in range(40)]
    expected = other.track(path, q0=q0)
    first = ik.track(path, q0=q0)
    when(lambda: ik._engine._ahead._ready.qsize() == ik._engine._ahead.waiting)
    second = ik.track(path, q0=q0)
    assert ik._engine.runners.track.fused.library is not None
    assert np.abs(first.q - expected.q).max() < EXACT
    assert np.abs(second.q - expected.q).max() < EXACT


@pytest.mark.slow
def test_warm_up_begins(cache):
    ik = solver()
    ik.warm_up()
    assert ik._engine._ahead.waiting
    when(lambda: ik._engine._ahead._ready.qsize() == ik._engine._ahead.waiting)
    assert list(cache.glob("*.so"))


@pytest.mark.slow
def test_a_copy_has_its_own(eager):
    ik = solver()
    goal = targets(1)[0]
    compiled_by(ik, lambda: ik.solve(goal, q0=ik.robot.neutral))
    twin = copy.copy(ik)
    expected = ik.solve(goal, q0=ik.robot.neutral)
    for found in compiled_by(twin, lambda: twin.solve(goal, q0=ik.robot.neutral)):
        assert found.q.tolist() == expected.q.tolist()
    assert pickle.loads(pickle.dumps(ik)).solve(goal, q0=ik.robot.neutral).status is expected.status


def test_without_a_compiler_it_goes_on_as_it_was(eager, monkeypatch, caplog):
    monkeypatch.setenv("CC", "/nowhere/to/be/found")
    ik, goal = solver(), targets(1)[0]
    expected = solver(compiled=False).solve(goal, q0=ik.robot.neutral)
    ik.solve(goal, q0=ik.robot.neutral)
    when(lambda: ik._engine._ahead._ready.qsize() == ik._engine._ahead.waiting)
    for _ in range(3):
        assert ik.solve(goal, q0=ik.robot.neutral).q.tolist() == expected.q.tolist()
    assert not ik._engine._ahead.waiting
    assert "/nowhere/to/be/found" in caplog.text


def test_no_compiler_at_all_is_told_once(eager, monkeypatch, tmp_path, caplog):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr("jtik.symbolic.compilation.c_compiler.importlib.util.find_spec", lambda name: None)
    compile_ahead._has_compiler.cache_clear()
    try:
        with caplog.at_level(logging.INFO):
            for _ in range(2):
                ik, goal = solver(), targets(1)[0]
                for _ in range(3):
                    ik.solve(goal, q0=ik.robot.neutral)
                    ik.step(ik.robot.neutral, goal)
                when(lambda ik=ik: ik._engine._ahead._ready.qsize() == ik._engine._ahead.waiting)
                ik.step(ik.robot.neutral, goal)
                assert ik._stepping.call != ik._stepping._step_ahead
    finally:
        compile_ahead._has_compiler.cache_clear()
    told = [record for record in caplog.records if "no C compiler" in record.getMessage()]
    assert [record.levelno for record in told] == [logging.INFO]


def test_a_compiler_that_is_no_command_is_a_warning(eager, monkeypatch, caplog):
    monkeypatch.setenv("CC", "gcc 'unfinished")
    compile_ahead._has_compiler.cache_clear()
    try:
        ik, goal = solver(), targets(1)[0]
        ik.solve(goal, q0=ik.robot.neutral)
        when(lambda: not ik._engine._ahead._ready.empty())
        assert ik.solve(goal, q0=ik.robot.neutral).converged
    finally:
        compile_ahead._has_compiler.cache_clear()
    assert [record.levelno for record in caplog.records] == [logging.WARNING]


def test_a_solver_that_is_gone_is_not_compiled():
    ik = solver()
    steps = weakref.ref(ik._engine.runners)
    del ik
    gc.collect()
    assert steps() is None
    ready = compile_ahead.queue.SimpleQueue()
    compile_ahead._begin(steps, "solve", ready)
    done = []
    compile_ahead._jobs.put(lambda: done.append(True))
    when(lambda: done)
    assert ready.empty()


def test_what_only_python_computes_stays_there(eager):
    @jtik.criterion(numeric=True)
    def lean(q):
        return float(q[0] ** 2)

    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask("tip"), criteria=lean, compiled="auto")
    assert ik.solve([1.0, 1.0], q0=[0.1, 0.2, 0.3]).converged
    assert not ik._engine._ahead.waiting
    with pytest.raises(jtik.ArgumentError, match="numeric criterion"):
        jtik.InverseKinematics(planar(3), jtik.FrameTask("tip"), criteria=lean, compiled=True)


def test_it_can_be_turned_off_from_outside(eager, cache, monkeypatch):
    monkeypatch.setenv("JTIK_COMPILED", "off")
    ik = solver()
    ik.warm_up()
    ik.solve(targets(1)[0], q0=ik.robot.neutral)
    assert not ik._engine._ahead.waiting
    monkeypatch.setenv("JTIK_COMPILED", "perhaps")
    with pytest.raises(jtik.ArgumentError, match="JTIK_COMPILED.*'perhaps'.*'auto' or 'off'"):
        solver()


@pytest.mark.parametrize("wrong", ["yes", "Auto", 1, None, 0.5, [True]])
def test_what_compiled_may_be(wrong):
    with pytest.raises(jtik.ArgumentError, match="compiled.*'auto'"):
        solver(compiled=wrong)


def test_an_error_that_is_no_compilers_ends_neither_the_thread_nor_the_solver(eager, monkeypatch, caplog):
    def broken(*_):
        raise OSError("no room for a folder")

    goal = targets(1)[0]
    with monkeypatch.context() as patch:
        patch.setattr("jtik._loop.runners.Runners.in_c", broken)
        ik = solver()
        expected = ik.solve(goal, q0=ik.robot.neutral)
        when(lambda: not ik._engine._ahead._ready.empty())
        assert ik.solve(goal, q0=ik.robot.neutral).q.tolist() == expected.q.tolist()
        assert not ik._engine._ahead.waiting
    assert "no room for a folder" in caplog.text
    compiled_by(other := solver(), lambda: other.solve(goal, q0=ik.robot.neutral))


def test_the_same_reason_is_one_warning(eager, monkeypatch, caplog):
    monkeypatch.setenv("CC", "/nowhere/to/be/found")
    goal = targets(1)[0]
    for ik in (solver(), solver()):
        ik.step(ik.robot.neutral, goal, dt=0.01)
        ik.solve(goal, q0=ik.robot.neutral)
        when(lambda ik=ik: ik._engine._ahead._ready.qsize() == ik._engine._ahead.waiting)
    assert [record.levelno for record in caplog.records] == [logging.WARNING]


def test_a_timed_step_that_begins_after_the_other_has_settled_is_compiled_too(eager):
    ik, goal = solver(), targets(1)[0]
    q = ik.robot.neutral

    def settled():
        ik.step(q, goal)
        return ik._stepping.call != ik._stepping._step_ahead

    when(settled)

    def in_c():
        ik.step(q, goal, dt=0.01)
        return ik._engine.runners.timed_step[0].fused.library is not None

    when(in_c)
    ik.step(q, goal, dt=0.01)
    assert ik._stepping.call != ik._stepping._step_ahead


def test_a_step_that_has_changed_over_beside_one_that_has_not(eager):
    """Steps with and without a duration take turns: each is made from its own q."""
    ik, other, goal = solver(), solver(compiled=False), targets(1)[0]
    for each in (ik, other):
        each.step(each.robot.neutral, goal)
        each.step(each.robot.neutral, goal, dt=0.02)
    ik._engine._ahead.begin()
    when(lambda: ik._engine._ahead._ready.qsize() == 2)
    name, fused = ik._engine._ahead._ready.get()  # the other one is not ready yet
    ik._engine._ahead._steps.adopt(name, fused)
    ik._stepping.adopted()
    ik._engine._ahead._ready.get()
    assert ik._stepping._untimed[2] is not None
    assert ik._stepping._timed[2] is None
    rng = np.random.default_rng(0)
    for _ in range(10):
        for dt in (None, 0.02):
            q = rng.uniform(-1, 1, ik.robot.n)
            one, two = ik.step(q, goal, dt=dt), other.step(q, goal, dt=dt)
            assert np.abs(one.q - two.q).max() < EXACT
    assert ik._stepping.call == ik._stepping._step_ahead


@pytest.mark.slow
def test_the_exploring_step_is_compiled_once_it_is_needed(eager):
    ik, other = solver(), solver(compiled=False)
    q, far = ik.robot.neutral, np.diag([1.0, 1, 1, 1])
    far[0, 3] = 50.0
    compiled_by(ik, lambda: ik.solve(targets(1)[0], q0=q))
    expected = other.solve(far, q0=q)

    def in_c():
        found = ik.solve(far, q0=q)
        assert (found.status, found.iterations) == (expected.status, expected.iterations)
        assert np.abs(found.q - expected.q).max() < EXACT
        return ik._engine.runners.exploring.fused.library is not None

    when(in_c)
    assert in_c()


def test_a_solve_is_prepared_where_a_step_has_changed_over(eager):
    ik, goal = solver(), targets(1)[0]
    q = ik.robot.neutral
    ik.solve(goal, q0=q)
    compiled_by(ik, lambda: ik.step(q, goal))
    ik.solve(goal, q0=q)
    assert ik._solving._checked._prepared


PROGRAM = """
import jtik, sys
from jtik._loop.native import compile_ahead
compile_ahead.PAYS = 0.0
ik = jtik.InverseKinematics(jtik.Robot.planar(3), jtik.FrameTask("tip"), compiled="auto")
ik.solve([1.0, 2.0], q0=[0.1] * 3)
if sys.argv[1] != "0":
    import time; time.sleep(float(sys.argv[1]))
print("end")
"""


@pytest.mark.parametrize("delay", ["0.02", *slow("0", "0.1")])
def test_a_process_that_ends_meanwhile_ends_well(delay):
    begin = time.monotonic()
    run = subprocess.run([sys.executable, "-c", PROGRAM, delay], capture_output=True, text=True, env={**os.environ})
    assert (run.returncode, run.stdout.strip(), run.stderr) == (0, "end", "")
    assert time.monotonic() - begin < PATIENCE


FORK = """
import jtik, os, sys, time
from jtik._loop.native import compile_ahead
compile_ahead.PAYS = 0.0
ik = jtik.InverseKinematics(jtik.Robot.planar(3), jtik.FrameTask("tip"), strategy="weighted_qp", compiled="auto")

def compiled(what):
    end = time.monotonic() + 60
    while ik._engine.search.native is None and time.monotonic() < end:
        ik.solve([1.0, 2.0], q0=[0.1] * 3)
        time.sleep(0.01)
    print(what, ik._engine.search.native is not None, flush=True)

ik.solve([1.0, 2.0], q0=[0.1] * 3)
time.sleep(float(sys.argv[1]))
child = os.fork()
if not child:
    compiled("child")
    sys.exit()  # with all that a process does at its end
os.waitpid(child, 0)
compiled("parent")
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
@pytest.mark.parametrize("delay", ["0", *slow("0.05", "0.3")])
def test_a_fork_compiles_by_itself_and_leaves_what_its_parent_compiles(delay):
    run = subprocess.run([sys.executable, "-c", FORK, delay], capture_output=True, text=True, env={**os.environ})
    assert (run.returncode, run.stdout.split(), run.stderr) == (0, ["child", "True", "parent", "True"], "")


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="the compiler is a shell script")
def test_a_compiler_that_does_not_tell_its_version_ends_with_the_process(tmp_path):
    hanging, pid = tmp_path / "cc", tmp_path / "pid"
    hanging.write_text(f"#!/bin/sh\necho $$ > {pid}\nexec sleep 100\n")
    hanging.chmod(0o700)
    run = subprocess.run(
        [sys.executable, "-c", PROGRAM.replace('print("end")', ""), "2"],
        env={**os.environ, "CC": str(hanging)},
        timeout=PATIENCE,
        check=True,
    )
    assert run.returncode == 0
    with pytest.raises(ProcessLookupError):
        os.kill(int(pid.read_text()), 0)

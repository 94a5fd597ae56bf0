"""The call of the native step: which calls stay in C, what they hold and return, and who refuses them."""

from __future__ import annotations

import copy
import functools
import gc
import pickle
import shutil
import sys
import time
import weakref

import numpy as np
import pytest

import jtik
from jtik._loop.native import object_layout
from jtik.result.step import Step
from jtik.symbolic.compile import CompilerError, compiler

from ...conftest import planar
from .conftest import python_calls

try:
    compiler()
except CompilerError:
    pytest.skip("needs a C compiler", allow_module_level=True)

Q, GOAL = np.array([0.4, 0.5, 0.3]), np.array([1.6, 1.4])
DT = 0.01
STEPS = 2000


@functools.cache
def made(compiled=True):
    ik = jtik.InverseKinematics(planar(3), jtik.FrameTask("tip"), strategy="damped", compiled=compiled)
    ik.warm_up()
    return ik


@pytest.fixture
def ik():
    return copy.copy(made())


@pytest.mark.parametrize("dt", [None, DT])
def test_a_usual_call_is_one_call_of_c(ik, dt):
    ik.step(Q, GOAL, dt=dt)
    assert not python_calls(lambda: ik.step(Q, GOAL, dt=dt))
    assert not python_calls(lambda: ik.step(Q, GOAL, dt=dt and float(repr(dt))))  # another object, the same number
    assert python_calls(lambda: ik.step(Q.tolist(), GOAL, dt=dt))
    assert python_calls(lambda: ik.step(Q, GOAL, dt=2 * DT))
    assert python_calls(lambda: ik.step(Q, GOAL, dt=np.float64(2 * DT)))


def test_steps_with_and_without_a_duration_take_turns(ik):
    other = copy.copy(made(compiled=False))
    for dt in (1.0, None, DT, 1.0, None, 2 * DT, DT, 1.0):  # 1.0 first: no duration is known before
        one, two = (each.step(Q, GOAL, dt=dt) for each in (ik, other))
        assert one.q == pytest.approx(two.q, abs=1e-12), dt
        assert one[1:3] == pytest.approx(two[1:3], abs=1e-12), dt
        assert one[3:] == two[3:], dt


@pytest.mark.parametrize("items_only", [True, False])
def test_it_returns_a_step_as_python_makes_it(monkeypatch, items_only):
    monkeypatch.setattr(object_layout, "tuples_have_items_only", lambda: items_only)
    step = copy.copy(made()).step(Q, GOAL, dt=DT)
    assert type(step) is Step
    assert type(step.q) is np.ndarray
    assert step.q.flags.owndata
    assert [type(each) for each in step[1:]] == [float, float, bool, bool, bool]
    same = Step(np.zeros(3), *step[1:])
    assert sys.getrefcount(step) == sys.getrefcount(same)
    assert sys.getrefcount(step.q) == sys.getrefcount(same.q)
    assert gc.is_tracked(step)
    assert repr(pickle.loads(pickle.dumps(step))) == repr(step)
    with pytest.raises(TypeError):
        hash(step)


def test_this_interpreter_fills_tuples_where_it_can():
    assert object_layout.tuples_have_items_only() == (sys.version_info < (3, 14))


@pytest.mark.parametrize("items_only", [True, False])
def test_nothing_is_left_behind(monkeypatch, items_only):
    """Usual calls, calls that Python reads, and calls that are refused: no memory, and no reference too many."""
    monkeypatch.setattr(object_layout, "tuples_have_items_only", lambda: items_only)
    ik, goal, q, dt = copy.copy(made()), GOAL.copy(), Q.copy(), 0.0125
    wrong = np.full(3, np.nan)

    def run(count):
        for _ in range(count):
            ik.step(q, goal, dt=dt)
            ik.step([0.4, 0.5, 0.3], goal)
            with pytest.raises(jtik.ArgumentError):
                ik.step(wrong, goal, dt=dt)

    held = (q, goal, dt, wrong, Step, np.ndarray, ik._stepping, True, False, None)
    run(STEPS // 10)
    gc.collect()  # what other tests have left
    for _ in range(20):  # another thread may still read a library in the first of them
        before, blocks = [sys.getrefcount(each) for each in held], sys.getallocatedblocks()
        run(STEPS)
        gc.collect()
        grown = sys.getallocatedblocks() - blocks
        changed = np.abs(np.subtract([sys.getrefcount(each) for each in held], before)).max()
        if grown < STEPS / 10 and changed < STEPS / 2:
            return
    pytest.fail(f"{STEPS} calls left {grown} blocks of memory and {changed} references")


def test_a_busy_solver_refuses(ik):
    ik.step(Q, GOAL, dt=DT)
    ik._engine._exclusive.busy = True
    for dt in (None, DT):
        with pytest.raises(jtik.JtikError, match="in use"):
            ik.step(Q, GOAL, dt=dt)
    ik._engine._exclusive.busy = False
    ik.step(Q, GOAL, dt=DT)


def test_a_solver_that_is_no_longer_used_ends(ik):
    ik = copy.copy(ik)
    ik.step(Q, GOAL, dt=DT)
    ends = weakref.ref(ik._engine)
    del ik
    until = time.perf_counter() + 20
    while ends() is not None and time.perf_counter() < until:  # a library may still be read for it by another thread
        time.sleep(0.01)
        gc.collect()
    assert ends() is None


def test_a_step_that_is_adopted_anew_replaces_the_one_before_which_keeps_what_it_reads(ik):
    other = copy.copy(made(compiled=False))
    first, same = ik.step(Q, GOAL, dt=DT), other.step(Q, GOAL, dt=DT)
    before = ik._stepping.call
    ik._stepping.adopted()
    gc.collect()
    assert ik._stepping.call != before
    for call in (before, ik._stepping.call):
        first, same = call(first.q, GOAL, DT), other.step(same.q, GOAL, dt=DT)
        assert first.q == pytest.approx(same.q, abs=1e-12)


@pytest.mark.slow
def test_another_compiler(monkeypatch, tmp_path):
    for command in ("gcc", "clang"):
        if shutil.which(command):
            monkeypatch.setenv("CC", command)
            monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / command))
            ik = jtik.InverseKinematics(planar(3), jtik.FrameTask("tip"), strategy="damped", compiled=True)
            one, two = (each.step(Q, GOAL, dt=DT) for each in (ik, copy.copy(made(compiled=False))))
            assert one.q == pytest.approx(two.q, abs=1e-12)
            assert not python_calls(lambda ik=ik: ik.step(Q, GOAL, dt=DT))

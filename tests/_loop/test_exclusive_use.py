"""One call at a time: a second one is refused, of another thread or within the first, and is made once that is done."""

from __future__ import annotations

import copy
import dis
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import jtik
from jtik._loop.engine import Engine
from jtik._loop.jogging import Jogging
from jtik._loop.solving import Solving
from jtik._loop.stepping import Stepping
from jtik_formulations import JointCentering

from ..conftest import planar
from .conftest import new_solver

IN_USE = (
    "this InverseKinematics is in use, by another thread or by the call from which this one was made: "
    "one solver a thread, and another one within a callback; copy.copy(ik) is cheap"
)
LIBRARY = str(Path(jtik.__file__).parent)
Q0 = [0.3, 0.4, 0.5]


class Meanwhile:
    """A thread that stands within a solve_batch of ``ik`` for as long as the block lasts."""

    def __init__(self, ik):
        self._within, self._end, self.batch = threading.Event(), threading.Event(), None
        self._thread = threading.Thread(target=self._run, args=(ik,))

    def _run(self, ik):
        def wait(done, total):
            self._within.set()
            assert self._end.wait(30)

        self.batch = ik.solve_batch([(1.0, 1.5), (2.0, 1.0)], q0=Q0, progress=wait)

    def __enter__(self):
        self._thread.start()
        assert self._within.wait(30)
        return self

    def __exit__(self, *_):
        self._end.set()
        self._thread.join(30)


CALLS = {
    "solve": lambda ik: ik.solve((1.0, 1.5), q0=Q0),
    "step": lambda ik: ik.step(Q0, (1.0, 1.5)),
    "step(dt=)": lambda ik: ik.step(Q0, (1.0, 1.5), dt=0.1),
    "solve_batch": lambda ik: ik.solve_batch([(1.0, 1.5)], q0=Q0),
    "track": lambda ik: ik.track([(1.0, 1.5)], q0=Q0),
    "build": lambda ik: ik.build(Q0, (1.0, 1.5)),
    "reset": lambda ik: ik.reset(),
}


@pytest.mark.quick(2)
@pytest.mark.parametrize("name", CALLS)
def test_a_second_thread_is_refused_while_the_first_is_within(name):
    ik = new_solver(planar(3), criteria=JointCentering(), strategy="newton+qp")
    with Meanwhile(ik), pytest.raises(jtik.JtikError) as caught:
        CALLS[name](ik)
    assert str(caught.value) == IN_USE
    CALLS[name](ik)  # the first is done


def test_the_first_thread_is_not_disturbed():
    ik = new_solver(planar(3))
    alone = ik.solve_batch([(1.0, 1.5), (2.0, 1.0)], q0=Q0)
    with Meanwhile(ik) as other, pytest.raises(jtik.JtikError):
        ik.solve((0.5, 0.5))
    assert np.array_equal(other.batch.q, alone.q)


@pytest.mark.quick(2)
@pytest.mark.parametrize("name", CALLS)
def test_a_callback_cannot_use_the_solver_that_calls_it(name):
    ik = new_solver(planar(3), criteria=JointCentering(), strategy="newton+qp")
    targets, met = [(1.0, 1.5), (2.0, 1.0)], []
    alone = ik.solve_batch(targets, q0=Q0)

    def report(done, total):
        with pytest.raises(jtik.JtikError) as caught:
            CALLS[name](ik)
        met.append(str(caught.value))

    batch = ik.solve_batch(targets, q0=Q0, progress=report)
    assert met == [IN_USE, IN_USE]
    assert np.array_equal(batch.q, alone.q)


def test_a_callback_can_use_a_copy_with_other_tolerances():
    ik, found = new_solver(planar(3)), []
    targets = [(1.0, 1.5), (2.0, 1.0), (0.5, 1.0)]
    alone = ik.solve_batch(targets, q0=Q0)

    def report(done, total):
        found.append(copy.copy(ik).solve((2.5, 0.5), q0=Q0, position_tolerance=0.1, max_iterations=3).iterations)

    batch = ik.solve_batch(targets, q0=Q0, progress=report)
    assert len(found) == 3
    assert np.array_equal(batch.q, alone.q)


def test_targets_may_be_computed_by_the_solver_itself():
    ik = new_solver(planar(3))
    batch = ik.solve_batch((ik.solve((1.0, y), q0=Q0).q[:2] for y in (1.0, 1.5)), q0=Q0)
    assert len(batch) == 2


def in_four_threads(call, items):
    """Call with each item, in four threads that change as often as they can. Returns results and messages."""
    done, refused = [], []

    def run(own):
        for item in own:
            try:
                result = call(item)
            except jtik.JtikError as error:
                refused.append(str(error))
            else:
                done.append((item, result))

    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        threads = [threading.Thread(target=run, args=(items[k::4],)) for k in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(60)
    finally:
        sys.setswitchinterval(before)
    assert len(done) + len(refused) == len(items)
    assert done
    assert set(refused) <= {IN_USE}
    return done


@pytest.mark.parametrize("compiled", [False, True])
def test_of_several_threads_each_gets_the_right_answer_or_an_error(compiled):
    ik = jtik.InverseKinematics(jtik.Robot.planar(4), jtik.FrameTask(kind="position"), compiled=compiled)
    targets = np.random.default_rng(0).uniform(-2.0, 2.0, (400, 2))
    for target, solution in in_four_threads(lambda target: ik.solve(target, q0=np.full(4, 0.3)), targets):
        reached = np.linalg.norm(ik.robot.position(solution.q)[:2] - target) < 1e-5
        assert reached == solution.converged


def test_of_several_threads_each_gets_the_right_step_or_an_error():
    ik = new_solver(planar(3), strategy="newton")  # a step does not depend on the last one
    rng = np.random.default_rng(0)
    starts, targets = rng.uniform(-1.0, 1.0, (2000, 3)), rng.uniform(-2.0, 2.0, (2000, 2))
    expected = [ik.step(*given).q for given in zip(starts, targets, strict=True)]
    for i, step in in_four_threads(lambda i: ik.step(starts[i], targets[i]), list(range(2000))):
        assert np.array_equal(step.q, expected[i])


GUARDED = [
    method
    for owner in (Engine, Jogging, Solving, Stepping)
    for method in vars(owner).values()
    if "in_use" in getattr(getattr(method, "__code__", None), "co_names", ())
]
QUIET = {"POP_JUMP_FORWARD_IF_FALSE", "POP_JUMP_IF_FALSE", "TO_BOOL", "NOP", "NOT_TAKEN", "CACHE", "LOAD_CONST"}
QUIET |= {"LOAD_FAST", "LOAD_FAST_BORROW", "LOAD_ATTR", "LOAD_DEREF"}


@pytest.mark.parametrize("method", GUARDED, ids=lambda method: method.__qualname__)
def test_nothing_at_which_threads_change_is_between_the_test_and_the_mark(method):
    """The interpreter changes threads and delivers signals in calls, in jumps backwards and on entry."""
    assert len(GUARDED) == 11
    code = list(dis.get_instructions(method))
    tested = next(i for i, each in enumerate(code) if each.argval == "busy")
    jump = next(i for i in range(tested, len(code)) if "JUMP" in code[i].opname)
    to = next(i for i, each in enumerate(code) if each.offset == code[jump].argval)
    marked = next(i for i in range(to, len(code)) if code[i].opname == "STORE_ATTR")
    assert code[marked].argval == "busy"
    between = {each.opname for each in (*code[tested : jump + 1], *code[to:marked])}
    assert between <= QUIET


@pytest.mark.slow
def test_copies_in_several_threads_give_the_numbers_of_one():
    ik = jtik.InverseKinematics(
        jtik.Robot.planar(4), jtik.FrameTask(kind="position"), criteria=JointCentering(), strategy="weighted_qp"
    )
    targets = np.random.default_rng(0).uniform(-2.0, 2.0, (40, 2))
    alone = [ik.solve(target, q0=np.full(4, 0.3)) for target in targets]
    with ThreadPoolExecutor(4) as pool:
        parts = list(pool.map(lambda own: [copy.copy(ik).solve(t, q0=np.full(4, 0.3)) for t in own], [targets] * 4))
    for part in parts:
        for one, other in zip(part, alone, strict=True):
            assert np.array_equal(one.q, other.q)
            assert (one.status, one.iterations) == (other.status, other.iterations)


IN_LANES = {"solve in lanes": lambda ik: ik.solve((1.0, 1.5), q0=Q0, restarts=5, lanes=True)}


@pytest.mark.quick(2)
@pytest.mark.parametrize("name", ["solve", "step", "solve_batch", "track", "reset", *IN_LANES])
def test_an_interrupt_leaves_a_solver_that_can_be_used(name):
    """Wherever Ctrl-C arrives in a call, the next one is not refused."""
    ik = new_solver(planar(3), criteria=JointCentering())
    call = (CALLS | IN_LANES)[name]
    call(ik)  # builds what is built on demand
    for moment in range(10**6):
        count = 0

        def interrupt(frame, event, argument, moment=moment):
            nonlocal count
            if frame.f_code.co_filename.startswith(LIBRARY):
                count += 1
                if count == moment + 1:
                    raise KeyboardInterrupt

        sys.setprofile(interrupt)
        try:
            call(ik)
        except KeyboardInterrupt:
            interrupted = True
        else:
            interrupted = False
        finally:
            sys.setprofile(None)
        ik.step(Q0, (1.0, 1.5))
        if not interrupted:
            break
    assert moment > 2


def test_after_an_error_it_can_be_used_again():
    ik = new_solver(planar(3))
    for wrong in (lambda: ik.solve((np.nan, 1.0)), lambda: ik.step([np.nan] * 3, (1.0, 1.0)), lambda: ik.track([])):
        with pytest.raises(jtik.ArgumentError):
            wrong()
    found = []
    other = threading.Thread(target=lambda: found.append(ik.solve((1.0, 1.5), q0=Q0).converged))
    other.start()
    other.join(30)
    assert found == [True]


def test_a_solution_can_be_read_while_another_thread_solves():
    """What is computed on reading has memory of its own, or waits."""
    ik = new_solver(planar(3), criteria=JointCentering())
    solution = ik.solve((1.0, 1.5), q0=Q0)
    expected = ik.solve((1.0, 1.5), q0=Q0)
    with Meanwhile(ik):
        assert solution.jacobian.tolist() == expected.jacobian.tolist()
        assert repr(solution).splitlines()[2:3] == repr(expected).splitlines()[2:3]
        assert solution.second_order == expected.second_order == "minimum"


def test_copies_solve_at_the_same_time():

    ik = new_solver(planar(3))
    copied = copy.copy(ik)
    with Meanwhile(ik):
        assert copied.solve((1.0, 1.5), q0=Q0).converged

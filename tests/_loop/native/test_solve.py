"""The native solve: the numbers of the solve in Python, bit by bit, which calls stay in C, and what they hold.

Its slow tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

import copy
import dataclasses
import functools
import gc
import pickle
import sys
import threading
import time
import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import jtik
from jtik._loop.native import object_layout
from jtik._loop.target_memory import TargetMemory
from jtik.result.report import Report
from jtik.symbolic.compile import CompilerError, compiler
from jtik_formulations import JointCentering

from ...conftest import dh_arm, planar, slow
from .conftest import python_calls

try:
    compiler()
except CompilerError:
    pytest.skip("needs a C compiler", allow_module_level=True)

ARM = dh_arm(7, 3, limit=1.5)
SOLVES = 1000
LANES = {"restarts": 20, "lanes": True}


@functools.cache
def made(kind="pose", compiled=True, **options):
    """A solver whose lanes are compiled, for copies that share them; the same for the same arguments."""
    ik = jtik.InverseKinematics(ARM, jtik.FrameTask("tip", kind), strategy="damped", compiled=compiled, **options)
    ik.solve(ARM.pose(ARM.neutral + 0.3)[:3, 3] if kind == "position" else ARM.pose(ARM.neutral + 0.3), **LANES)
    return ik


def in_python(ik):
    """A copy with the same search in C, around which everything is Python."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(object_layout, "is_known", lambda: False)
        other = copy.copy(ik)
    assert other._solving.natives.call == other._solving.solve
    return other


@pytest.fixture
def ik():
    return copy.copy(made())


def targets(rng, count):
    """Poses within reach, one in ten out of reach and one in ten at a singularity."""
    for k in range(count):
        q = ARM.random_configuration(rng)
        T = ARM.pose(np.zeros(7) if k % 10 == 7 else q)
        if k % 10 == 3:
            T[:3, 3] *= 3.0
        yield T


def numbers(solution):
    """All of a Solution but its time."""
    report = solution.report
    own = [solution.q, report.error, report.jacobian, report.weighted, report.gradient]
    rest = [solution.status, solution.converged, solution.iterations, solution.escapes, solution.restarts]
    rest += [solution.trace, solution.alternatives, solution.evaluations, solution.unused, report.tolerances]
    return [each.tolist() for each in own], rest, report.at_lower, report.at_upper, type(solution)


def solved(ik, *given, **options):
    """The Solution as numbers; the message where an argument is refused."""
    try:
        return numbers(ik.solve(*given, **options))
    except jtik.ArgumentError as error:
        return str(error)


WAYS = {
    "plain": {},
    "restarts": {"restarts": 20, "seed": 3},
    "few iterations": {"max_iterations": 5},
    "reached": {"until": "reached", "position_tolerance": 1e-3},
    "lanes": LANES,
    "lanes, nearest": {**LANES, "nearest": True, "seed": 3},
    "lanes, one restart": {"lanes": True, "restarts": 1},
    "lanes, no iteration": {**LANES, "max_iterations": 0},
}


@pytest.mark.parametrize("count", [60, *slow(1000)])
@pytest.mark.parametrize("way", WAYS)
def test_it_solves_as_python_does(ik, way, count, rng):
    other, kinds = in_python(ik), set()
    for k, T in enumerate(targets(rng, count)):
        q0 = None if k % 4 == 1 else ARM.random_configuration(rng)
        one, two = solved(ik, T, q0=q0, **WAYS[way]), solved(other, T, q0=q0, **WAYS[way])
        assert one == two, k
        kinds.add(one[1][1])
    assert False in kinds
    assert True in kinds or "iteration" in way


@pytest.mark.parametrize("way", ["plain", "restarts", "lanes", "lanes, nearest"])
def test_a_usual_call_is_one_call_of_c(ik, way):
    T, q0, options = ARM.pose(ARM.neutral + 0.3), ARM.neutral + 0.25, WAYS[way]
    columns, every_second = np.asfortranarray(T), np.repeat(q0, 2)[::2]
    same = {"max_iterations": int("1000"), "position_tolerance": float("1e-6"), "until": "".join(["station", "ary"])}
    for _ in range(2):  # a bank of restarts is drawn when a search first needs it
        ik.solve(ARM.pose(np.full(7, 0.8)), q0=q0, **options)
    assert not python_calls(lambda: ik.solve(T, q0=q0, **options))
    assert not python_calls(lambda: ik.solve(T, **options))
    assert not python_calls(lambda: ik.solve(columns, q0=every_second, **options))
    assert not python_calls(lambda: ik.solve(T, q0=q0, **options, **same))  # other objects
    assert python_calls(lambda: ik.solve(T, q0=q0.tolist(), **options))
    assert python_calls(lambda: ik.solve(T.tolist(), q0=q0, **options))
    assert python_calls(lambda: ik.solve(T, q0=q0, **options, optimality_tolerance=1e-5))
    assert not python_calls(lambda: ik.solve(T, q0=q0, **options, optimality_tolerance=1e-5))
    assert python_calls(lambda: ik.solve(T, q0=q0, **options))  # the tolerances are new once more


def test_solves_with_and_without_lanes_take_turns(ik):
    """Each with restarts of its own: what both have in memory are the tolerances."""
    T, q0, other = ARM.pose(ARM.neutral + 0.3), ARM.neutral + 0.25, in_python(ik)
    for options in ({}, LANES, {}):
        ik.solve(T, q0=q0, **options)
    for options in (LANES, {}, LANES, {}):
        assert not python_calls(lambda options=options: ik.solve(T, q0=q0, **options))
        assert solved(ik, T, q0=q0, **options) == solved(other, T, q0=q0, **options)
    for options in ({"position_tolerance": 1e-3}, LANES, {"until": "reached"}, LANES, {"restarts": 3}, LANES):
        assert solved(ik, T, q0=q0, **options) == solved(other, T, q0=q0, **options)


def test_lists_are_read_in_python_and_solved_by_the_search_in_c_alone(ik):
    T, q0 = ARM.pose(ARM.neutral + 0.3), ARM.neutral + 0.25
    expected = solved(ik, T, q0=q0)
    calls = python_calls(lambda: ik.solve(T.tolist(), q0=q0.tolist()))
    assert "Solutions.converged" in calls
    assert "Search.find" not in calls
    assert solved(ik, T.tolist(), q0=q0.tolist()) == expected


class Own(np.ndarray):
    """An array of another class."""


FORMS = {
    "lists": lambda q, T: (T.tolist(), q.tolist()),
    "columns first": lambda q, T: (np.asfortranarray(T), q),
    "every second": lambda q, T: (np.repeat(np.repeat(T, 2, 0), 2, 1)[::2, ::2], np.repeat(q, 2)[::2]),
    "backwards": lambda q, T: (T[::-1, ::-1].copy()[::-1, ::-1], q[::-1].copy()[::-1]),
    "single precision": lambda q, T: (T, q.astype(np.float32)),
    "the other byte order": lambda q, T: (T.astype(T.dtype.newbyteorder()), q.astype(q.dtype.newbyteorder())),
    "another class": lambda q, T: (T.view(Own), q.view(Own)),
    "read-only": lambda q, T: (np.frombuffer(T.tobytes()).reshape(4, 4), np.frombuffer(q.tobytes())),
    "integers": lambda q, T: (T, np.zeros(7, int)),
    "a dict": lambda q, T: (T, {"joint1": 0.2}),
    "a row": lambda q, T: (T, q[None]),
    "one too few": lambda q, T: (T, q[1:]),
    "no numbers": lambda q, T: (T, np.zeros(0)),
    "NaN in q0": lambda q, T: (T, np.where(np.arange(7) == 3, np.nan, q)),
    "infinite q0": lambda q, T: (T, np.where(np.arange(7) == 3, np.inf, q)),
    "huge q0": lambda q, T: (T, np.full(7, 1e308)),
    "a text": lambda q, T: (T, "q"),
    "NaN in the target": lambda q, T: (np.where(np.arange(16).reshape(4, 4) == 3, np.nan, T), q),
    "no rotation": lambda q, T: (2 * T, q),
    "three rows": lambda q, T: (T[:3], q),
    "a vector of the size of a pose": lambda q, T: (T.ravel(), q),
    "no target": lambda q, T: (None, q),
    "both wrong": lambda q, T: (T[:3], q[1:]),
}


@pytest.mark.parametrize("way", ["plain", "lanes"])
@pytest.mark.parametrize("form", FORMS)
def test_anything_else_is_read_or_refused_by_python(ik, form, way):
    """With the same message; the solve after it is the one without it."""
    q0, T, options, other = ARM.neutral + 0.25, ARM.pose(ARM.neutral + 0.3), WAYS[way], in_python(ik)
    for given in ((T, q0), FORMS[form](q0, T), (T, q0)):
        one, two = (solved(each, given[0], q0=given[1], **options) for each in (ik, other))
        assert one == two


VECTORS = {
    "a pose": lambda T: T,
    "three numbers": lambda T: T[:3, 3].copy(),
    "a column of a pose": lambda T: T[:3, 3],
    "two numbers": lambda T: np.ones(2),
    "a number": lambda T: np.array(0.5),
    "a row": lambda T: T[None, :3, 3],
    "NaN": lambda T: np.array([0.5, np.nan, 0.1]),
    "too large": lambda T: np.full(3, 1e200),
}


def test_vectors_are_read_in_c(monkeypatch):
    ik, T = copy.copy(made("position")), ARM.pose(ARM.neutral + 0.3)
    other = in_python(ik)
    for options in ({}, LANES):
        for name, given in VECTORS.items():
            assert solved(ik, given(T), **options) == solved(other, given(T), **options), name
        ik.solve(T[:3, 3].copy(), **options)
        assert not python_calls(lambda options=options: ik.solve(T[:3, 3].copy(), **options))


OPTIONS = {
    "an integral number": {"restarts": 3.0},
    "True": {"restarts": True},
    "a NumPy integer": {"restarts": np.int64(3)},
    "a NumPy number": {"position_tolerance": np.float64(1e-4)},
    "an array": {"position_tolerance": np.array(1e-4)},
    "a text": {"position_tolerance": "1e-4"},
    "NaN": {"position_tolerance": np.nan},
    "an old name": {"until": "reached"},
    "another word": {"until": "soon"},
    "a trace that is no flag": {"trace": 1},
    "a flag of NumPy": {"trace": np.False_},
    "lanes of NumPy": {"lanes": np.True_, "restarts": 3},
    "lanes that are no flag": {"lanes": 1, "restarts": 3},
    "no lanes of NumPy": {"lanes": np.False_, "nearest": np.False_},
    "nearest alone": {"nearest": True},
    "lanes without restarts": {"lanes": True},
    "lanes with a trace": {**LANES, "trace": True},
    "lanes with best_of": {**LANES, "best_of": 2},
    "lanes with a jump limit": {**LANES, "jump_limit": 1.0},
    "a jump limit": {"jump_limit": 1.0},
    "best_of": {"restarts": 5, "best_of": 2},
    "a negative seed": {"restarts": 5, "seed": -1},
}


@pytest.mark.parametrize("name", OPTIONS)
def test_options_of_any_form(ik, name):
    """Between two usual calls, which stay as they are."""
    q0, T, other = ARM.neutral + 0.25, ARM.pose(ARM.neutral + 0.3), in_python(ik)
    for options in ({}, LANES, OPTIONS[name], OPTIONS[name], {}, LANES, {"position_tolerance": 1e-2}, {}):
        one, two = (solved(each, T, q0=q0, **options) for each in (ik, other))
        if not isinstance(one, str):
            one, two = ([*each[:1], *each[1][:5], *each[2:]] for each in (one, two))  # alternatives are objects
        assert one == two


def test_options_that_lanes_share_with_other_solves_are_those_of_the_call(ik):
    """Solves with and without lanes, and a track, with tolerances of their own."""
    q0, T, other = ARM.neutral - 0.3, ARM.pose(ARM.neutral + 0.3), in_python(ik)
    loose = {"position_tolerance": 1e-2, "orientation_tolerance": 1e-2}
    for options in (LANES, LANES, loose, LANES, {**LANES, **loose}, {}, loose, {**LANES, "nearest": True}, LANES):
        assert solved(ik, T, q0=q0, **options) == solved(other, T, q0=q0, **options)
    for each in (ik, other):
        each.track([T], q0=q0, position_tolerance=1e-3)
    for options in (LANES, {}):
        assert solved(ik, T, q0=q0, **options) == solved(other, T, q0=q0, **options)


@pytest.mark.parametrize("options", [{}, LANES], ids=["plain", "lanes"])
def test_it_returns_a_solution_as_python_makes_it(ik, options):
    T, q0 = ARM.pose(ARM.neutral + 0.3), ARM.neutral + 0.25
    ik.solve(T, q0=q0, **options)
    solution, same = ik.solve(T, q0=q0, **options), in_python(ik).solve(T, q0=q0, **options)
    assert type(solution) is jtik.Solution
    for name in (field.name for field in dataclasses.fields(jtik.Solution)):
        one, two = getattr(solution, name), getattr(same, name)
        assert type(one) is type(two) or name == "inspect"
        if name not in ("q", "inspect", "seconds"):
            assert one == two
            assert one is two or name in ("iterations", "restarts")
    assert type(solution.q) is np.ndarray
    assert solution.q.flags.owndata
    assert solution.q.flags.writeable
    assert 0 < solution.seconds < 1
    assert gc.is_tracked(solution)
    assert sys.getrefcount(solution) == sys.getrefcount(same)
    assert sys.getrefcount(solution.q) == sys.getrefcount(same.q)
    assert type(solution.inspect()) is Report
    assert solution.report is solution.report
    pickled, replaced = pickle.loads(pickle.dumps(solution)), dataclasses.replace(solution, escapes=2)
    for changed in (pickled, replaced, copy.copy(solution)):
        assert changed.q.tolist() == solution.q.tolist()
        assert changed.position_error == solution.position_error
    assert repr(solution).splitlines()[:2] == repr(same).splitlines()[:2]
    with pytest.raises(dataclasses.FrozenInstanceError):
        solution.q = q0
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = solution.nothing


def test_a_solution_is_that_of_its_own_target(ik):
    """Whatever is solved next, and whatever is written into arrays that were given or returned."""
    T, q0 = ARM.pose(ARM.neutral + 0.3), ARM.neutral + 0.25
    expected = in_python(ik).solve(T, q0=q0).report
    ik.solve(T, q0=q0)
    goal, start = T.copy(), q0.copy()
    solution = ik.solve(goal, q0=start)
    assert goal.tolist() == T.tolist()
    assert start.tolist() == q0.tolist()
    goal[:], start[:], solution.q[:] = np.eye(4), 0.0, 0.0
    ik.solve(ARM.pose(ARM.neutral - 0.4), q0=q0, position_tolerance=0.1)
    assert solution.report.jacobian.tolist() == expected.jacobian.tolist()
    assert solution.report.error.tolist() == expected.error.tolist()
    assert solution.report.tolerances == expected.tolerances


def test_nothing_is_left_behind(ik):
    """Usual calls, those that Python reads, that do not converge, that are refused: no memory, no reference."""
    T, q0, tolerance = ARM.pose(ARM.neutral + 0.3), ARM.neutral + 0.25, 0.00125
    wrong, far = np.full(7, np.nan), T.copy()
    far[:3, 3] = 50.0

    def run(count):
        for k in range(count):
            ik.solve(T, q0=q0, position_tolerance=tolerance)
            ik.solve(T, q0=None, position_tolerance=float("0.00125"))
            if k % 4 == 0:
                ik.solve(T, q0=q0.tolist(), position_tolerance=tolerance)
                ik.solve(far, q0=q0, position_tolerance=tolerance, max_iterations=3)
                ik.solve(T, q0=q0, position_tolerance=tolerance, **LANES)
                ik.solve(T, q0=q0, position_tolerance=tolerance, **LANES)
                ik.solve(far, q0=q0, position_tolerance=tolerance, **{**LANES, "restarts": 2})
                with pytest.raises(jtik.ArgumentError):
                    ik.solve(T, q0=wrong, position_tolerance=tolerance)

    counted = (q0, T, far, wrong, tolerance, jtik.Solution, np.ndarray, jtik.Status.CONVERGED, ik._solving)
    counted += (True, False, None, 0, ik._engine._exclusive)
    run(SOLVES // 2)
    gc.collect()  # what other tests have left
    before, blocks = [sys.getrefcount(each) for each in counted], sys.getallocatedblocks()
    run(SOLVES)
    gc.collect()
    assert sys.getallocatedblocks() - blocks < SOLVES / 5
    after = [sys.getrefcount(each) for each in counted]
    assert np.abs(np.subtract(after, before)).max() < SOLVES / 20  # other threads use some of them, too


def test_a_busy_solver_refuses(ik):
    T = ARM.pose(ARM.neutral + 0.3)
    for options in ({}, LANES):
        ik.solve(T, **options)
        ik._engine._exclusive.busy = True
        with pytest.raises(jtik.JtikError, match="in use"):
            ik.solve(T, **options)
        ik._engine._exclusive.busy = False
        ik.solve(T, **options)


def test_a_second_thread_is_refused_during_the_search_and_runs_meanwhile(ik):
    T, far, ends = ARM.pose(ARM.neutral + 0.3), ARM.pose(ARM.neutral + 0.3), []
    far[:3, 3] = 50.0
    ik.solve(T, restarts=3000)
    other = threading.Thread(target=lambda: ends.append(ik.solve(far, restarts=3000)))
    other.start()
    end, refused, rounds = time.monotonic() + 30, 0, 0
    while not ends and time.monotonic() < end:
        rounds += 1
        if ik._engine._exclusive.busy and not refused:
            with pytest.raises(jtik.JtikError, match="in use"):
                ik.solve(T, restarts=3000)
            refused += 1
    other.join(30)
    assert (len(ends), refused) == (1, 1)
    assert rounds > 10
    assert ik.solve(T, restarts=3000).converged


@pytest.mark.parametrize("options", [{}, LANES], ids=["plain", "lanes"])
def test_an_interrupt_after_the_search_leaves_a_solver_that_can_be_used(ik, options, monkeypatch):
    T, far = ARM.pose(ARM.neutral + 0.3), ARM.pose(ARM.neutral + 0.3)
    far[:3, 3] = 50.0
    ik.solve(T, **options)

    def interrupted(self, target):
        assert ik._engine._exclusive.busy
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(TargetMemory, "read", interrupted)
        with pytest.raises(KeyboardInterrupt):
            ik.solve(far, **options)
    assert not ik._engine._exclusive.busy
    assert ik.solve(T, **options).converged


def test_copies_in_threads_give_the_numbers_of_one(ik, rng):
    goals = list(targets(rng, 100))
    expected = [solved(ik, T, **LANES) for T in goals] + [solved(ik, T) for T in goals]

    def run(own):
        return [solved(own, T, **LANES) for T in goals] + [solved(own, T) for T in goals]

    with ThreadPoolExecutor(3) as pool:
        for found in pool.map(run, [copy.copy(ik) for _ in range(3)]):
            assert found == expected


def test_a_solver_that_is_no_longer_used_ends_and_its_call_outlives_it():
    ik, T, q0 = copy.copy(made()), ARM.pose(ARM.neutral + 0.3), ARM.neutral + 0.25
    for options in ({}, LANES):
        ik.solve(T, q0=q0, **options)
    ends, call, expected = weakref.ref(ik._engine), ik._solving.natives.call, ik.solve(T, q0=q0, **LANES)
    del ik
    gc.collect()
    given = (False, 20, None, 1000, 1, None, 1e-6, 1e-6, 1e-6, "stationary")
    assert call(T, q0, True, False, *given).q.tolist() == expected.q.tolist()
    del call, expected
    gc.collect()
    assert ends() is None


def test_a_search_that_is_adopted_anew_replaces_the_one_before(ik):
    T, q0 = ARM.pose(ARM.neutral + 0.3), ARM.neutral + 0.25
    for options in ({}, LANES):
        expected = solved(ik, T, q0=q0, **options)
        before = ik._solving.natives.call
        ik._engine._search_in_c()
        ik._solving.adopted()
        gc.collect()
        assert ik._solving.natives.call != before
        for _ in range(2):
            assert solved(ik, T, q0=q0, **options) == expected
        assert not python_calls(lambda options=options: ik.solve(T, q0=q0, **options))


def test_lanes_are_one_call_of_c_on_the_virtual_machine_too():
    ik, T = copy.copy(made(compiled=False)), ARM.pose(ARM.neutral + 0.3)
    ik.solve(T, **LANES)
    assert not python_calls(lambda: ik.solve(T, **LANES))
    assert python_calls(lambda: ik.solve(T))
    assert solved(ik, T, **LANES) == solved(copy.copy(made()), T, **LANES)


def test_several_tasks_have_dicts_of_targets(rng):
    tasks = [jtik.FrameTask("tip", "position", name="tip"), jtik.FrameTask("tip", "orientation", name="turn")]
    ik = jtik.InverseKinematics(ARM, tasks, strategy="damped", compiled=True)
    other = in_python(ik)
    for T in targets(rng, 20):
        given = {"tip": T[:3, 3], "turn": T[:3, :3]}
        assert solved(ik, given) == solved(other, given)


def test_a_criterion_is_left_to_python():
    ik = jtik.InverseKinematics(
        planar(4), jtik.FrameTask("tip", "position"), criteria=JointCentering(), strategy="hybrid", compiled=True
    )
    other, target = in_python(ik), np.array([1.5, 1.5])
    for options in ({}, {"restarts": 5}):
        for _ in range(2):
            one, two = (each.solve(target, q0=np.full(4, 0.3), **options) for each in (ik, other))
            assert one.q.tolist() == two.q.tolist()
            assert (one.status, one.cost) == (two.status, two.cost)

"""One thread at a time: a second one is refused, and finds what it asked for once the first is done."""

from __future__ import annotations

import copy
import threading

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering

from ..conftest import planar
from .conftest import solver

IN_USE = "this InverseKinematics is in use by another thread: make one for each thread, for instance by copy.deepcopy"
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


@pytest.mark.parametrize("name", CALLS)
def test_a_second_thread_is_refused_while_the_first_is_within(name):
    ik = solver(planar(3), criteria=JointCentering(), strategy="newton+qp")
    with Meanwhile(ik), pytest.raises(jtik.JtikError) as caught:
        CALLS[name](ik)
    assert str(caught.value) == IN_USE
    CALLS[name](ik)  # the first is done


def test_the_first_thread_is_not_disturbed():
    ik = solver(planar(3))
    alone = ik.solve_batch([(1.0, 1.5), (2.0, 1.0)], q0=Q0)
    with Meanwhile(ik) as other, pytest.raises(jtik.JtikError):
        ik.solve((0.5, 0.5))
    assert np.array_equal(other.batch.q, alone.q)


def test_one_thread_may_solve_from_within_its_own_progress():
    ik, found = solver(planar(3)), []
    batch = ik.solve_batch(
        [(1.0, 1.5), (2.0, 1.0)],
        q0=Q0,
        progress=lambda done, total: found.append(ik.solve((2.5, 0.5), q0=Q0).converged),
    )
    assert found == [True, True]
    assert np.array_equal(batch.q, ik.solve_batch([(1.0, 1.5), (2.0, 1.0)], q0=Q0).q)


def test_after_an_error_it_can_be_used_again():
    ik = solver(planar(3))
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
    ik = solver(planar(3), criteria=JointCentering())
    solution = ik.solve((1.0, 1.5), q0=Q0)
    expected = ik.solve((1.0, 1.5), q0=Q0)
    with Meanwhile(ik):
        assert solution.jacobian.tolist() == expected.jacobian.tolist()
        assert repr(solution).splitlines()[2:3] == repr(expected).splitlines()[2:3]
        assert solution.second_order == expected.second_order == "minimum"


def test_copies_solve_at_the_same_time():

    ik = solver(planar(3))
    copied = copy.deepcopy(ik)
    with Meanwhile(ik):
        assert copied.solve((1.0, 1.5), q0=Q0).converged

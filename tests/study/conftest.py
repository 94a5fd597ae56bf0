"""Fixtures for small studies, and contenders that fail."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.study import Answer, Contender, PreparedContender

TIMES = ("seconds", "seconds_low", "seconds_high", "seconds_per_iteration")
"""The columns that differ from one run of a study to the next."""


class Fixed(Contender):
    """Gives the same answer for every target and reports success."""

    def __init__(self, q, label="fixed", *, claimed=True):
        self.q, self.label, self.claimed = np.array(q, dtype=float), label, claimed

    def prepare(self, setting):
        return _Fixed(self.q, self.claimed)


class _Fixed(PreparedContender):
    def __init__(self, q, claimed):
        self.answer = Answer(q, "done", claimed)

    def solve(self, target, q0):
        return self.answer


class Broken(Contender):
    """Raises in every solve."""

    label = "broken"

    def prepare(self, setting):
        return _Broken()


class _Broken(PreparedContender):
    def solve(self, target, q0):
        raise RuntimeError("no answer")


@pytest.fixture
def fixed():
    return Fixed


@pytest.fixture
def broken():
    return Broken()


@pytest.fixture(scope="session")
def arm():
    return jtik.Robot.planar(4)


@pytest.fixture(scope="session")
def task():
    return jtik.FrameTask("tip")


@pytest.fixture(scope="session")
def figure_study(task):
    """A study with a criterion, a path, recorded iterations, and an unknown strategy."""
    return jtik.compare(
        jtik.Robot.planar(3),
        task,
        strategies=["hybrid", "newton", "transpose", "nobody"],
        criteria=jtik.criteria["joint_centering"](),
        problems={"reachable": 4, "circle": 1},
        until="stationary",
        traces=3,
        repeats=1,
    )


@pytest.fixture(scope="session")
def bare_study(task):
    """A study without a criterion, a path or recorded iterations."""
    return jtik.compare(jtik.Robot.planar(3), task, strategies="newton", count=2, traces=0, repeats=1)


@pytest.fixture
def assert_same():
    """Check that two studies have the same figures except times."""

    def check(one, other):
        assert list(one.columns) == list(other.columns)
        for name, column in one.columns.items():
            if name not in TIMES:
                np.testing.assert_array_equal(column, other.columns[name], err_msg=name)
        np.testing.assert_array_equal(one.answers, other.answers)
        assert one.traces.keys() == other.traces.keys()
        assert one.paths.keys() == other.paths.keys()
        for key, trace in one.traces.items():
            np.testing.assert_array_equal(trace.q, other.traces[key].q)
            np.testing.assert_array_equal(trace.error, other.traces[key].error)
            assert trace.figures.keys() == other.traces[key].figures.keys()
            for name, figure in trace.figures.items():
                np.testing.assert_array_equal(figure, other.traces[key].figures[name])
        for key, path in one.paths.items():
            np.testing.assert_array_equal(path, other.paths[key])

    return check

"""SolutionBatch: the columns have the names of a Solution, and rows are Solutions."""

from __future__ import annotations

import dataclasses
import pickle

import numpy as np
import pytest

import jtik

from ..conftest import planar, shared_solver


@pytest.fixture(scope="module")
def batch():
    ik = shared_solver(planar(3), jtik.FrameTask())
    return ik.solve_batch([(1.0, 1.0), (9.0, 0.0), (2.0, 1.0)], q0=[0.3, 0.4, 0.5])


def test_every_column_is_an_attribute_of_a_solution(batch):
    for field in dataclasses.fields(batch):
        if field.name not in ("targets", "indices", "complete", "inspect"):
            for column, solution in zip(getattr(batch, field.name), batch, strict=True):
                assert np.array_equal(column, getattr(solution, field.name)) or column == pytest.approx(
                    getattr(solution, field.name), abs=1e-15
                )


def test_rows_count_from_either_end_and_end(batch):
    assert batch[-1].q.tolist() == batch[2].q.tolist() == batch.q[2].tolist()
    with pytest.raises(IndexError):
        batch[3]


def test_it_can_be_pickled(batch):
    again = pickle.loads(pickle.dumps(batch))
    assert np.array_equal(again.q, batch.q)
    assert again.status == batch.status
    assert repr(again) == repr(batch)
    for mine, other in zip(batch, again, strict=True):
        assert repr(other) == repr(mine)
        assert np.array_equal(other.jacobian, mine.jacobian)


def test_its_reports_are_those_of_its_own_targets_whatever_is_solved_next():
    ik = shared_solver(planar(3), jtik.FrameTask())
    batch = ik.solve_batch([(1.0, 1.0), (2.0, 1.0)], q0=[0.3, 0.4, 0.5])
    ik.solve((0.5, 0.5))
    assert max(solution.position_error for solution in batch) <= 1e-6


def test_statuses_is_the_old_name(batch):
    with pytest.warns(DeprecationWarning, match=r"^SolutionBatch\.statuses is deprecated: use status$"):
        assert batch.statuses == batch.status

"""Step: one update as a tuple of named values."""

from __future__ import annotations

import pickle

import numpy as np

import jtik

from ..conftest import planar, shared_solver


def test_it_is_a_tuple_of_plain_values():
    step = shared_solver(planar(3), jtik.FrameTask()).step([0.3, 0.4, 0.5], (1.0, 1.5))
    assert isinstance(step, jtik.Step)
    q, position_error, orientation_error, accepted, done, escaped = step
    assert q is step.q
    assert [type(one) for one in step[1:]] == [float, float, bool, bool, bool]
    assert (position_error, orientation_error) == (step.position_error, step.orientation_error)
    assert (accepted, done, escaped) == (True, False, False)


def test_it_can_be_pickled():
    step = shared_solver(planar(3), jtik.FrameTask()).step([0.3, 0.4, 0.5], (1.0, 1.5))
    again = pickle.loads(pickle.dumps(step))
    assert np.array_equal(again.q, step.q)
    assert again[1:] == step[1:]

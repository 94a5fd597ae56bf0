"""Trace: figures as attributes."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import jtik


@pytest.fixture
def trace():
    return jtik.Trace(
        q=np.zeros((3, 2)), error=np.array([2.0, 1.0, 0.0]), figures={"V": np.array([2.0, 0.5]), "H": np.zeros(2)}
    )


def test_a_figure_is_an_attribute(trace):
    assert trace.V is trace.figures["V"]
    assert len(trace) == 2


def test_a_figure_that_is_not_there_lists_those_that_are(trace):
    with pytest.raises(AttributeError, match="a trace has q, error, V, H; not 'speed'"):
        _ = trace.speed
    assert not hasattr(trace, "speed")


def test_it_can_be_copied_and_pickled(trace):
    for copied in (copy.copy(trace), copy.deepcopy(trace), pickle.loads(pickle.dumps(trace))):
        assert copied.V.tolist() == trace.V.tolist()

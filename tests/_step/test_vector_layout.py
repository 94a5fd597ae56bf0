"""The layout of a vector: slices one after the other, and parts that survive joining and splitting."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik._step.vector_layout import VectorLayout

LAYOUT = VectorLayout.of({"a": 2, "none": 0, "b": 1, "c": 3})


def test_parts_lie_one_after_the_other():
    assert LAYOUT.size == 6
    assert LAYOUT.slices == {"a": slice(0, 2), "none": slice(2, 2), "b": slice(2, 3), "c": slice(3, 6)}


def test_a_joined_column_is_split_into_the_same_parts():
    parts = {"c": casadi.SX([4, 5, 6]), "a": casadi.SX([1, 2]), "b": casadi.SX(3), "none": casadi.SX(0, 1)}
    column = LAYOUT.join(parts)
    assert np.array(casadi.DM(column)).ravel().tolist() == [1, 2, 3, 4, 5, 6]
    for name, part in LAYOUT.split(column).items():
        assert np.array(casadi.DM(part)).tolist() == np.array(casadi.DM(parts[name])).tolist()


def test_plain_numbers_can_be_joined():
    assert np.array(casadi.DM(VectorLayout.of({"a": 1, "b": 1}).join({"a": 0, "b": 2.5}))).ravel().tolist() == [0, 2.5]


def test_an_empty_layout_has_no_entries():
    empty = VectorLayout.of({})
    assert (empty.size, dict(empty.slices), empty.join({}).numel()) == (0, {}, 0)


def test_groups_are_united_unless_one_would_overwrite_the_other():
    assert VectorLayout.united({"a": 1}, {}, {"b": 2, "c": 3}) == {"a": 1, "b": 2, "c": 3}
    with pytest.raises(ValueError, match=r"\['b'\]"):
        VectorLayout.united({"a": 1, "b": 2}, {"b": 3})

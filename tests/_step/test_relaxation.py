"""Relaxation terms: names and units beside the numbers of a record."""

from __future__ import annotations

import numpy as np
import pytest

from jtik import Relaxation
from jtik._step.relaxation import NEGLIGIBLE, RelaxationTerms

TERMS = RelaxationTerms((("task step", "share"), ("clearance: link1 to obstacle 0", "m"), ("rows, row 0", "")))


def test_amounts_have_their_names_and_units():
    assert TERMS.relaxed(np.array([0.5, 0.25, 2.0])) == (
        Relaxation("task step", 0.5, "share"),
        Relaxation("clearance: link1 to obstacle 0", 0.25, "m"),
        Relaxation("rows, row 0", 2.0, ""),
    )


def test_what_a_solver_leaves_is_not_relaxed():
    assert TERMS.relaxed(np.array([NEGLIGIBLE, 0.0, -1.0])) == ()
    assert TERMS.relaxed(np.array([2 * NEGLIGIBLE, 0.0, 0.0]))[0].name == "task step"


def test_one_amount_for_each_entry():
    with pytest.raises(ValueError, match="zip"):
        TERMS.relaxed(np.zeros(2))

"""Relaxations: names, amounts and units, as they are printed; the Solution that has them."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import jtik
from jtik import Relaxation
from jtik_formulations import ObstacleAvoidance

from ..conftest import planar, shared_solver


@pytest.mark.parametrize(
    ("relaxation", "text"),
    [
        (Relaxation("task step", 0.25, "share"), "task step by 25 %"),
        (Relaxation("clearance: link4 to obstacle 1", 0.0123456, "m"), "clearance: link4 to obstacle 1 by 0.0123 m"),
        (Relaxation("qp: rows, row 0", 2.0, ""), "qp: rows, row 0 by 2"),
    ],
)
def test_it_prints_by_how_much(relaxation, text):
    assert str(relaxation) == text


@pytest.fixture(scope="module")
def blocked():
    """The target lies within the safe distance of an obstacle."""
    field = ObstacleAvoidance(jtik.Circle((2.0, 1.2), 0.3), bodies="links")
    ik = shared_solver(
        planar(3),
        jtik.FrameTask(),
        strategy="weighted_qp",
        clearances=jtik.Clearance(field, safe=0.1),
    )
    return ik.solve((2.0, 1.2), q0=[0.1, 0.2, 0.3])


class TestOfASolution:
    def test_names_what_was_relaxed(self, blocked):
        assert blocked.relaxed
        assert all(isinstance(one, Relaxation) and one.amount > 0 for one in blocked.relaxed)
        line = next(line for line in repr(blocked).splitlines() if line.startswith("  relaxed "))
        assert line == f"  relaxed     {', '.join(map(str, blocked.relaxed))}"

    def test_is_pickled_with_it(self, blocked):
        again = pickle.loads(pickle.dumps(blocked))
        assert again.relaxed == blocked.relaxed

    def test_gave_way_is_the_old_name(self, blocked):
        with pytest.warns(DeprecationWarning, match=r"^Solution\.gave_way is deprecated: use relaxed$"):
            assert blocked.gave_way == blocked.relaxed

    def test_is_empty_where_all_constraints_hold(self):
        solution = shared_solver(planar(3), jtik.FrameTask()).solve((1.0, 1.5), q0=np.full(3, 0.3))
        assert solution.relaxed == ()
        assert "relaxed" not in repr(solution)

"""Public names of `jtik.qp`, and the deprecated ones."""

from __future__ import annotations

import pytest

import jtik.qp
from jtik.symbolic import SX


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("Foreign", "QPSolversBackend"),
        ("Program", "QuadraticProgram"),
        ("ProgramSolution", "QPSolution"),
        ("Recorded", "RecordedQP"),
        ("Recorder", "QPRecorder"),
    ],
)
def test_a_deprecated_name_warns_and_is_the_new_class(old, new):
    with pytest.warns(DeprecationWarning, match=f"jtik.qp.{old} is deprecated; use jtik.qp.{new}$"):
        assert getattr(jtik.qp, old) is getattr(jtik.qp, new)


def test_every_public_name_exists():
    assert all(hasattr(jtik.qp, name) for name in jtik.qp.__all__)


def test_an_unknown_name():
    with pytest.raises(AttributeError, match="Solver2"):
        _ = jtik.qp.Solver2


def test_deprecated_attributes_warn():
    recorder = jtik.qp.QPRecorder(1e-7)
    one = SX.ones(1)
    solution = recorder.solve(jtik.qp.QuadraticProgram(SX.eye(1), one, -one, one))
    recorder.compute("double", lambda given: [2 * given[0]], [one], [(1, 1)])
    recorded, computation = recorder.calls
    for owner, old, new in (
        (recorder, "programs", "calls"),
        (solution, "program", "qp"),
        (recorded, "program", "qp"),
        (recorded, "answers", "result_symbols"),
        (computation, "answers", "result_symbols"),
    ):
        with pytest.warns(DeprecationWarning, match=f"{old} is deprecated: use {new}$"):
            assert len(str(getattr(owner, old))) == len(str(getattr(owner, new)))

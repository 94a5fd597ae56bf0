"""Public names of `jtik.qp`, and the deprecated ones."""

from __future__ import annotations

import pytest

import jtik.qp


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

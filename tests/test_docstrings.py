"""Docstrings of public names: those that users meet first have an example that runs, and arguments are described."""

from __future__ import annotations

import doctest
import inspect
import re
from pathlib import Path
from typing import Any

import pytest

import jtik
import jtik_formulations

FIRST_MET = (
    "AxisTask",
    "Box",
    "CenterOfMassTask",
    "Circle",
    "Clearance",
    "Criterion",
    "FrameTask",
    "InverseKinematics",
    "Limits",
    "LookAtTask",
    "RelativeFrameTask",
    "Robot",
    "Scene",
    "Solution",
    "SolutionBatch",
    "Step",
    "Trajectory",
    "citations",
    "compare",
    "criterion",
)
"""The twenty names that users meet first."""

NAMES = {"jtik": jtik, **{name: getattr(jtik_formulations, name) for name in jtik_formulations.__all__}}
"""What the examples use."""

PUBLIC = [name for name in jtik.__all__ if callable(getattr(jtik, name))]


@pytest.mark.parametrize("name", FIRST_MET)
def test_an_example_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    doc = inspect.getdoc(getattr(jtik, name)) or ""
    test = doctest.DocTestParser().get_doctest(doc, dict(NAMES), name, None, None)
    assert test.examples
    assert len(test.examples) <= 6
    report: list[str] = []
    doctest.DocTestRunner().run(test, out=report.append)
    assert not report, "".join(report)


@pytest.mark.parametrize("name", PUBLIC)
def test_the_first_line_says_what_it_is(name: str) -> None:
    first = (inspect.getdoc(getattr(jtik, name)) or "").partition("\n")[0]
    assert first.endswith(".")
    assert len(first.split()) > 2


def described(owner: Any) -> str:
    """What the docstrings of a class and of its bases say, or that of a function."""
    return "\n".join(
        inspect.getdoc(each) or "" for each in (inspect.getmro(owner) if inspect.isclass(owner) else [owner])
    )


@pytest.mark.parametrize(
    "name", [name for name in PUBLIC if not name.endswith("Error") and name not in ("JointType", "Status")]
)
def test_every_argument_is_described(name: str) -> None:
    value = getattr(jtik, name)
    parameters = [each for each in inspect.signature(value).parameters if not each.startswith("_")]
    text = described(value)
    assert [each for each in parameters if not re.search(rf"\b{each}\b", text)] == []

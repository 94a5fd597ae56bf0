"""Docstrings of public names: those that users meet first have an example that runs, and arguments are described."""

from __future__ import annotations

import doctest
import importlib
import inspect
import re
from collections.abc import Iterator
from enum import Enum
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


SECTION = re.compile(r"^(?:Args|Attributes):\n((?:(?: {4}.*)?\n)*)", re.MULTILINE)


def entries(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What the reference of the site lists: every public class and function."""
    pytest.importorskip("jupytext")
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "docs"))
    found = importlib.import_module("site_pages.reference").entries()
    return [each for each in found if each.kind in ("autoclass", "autofunction")]


def is_ours(value: Any) -> bool:
    return str(getattr(value, "__module__", None)).partition(".")[0] in ("jtik", "jtik_formulations")


def public_methods(owner: type) -> Iterator[tuple[str, Any]]:
    """The public methods of a class by name, those of its bases in jtik included."""
    for name in dir(owner):
        method = getattr(owner, name)
        if not name.startswith("_") and inspect.isroutine(method) and callable(method) and is_ours(method):
            yield name, method


def docstrings(owner: type, name: str) -> str:
    """The docstrings of a method, or of a class itself, with those of the bases that it overrides."""
    found = [getattr(base, name, None) for base in inspect.getmro(owner) if is_ours(base)]
    return "\n\n".join(inspect.cleandoc(getattr(each, "__doc__", None) or "") for each in found)


def undescribed(value: Any, text: str) -> list[str]:
    """The arguments that neither a section of a docstring has nor a sentence of it names in ``double quotes``."""
    names = [each for each in inspect.signature(value).parameters if each != "self" and not each.startswith("_")]
    listed = re.findall(r"^ {4}([\w*, ]+):", "\n".join(SECTION.findall(f"{text}\n")), re.MULTILINE)
    named = re.findall(r"``[^`]+``", text)
    there = set(re.findall(r"\w+", " ".join([*listed, *named])))
    return [each for each in names if each not in there]


@pytest.mark.parametrize(
    "text", ["X of ``q``.", "X.\n\nArgs:\n    q: the configuration.", "X.\n\nAttributes:\n    q: it."]
)
def test_a_described_argument_is_found(text: str) -> None:
    assert undescribed(lambda q: q, text) == []
    assert undescribed(lambda q, frame: (q, frame), text) == ["frame"]


@pytest.mark.parametrize("text", ["", "X at q.", "X.\n\nRaises:\n    q: no argument."])
def test_a_missing_description_is_found(text: str) -> None:
    assert undescribed(lambda q: q, text) == ["q"]


def test_every_argument_is_described(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of every public function, class and method.

    What a base of jtik describes need not be described again: the arguments of a class that has a base, and of a method
    that overrides one. The built-in formulations have the methods of their bases.
    """
    missing = {}
    for entry in entries(monkeypatch):
        value = entry.value
        if not inspect.isclass(value):
            missing[entry.name] = undescribed(value, inspect.getdoc(value) or "")
            continue
        if not (issubclass(value, Enum) or getattr(value, "_is_protocol", False)):  # nobody calls them
            bases = [inspect.cleandoc(base.__doc__ or "") for base in inspect.getmro(value) if is_ours(base)]
            missing[entry.name] = undescribed(value, "\n\n".join(bases))
        if entry.page != "jtik_formulations":
            for name, method in public_methods(value):
                missing[f"{entry.name}.{name}"] = undescribed(method, docstrings(value, name))
    assert len(missing) > 500
    assert {name: arguments for name, arguments in missing.items() if arguments} == {}

"""docs/guides/criteria.md shows every criterion, with its live parameters, its picture and its derivation."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import jtik
from jtik.testing import example_criterion

DOCS = Path(__file__).parents[1] / "docs" / "guides"
TEXT = (DOCS / "criteria.md").read_text(encoding="utf-8")
SECTIONS = dict(re.findall(r"^### (\w+)\n(.*?)(?=^##|\Z)", TEXT, flags=re.DOTALL | re.MULTILINE))

OWN = [name for name, plugin in jtik.criteria.loaded().items() if plugin.__module__.startswith("jtik_formulations")]


def test_there_is_no_other_section() -> None:
    assert sorted(SECTIONS) == sorted(OWN)


@pytest.mark.parametrize("name", OWN)
def test_a_criterion(name: str) -> None:
    section, plugin = SECTIONS[name], jtik.criteria[name]
    assert f"criteria/{name}.png" in section
    derivation = re.search(r"\[Derivation\]\((.*?)\)", section)
    assert derivation is not None
    assert (DOCS / derivation[1]).is_file()
    assert (DOCS / "criteria" / f"{name}.png").stat().st_size < 60_000
    assert isinstance(plugin, type)
    robot = jtik.Robot.builtin("panda")
    missing = [each for each in example_criterion(plugin, robot).parameters(robot) if f"`{each}`" not in section]
    assert not missing, missing


def test_names_in_the_table_are_sections() -> None:
    assert set(re.findall(r"\]\(#(\w+)\)", TEXT)) <= set(SECTIONS)

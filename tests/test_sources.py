"""The sources of the derivations: which of them were read is marked, and the mark is explained once."""

from __future__ import annotations

from pathlib import Path

import pytest

DERIVATIONS = sorted((Path(__file__).parents[1] / "formulations").glob("*.md"))
MARK = "[seen]"
SEEN = ("Das, Slotine and Sheridan", "mink", "pink", "Corke's Robotics Toolbox")
"""What was read: the paper's text, code, documentation."""


def sources(path: Path) -> str:
    return " ".join(path.read_text(encoding="utf-8").partition("\n## Sources")[2].split())


def test_the_mark_is_explained_once() -> None:
    assert [
        path.name for path in DERIVATIONS if MARK in path.read_text(encoding="utf-8").partition("## Sources")[0]
    ] == ["README.md"]


@pytest.mark.parametrize("path", DERIVATIONS, ids=lambda path: path.stem)
def test_only_what_was_read_has_the_mark_and_the_paper_always_has_it(path: Path) -> None:
    text = sources(path)
    for before in text.split(MARK)[:-1]:
        assert any(name in before[-100:] for name in SEEN)
    for after in text.split("Das, Slotine and Sheridan")[1:]:
        assert MARK in after[:80]

"""The examples of docs/guides/view.md run."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import jtik

pytest.importorskip("viser")
pytest.importorskip("matplotlib")
image = pytest.importorskip("PIL.Image")

PAGE = Path(__file__).parents[1] / "docs" / "guides" / "view.md"
LARGEST = 200_000
"""Size of a picture of the docs [bytes]."""


@pytest.mark.slow
def test_the_examples(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for code in re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL):
        exec(code, names)
    assert "closed" in repr(names["viewer"])
    assert isinstance(names["solution"], jtik.Solution)
    with image.open(tmp_path / "arm.gif") as gif:
        assert gif.n_frames > 20


def test_the_picture_is_small() -> None:
    assert PAGE.with_name("view.png").stat().st_size < LARGEST

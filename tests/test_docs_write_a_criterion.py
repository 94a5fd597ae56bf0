"""The examples of docs/guides/write_a_criterion.md run, and their criteria fulfil the contract."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import jtik
from jtik.testing import check_criterion

TEXT = (Path(__file__).parents[1] / "docs" / "guides" / "write_a_criterion.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_examples() -> None:
    names: dict[str, object] = {}
    for code in re.findall(r"```python\n(.*?)```", TEXT, flags=re.DOTALL):
        exec(code, names)
    for name in ("elbow_height", "far_from_singular", "elbow_near", "clear_of_wall"):
        criterion = names[name]
        assert isinstance(criterion, jtik.Criterion)
        check_criterion(criterion, jtik.Robot.planar(4), samples=3)
    assert "Where Elbows Should Be" in jtik.citations(names["elbow_near"])

"""The Python of the README and of docs/guide.md runs as it stands there, with fewer problems."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import matplotlib
import pytest

import jtik

ROOT = Path(__file__).parents[1]
SHORTER = [
    ("range(1000)", "range(20)"),
    ('"reachable": 20', '"reachable": 2'),
    ('"near_singular": 20', '"near_singular": 2'),
]


def run(page: str) -> dict[str, Any]:
    """The names after all Python blocks of a page, run in its order."""
    text = (ROOT / page).read_text(encoding="utf-8")
    names: dict[str, Any] = {}
    for code in re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL):
        for old, new in SHORTER:
            code = code.replace(old, new)
        exec(code, names)
    return names


def test_the_readme(capsys: pytest.CaptureFixture[str]) -> None:
    names = run("README.md")
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    printed = capsys.readouterr().out.splitlines()
    shown = re.findall(r"```text\n(.*?)```", text, flags=re.DOTALL)[0].splitlines()
    assert printed[0] == shown[0]
    assert printed[1] == shown[1]
    assert names["ik"].parameters["elbow_height.height"] == -1.0


@pytest.mark.slow
def test_the_guide(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    matplotlib.use("agg")
    names = run("docs/guide.md")
    assert names["solution"].converged
    assert names["path"].converged
    assert (tmp_path / "path.csv").is_file()
    assert isinstance(names["comparison"], jtik.Comparison)

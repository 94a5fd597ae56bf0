"""What the tests of the command line share."""

from __future__ import annotations

import builtins
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jtik
from jtik.cli import main

Capture = pytest.CaptureFixture[str]


PROBLEM = """
target = [2.0, 1.5]
q0 = [0.4, 0.3, 0.2, 0.1]

[robot]
kind = "planar"
links = [1.0, 0.8, 0.6, 0.4]
lower = -2.0
upper = 2.0

[strategy]
name = "hybrid"
q_limit = 0.25

[task]
frame = "tip"

[[criteria]]
name = "joint_centering"
weight = 0.5
options = { stiffness = 2.0 }

[[criteria]]
name = "obstacle_avoidance"
weight = 0.1
options = { bodies = "both" }

[obstacles]
circles = [[1.0, -1.0, 0.3]]
points = [[0.5, 2.0]]

[solve]
max_iterations = 500
"""


@pytest.fixture
def problem_file(tmp_path: Path) -> Path:
    file = tmp_path / "problem.toml"
    file.write_text(PROBLEM)
    return file


def refusal(capture: Capture, *words: str) -> str:
    """The line on stderr of a command that must be refused."""
    assert main(words) == 2
    out, err = capture.readouterr()
    assert out == ""
    assert err.startswith("jtik: ")
    assert err.count("\n") == 1
    return err


def solved(capture: Capture, line: str, *words: str, code: int = 0) -> dict[str, Any]:
    """The JSON that ``jtik solve`` prints for a line of options, and words that may hold blanks."""
    assert main(["solve", *line.split(), *words, "--json"]) == code
    return dict(json.loads(capture.readouterr().out))


def position(robot: jtik.Robot, document: dict[str, Any]) -> np.ndarray:
    return np.asarray(robot.position(document["q"]))


def without(monkeypatch: pytest.MonkeyPatch, package: str) -> None:
    """As if the package were not installed."""
    real = builtins.__import__

    def fake(name: str, *arguments: Any, **options: Any) -> Any:
        if name.partition(".")[0] == package:
            raise ImportError(name)
        return real(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", fake)

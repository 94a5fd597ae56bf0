"""Criteria of the user's own, as ``module.py:name``."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

import jtik
from jtik.cli import main, own_criteria

from .conftest import Capture, refusal, solved

OWN = """
import jtik
from helper import HEIGHT
from jtik import Criterion

@jtik.criterion
def height(q, robot, *, at=HEIGHT):
    return (robot.position(q, "link4")[1] - at) ** 2

class Straight(Criterion):
    name = "straight"
    def __init__(self, *, gain=1.0):
        self._gain = gain
    def parameters(self, robot):
        return {"gain": self._gain}
    def value(self, kinematics, parameters):
        return parameters["gain"] * sum(kinematics.q[i] ** 2 for i in range(5))

straight = Straight(gain=0.5)

def bare(q, robot):
    return 0
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.delitem(sys.modules, "helper", raising=False)
    (tmp_path / "helper.py").write_text("HEIGHT = 0.7\n")
    (tmp_path / "own.py").write_text(OWN)
    return str(tmp_path / "own.py")


LINE = "--robot planar:5 --target 3 2 --q0 0.3 0.3 0.3 0.3 0.3 --criterion"


def test_a_decorated_function(capsys: Capture, file: str) -> None:
    document = solved(capsys, LINE, f"{file}:height=2.5")
    assert list(document["criteria"]) == ["height"]
    assert jtik.Robot.planar(5).position(document["q"], "link4")[1] == pytest.approx(0.7, abs=1e-5)


@pytest.mark.parametrize(("name", "gain"), [("Straight", 1.0), ("straight", 0.5)])
def test_a_class_or_an_object(capsys: Capture, file: str, name: str, gain: float) -> None:
    document = solved(capsys, LINE, f"{file}:{name}=3")
    assert document["criteria"]["straight"] == pytest.approx(3 * gain * sum(q**2 for q in document["q"]))


@pytest.mark.parametrize(("name", "options"), [("height", {"at": 0.4}), ("Straight", {"gain": 2.0}), ("straight", {})])
def test_a_problem_file_names_it_from_its_own_folder(
    capsys: Capture, file: str, name: str, options: dict[str, float]
) -> None:
    problem = Path(file).with_name("problem.json")
    criterion = {"name": f"own.py:{name}", "options": options}
    problem.write_text(json.dumps({"robot": "planar:5", "target": [3, 2], "criteria": [criterion]}))
    document = solved(capsys, f"--file {problem}")
    if name == "height":
        assert jtik.Robot.planar(5).position(document["q"], "link4")[1] == pytest.approx(0.4, abs=1e-5)


@pytest.mark.slow
def test_processes_of_a_study_know_it(capsys: Capture, file: str, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    study = "compare --robot planar:5 --strategies hybrid --problems reachable:2 --repeats 1 --jobs 2 --json"
    assert main([*study.split(), "--criterion", f"{file}:height", "--out", f"{tmp_path}/r.html"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["table"]
    assert row["success [%]"] == 100
    assert row["H"] >= 0


def test_a_file_is_run_once(file: str) -> None:
    assert own_criteria.load_module(file) is own_criteria.load_module(file)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("own.py:heights", "did you mean 'height'"),
        ("own.py:bare", "@jtik.criterion"),
        ("own.py:HEIGHT", "@jtik.criterion"),
        ("none.py:height", "no such file"),
        ("syntax.py:f", "SyntaxError"),
        ("raises.py:f", "nothing_here"),
        ("exits.py:f", "SystemExit"),
    ],
)
def test_other_names_are_refused_in_one_line(capsys: Capture, file: str, name: str, said: str) -> None:
    folder = Path(file).parent
    (folder / "syntax.py").write_text("def f(:\n")
    (folder / "raises.py").write_text("import nothing_here\n")
    (folder / "exits.py").write_text("raise SystemExit(3)\n")
    assert said in refusal(capsys, "solve", *LINE.split(), f"{folder}/{name}")

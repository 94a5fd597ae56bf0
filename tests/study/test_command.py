"""``jtik compare``: table, report and rows from the command line."""

from __future__ import annotations

import csv

import pytest

from jtik.cli import main
from jtik.study import Comparison

pytest.importorskip("matplotlib")
pytest.importorskip("rich")


def test_the_command_prints_a_table_and_writes_files(tmp_path, capsys) -> None:
    files = {name: str(tmp_path / name) for name in ("r.html", "rows.csv", "study.npz")}
    words = [
        "compare",
        "--robot",
        "planar:3",
        "--strategies",
        "hybrid",
        "nobody",
        "--problems",
        "reachable:2",
        "line:1",
    ]
    words += ["--out", files["r.html"], "--csv", files["rows.csv"], "--save", files["study.npz"], "--repeats", "1"]
    assert main(words) == 0
    message = capsys.readouterr().out
    assert "hybrid" in message
    assert "unknown strategy 'nobody'" in message
    with open(files["rows.csv"], encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["contender"] for row in rows] == ["hybrid"] * 3 + ["nobody"] * 3
    assert all(row["success"] == "True" for row in rows[:3])
    assert Comparison.load(files["study.npz"]).columns["case"].tolist() == [row["case"] for row in rows]
    assert "<svg" not in (page := (tmp_path / "r.html").read_text(encoding="utf-8"))
    assert "data:image/svg+xml" in page
    assert main(words) == 0  # resumes a complete study


def test_a_named_problem_sets_robot_task_and_criterion(tmp_path, capsys) -> None:
    words = ["compare", "--problems", "named:centering_3r", "--strategies", "newton", "--until", "stationary"]
    assert main([*words, "--markdown", "--repeats", "1", "--out", str(tmp_path / "r.html")]) == 0
    assert "| newton |" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--problems", "nothing"], "unknown kind of problems 'nothing'"),
        (["--problems", "reachable:many"], "KIND or KIND:COUNT"),
        (["--problems", "named:nothing"], "unknown problem 'nothing'"),
        (["--problems", "named:centering_3r", "--robot", "planar:2"], "alone"),
        (["--jobs", "0"], "--jobs 0"),
        (["--count", "0"], "count"),
        (["--out", "/nowhere/at/all.html"], "no such folder"),
        (["--robot", "nobot"], "nobot"),
        (["--problems", "scene"], "distances to obstacles"),
    ],
)
def test_invalid_options_are_explained(words: list[str], message: str, capsys) -> None:
    assert main(["compare", *words]) == 2
    assert message in capsys.readouterr().err

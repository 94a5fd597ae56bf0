"""``jtik compare``: table, report and rows from the command line."""

from __future__ import annotations

import csv
import importlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import jtik
from jtik.cli import main
from jtik.study import Comparison, html

from .conftest import Capture, refusal

pytest.importorskip("matplotlib")
pytest.importorskip("rich")


@pytest.mark.slow
def test_the_command_prints_a_table_and_writes_files(tmp_path, capsys, monkeypatch) -> None:
    # one picture in the report; tests/study/test_html.py has all of them
    monkeypatch.setattr(html, "_figures", lambda comparison: [("Profile", comparison.plot_profile())])
    files = {name: str(tmp_path / name) for name in ("r.html", "rows.csv", "study.npz")}
    words = [
        "compare",
        "--robot",
        "planar:3",
        "--strategies",
        "hybrid",
        "peer:rtb",
        "--problems",
        "reachable:2",
        "line:1",
    ]
    words += ["--out", files["r.html"], "--csv", files["rows.csv"], "--save", files["study.npz"], "--repeats", "1"]
    assert main(words) == 0
    message = capsys.readouterr().out
    assert "hybrid" in message
    with open(files["rows.csv"], encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["contender"] for row in rows] == ["hybrid"] * 3 + ["peer:rtb"] * 3
    assert all(row["success"] == "True" for row in rows[:3])
    assert Comparison.load(files["study.npz"]).columns["case"].tolist() == [row["case"] for row in rows]
    assert "<svg" not in (page := (tmp_path / "r.html").read_text(encoding="utf-8"))
    assert "data:image/svg+xml" in page
    assert main(words) == 0  # resumes a complete study


@pytest.mark.usefixtures("short_report")
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
        (["--problems", "reachable:" + "9" * 5000], "KIND or KIND:COUNT"),
        (["--strategies", "hybrid", "nobody"], "unknown strategy 'nobody'"),
        (["--strategy", "newton+nobody"], "unknown secondary term 'nobody'"),
        (["--strategies", "peer:nobody"], "unknown peer 'nobody'"),
        (["--plot", "picture.bmp"], ".png, .svg, .pdf"),
        (["--plot", "/nowhere/at/all.png"], "no such folder"),
        (["--criterion", "none.py:height"], "no such file"),
    ],
)
def test_invalid_options_are_explained_before_the_first_solve(
    words: list[str], message: str, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(jtik.InverseKinematics, "solve", lambda *arguments, **options: pytest.fail("solves"))
    assert message in refusal(capsys, "compare", *words)


STUDY = (
    "compare --robot planar:4 --kind pose --problems reachable:2 --criterion joint_centering --repeats 1 --strategies"
)


@pytest.fixture
def short_report(monkeypatch: pytest.MonkeyPatch) -> None:
    """The report is a file of one word, where a test is not about its pictures."""
    monkeypatch.setattr(Comparison, "to_html", lambda comparison, path: Path(path).write_text("report"))


@pytest.mark.quick(1)
@pytest.mark.usefixtures("short_report")
@pytest.mark.parametrize("columns", ["80", "100", "60"])
def test_the_table_fits_and_names_what_it_leaves_out(tmp_path, capsys, monkeypatch, columns: str) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    words = [*STUDY.split(), "hybrid", "weighted_least_norm", "--out", str(tmp_path / "r.html")]
    assert main([*words, "--csv", str(tmp_path / "rows.csv"), "--save", str(tmp_path / "study.npz")]) == 0
    out = capsys.readouterr().out
    lines = [line for line in out.splitlines() if not line.startswith("written: ")]
    assert max(map(len, lines)) <= int(columns)
    found = Comparison.load(tmp_path / "study.npz")
    left_out = " ".join(out.partition("left out: ")[2].split())
    head = lines[1 : lines.index(next(line for line in lines if line.startswith("hybrid")))]
    shown = {word for line in head for word in line.split()}
    for title in found.summary():
        name, _, unit = title.partition(" [")
        assert set(name.split() if len(name) > 9 else [name]) <= shown or title in left_out, unit
    with open(tmp_path / "rows.csv", encoding="utf-8", newline="") as file:
        assert next(csv.reader(file)) == list(found.columns)


@pytest.mark.slow
def test_a_pipe_has_80_columns(tmp_path) -> None:
    words = [sys.executable, "-m", "jtik", *STUDY.split(), "hybrid", "damped", "--out", str(tmp_path / "r.html")]
    root = Path(jtik.__file__).parents[1]
    environment = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
    environment["PYTHONPATH"] = os.pathsep.join([str(root), str(root / "formulations"), *sys.path])
    run = subprocess.run(words, capture_output=True, text=True, check=True, env=environment)
    lines = run.stdout.splitlines()
    assert max(map(len, lines[:-1])) <= 80
    assert lines[-1].startswith("written: ")
    assert run.stderr == ""


@pytest.mark.usefixtures("short_report")
def test_json_has_all_columns_and_nothing_else_is_on_stdout(tmp_path, capsys) -> None:
    words = [*STUDY.split(), "hybrid", "damped", "--json", "--out", str(tmp_path / "r.html")]
    assert main([*words, "--save", str(tmp_path / "study.npz")]) == 0
    out, err = capsys.readouterr()
    document = json.loads(out, parse_constant=pytest.fail)
    summary = Comparison.load(tmp_path / "study.npz").summary()
    assert [row["contender"] for row in document["table"]] == ["hybrid", "damped"]
    assert list(document["table"][0]) == list(summary)
    assert [row["iterations"] for row in document["table"]] == [
        None if value != value else value for value in summary["iterations"]
    ]
    assert document["complete"] is True
    assert err.startswith("written: ")


@pytest.mark.slow
@pytest.mark.usefixtures("short_report")
def test_a_picture_of_profiles(tmp_path, capsys) -> None:
    words = [*STUDY.split(), "hybrid", "damped", "--out", str(tmp_path / "r.html")]
    assert main([*words, "--plot", str(tmp_path / "profile.png")]) == 0
    assert (tmp_path / "profile.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.usefixtures("short_report")
def test_a_file_that_cannot_be_written_costs_no_study(tmp_path, capsys) -> None:
    (tmp_path / "rows.csv").mkdir()
    words = [*STUDY.split(), "hybrid", "--csv", str(tmp_path / "rows.csv"), "--out", str(tmp_path / "r.html")]
    assert main(words) == 1
    out, err = capsys.readouterr()
    assert "hybrid" in out
    assert "rows.csv: Is a directory" in err
    assert (tmp_path / "r.html").exists()


@pytest.mark.usefixtures("short_report")
def test_what_was_done_before_an_interrupt_is_shown_and_written(tmp_path, capsys, monkeypatch) -> None:
    def interrupted(units, progress, label):
        yield next(iter(units))
        raise KeyboardInterrupt

    monkeypatch.setattr(importlib.import_module("jtik.study.compare"), "watched", interrupted)
    words = [
        *STUDY.replace("reachable:2", "reachable:21").split(),
        "damped",
        "--json",
        "--out",
        str(tmp_path / "r.html"),
    ]
    assert main([*words, "--csv", str(tmp_path / "rows.csv")]) == 130
    document = json.loads(capsys.readouterr().out)
    assert document["complete"] is False
    (row,) = document["table"]
    assert (tmp_path / "r.html").exists()
    assert len((tmp_path / "rows.csv").read_text().splitlines()) == row["cases"] + 1 < 22

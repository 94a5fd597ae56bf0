"""The command line as a whole: wrong input, warnings, interrupts and pipes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import jtik
from jtik.cli import main

from .conftest import Capture, refusal, without


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("solve --target 1 1", "robot is missing"),
        ("solve --robot planar:3", "target is missing"),
        ("solve --robot moon:3 --target 1 1", "planar:10"),
        ("solve --robot pnada --target 1 1 1", "did you mean 'panda'"),
        ("solve --robot planar: --target 1 1", "planar:10"),
        ("solve --robot planar:0 --target 1 1", "links"),
        ("solve --robot planar:3 --target 1", "target: given [1.0]"),
        ("solve --robot planar:3 --target 1 here", "'here'"),
        ("solve --robot planar:3 --target nan 1", "finite"),
        ("solve --robot planar:3 --target 1 1 --q0 1", "q0: given shape (1,)"),
        ("solve --robot planar:3 --target 1 1 --strategy hybird", "did you mean 'hybrid'"),
        (
            "solve --robot planar:3 --target 1 1 --strategy newton+qpp",
            "secondary term 'qpp'; did you mean 'qp'",
        ),
        (
            "solve --robot planar:3 --target 1 1 --strategy weighted_qp+qp",
            "a strategy with a secondary term before '+'",
        ),
        ("compare --robot planar:3 --jobs 0", "--jobs 0: accepted: a positive integer"),
        ("solve --robot planar:3 --target 1 1 --criterion joint_center=1", "did you mean 'joint_centering'"),
        (
            "solve --robot planar:3 --target 1 1 --criterion joint_centering=much",
            "NAME=WEIGHT, a finite number",
        ),
        ("solve --robot planar:3 --target 1 1 --criterion joint_centering=nan", "weight: given nan"),
        ("solve --robot planar:3 --target 1 1 --criterion obstacle_avoidance", "--circle"),
        ("solve --robot planar:3 --target 1 1 --circle 1 1 -1", "radius"),
        ("solve --robot planar:3 --target 1 1 --point 1", "center"),
        ("solve --robot planar:3 --target 1 1 --frame hand", "unknown frame 'hand'"),
        ("solve --robot planar:3 --target 1 1 --until tired", "stationary"),
        ("solve --robot planar:3 --target 1 1 --max-iterations -1", "max_iterations"),
        ("solve --robot planar:3 --target 1 1 --trace /no/such/folder/trace.csv", "no such folder"),
        ("solve --file /no/such/problem.toml", "no such file"),
        ("solve --file problem.yaml", ".toml or .json"),
        ("solve --robot planar:3 --target 1 1 --colour red", "--colour"),
        ("solve --robot planar:3 --target 1 1 --q0 middle", "did you mean 'mid'"),
        ("solve --robot planar:3 --target 1 1 --q0 1 x 1", "'x'"),
        ("solve --robot planar:3 --target @/no/such/file", "no such file"),
        ("solve --robot planar:3 --target @/dev/zero", "not a file"),
        ("solve --robot planar:3 --target 1 1 --restarts -1", "restarts: given -1"),
        ("solve --robot planar:3 --target 1 1 --restarts many", "--restarts"),
        ("solve --robot planar:3 --target 1 1 --best-of 0", "best_of: given 0"),
        ("solve --robot planar:3 --target 1 1 --seed -1", "seed"),
        ("solve --robot planar:3 --target 1 1 --strategy hybrid+qp --criterion joint_centering --solver no", "'no'"),
        ("solve --robot planar:3 --target 1 1 --obstacle 1 --criterion obstacle_avoidance", "x, y, radius"),
        ("solve --robot planar:3 --target 1 1 --plot picture.bmp", ".png, .svg, .pdf"),
        ("solve --robot planar:3 --target 1 1 --out solution.txt", ".json, .csv"),
        ("solve --robot planar:3 --target 1 1 --out /no/such/folder/a.csv", "no such folder"),
        ("robot", "ROBOT"),
        ("robot pnada", "did you mean 'panda'"),
        ("robot none.urdf", "none.urdf"),
        ("robot panda --chek", "--chek"),
        ("demo --out /dev/null/demo", "/dev/null/demo"),
        ("dance", "'dance'"),
        ("", "command"),
    ],
)
def test_wrong_input_is_refused_in_one_line(capsys: Capture, words: str, said: str) -> None:
    assert said in refusal(capsys, *words.split())


def test_demo_without_rich_names_the_extra(capsys: Capture, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    without(monkeypatch, "rich")
    assert "pip install 'jtik[demo]'" in refusal(capsys, "demo", "--out", str(tmp_path))


def test_python_m_jtik_is_the_command_line() -> None:
    words = [sys.executable, "-W", "error", "-m", "jtik", "--version"]
    root = Path(jtik.__file__).parents[1]
    result = subprocess.run(words, capture_output=True, text=True, cwd=root, check=True)
    assert result.stdout.strip() == f"jtik {jtik.__version__}"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("deep.json", "[" * 200_000),
        ("deeper.json", '{"robot": "planar:3", "target": ' + "[" * 900 + "]" * 900 + "}"),
        ("deep.toml", 'robot = "planar:3"\ntarget = ' + "[" * 200_000),
        ("key.toml", ".".join(["a"] * 200_000) + " = 1\n"),
        ("header.toml", f"[{'.'.join(['a'] * 200_000)}]\n"),
        ("inline.toml", f"solve = {{ {'.'.join(['a'] * 200_000)} = 1 }}\n"),
        ("digits.json", '{"robot": "planar:3", "target": [1, ' + "9" * 5000 + "]}"),
        ("links.json", '{"robot": {"kind": "planar", "links": ' + "9" * 300 + '}, "target": [1, 1]}'),
        ("long.json", '{"robot": "planar:3", "target": [' + ", ".join(["1"] * 100_000) + "]}"),
        ("large.json", " " * 10_000_001),
    ],
)
def test_a_file_made_to_break_it_is_refused_in_one_line(capsys: Capture, tmp_path: Path, name: str, text: str) -> None:
    (tmp_path / name).write_text(text)
    assert len(refusal(capsys, "solve", "--file", str(tmp_path / name))) < 2000


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_what_is_no_file_is_not_read(capsys: Capture, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.json")
    assert "not a file" in refusal(capsys, "solve", "--file", str(tmp_path / "pipe.json"))


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (KeyboardInterrupt(), 130, "interrupted"),
        (MemoryError(), 2, "memory"),
        (RecursionError(), 2, "nested too deeply"),
        (OSError(28, "No space left on device"), 2, "No space left"),
    ],
)
def test_what_a_command_raises_is_one_line(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch, error: BaseException, code: int, said: str
) -> None:
    def raises(*arguments: Any, **options: Any) -> None:
        raise error

    monkeypatch.setattr(jtik.InverseKinematics, "solve", raises)
    assert main(["solve", "--robot", "planar:3", "--target", "1", "1"]) == code
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert err.count("\n") == 1


@pytest.mark.slow
def test_a_reader_that_ends_early_is_no_error() -> None:
    root = Path(jtik.__file__).parents[1]
    path = os.pathsep.join([str(root), str(root / "formulations"), *sys.path])
    words = [sys.executable, "-m", "jtik", "list", "--json"]
    with subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env={**os.environ, "PYTHONPATH": path}
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 141

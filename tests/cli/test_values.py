"""Targets and starts on the command line: numbers, names and files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import jtik

from .conftest import Capture, position, refusal, solved

PANDA = jtik.Robot.builtin("panda")
POSE = PANDA.pose(PANDA.home + 0.1)


def words(numbers: object) -> list[str]:
    return [repr(float(number)) for number in np.ravel(np.asarray(numbers))]


def test_sixteen_numbers_are_a_pose_row_by_row(capsys: Capture) -> None:
    document = solved(capsys, "--robot panda --target", *words(POSE))
    assert PANDA.pose(document["q"]) == pytest.approx(POSE, abs=3e-6)


def test_seven_numbers_are_a_pose(capsys: Capture) -> None:
    document = solved(capsys, "--robot panda --restarts 20 --target 0.4 0.2 0.5 0 1 0 0")
    expected = [[1, 0, 0, 0.4], [0, -1, 0, 0.2], [0, 0, -1, 0.5], [0, 0, 0, 1]]
    assert PANDA.pose(document["q"]) == pytest.approx(np.array(expected), abs=3e-6)


def test_another_kind_prevails(capsys: Capture) -> None:
    document = solved(capsys, "--robot panda --kind position --target 0.4 0.2 0.5 0 1 0 0")
    assert position(PANDA, document) == pytest.approx([0.4, 0.2, 0.5], abs=2e-6)
    assert document["orientation_error"] == 0
    assert document["unused"]


def test_three_numbers_are_a_position_in_space(capsys: Capture) -> None:
    document = solved(capsys, "--robot panda --target 0.4 0.2 0.5")
    assert position(PANDA, document) == pytest.approx([0.4, 0.2, 0.5], abs=2e-6)


def test_nine_numbers_are_a_rotation(capsys: Capture) -> None:
    document = solved(capsys, "--robot panda --kind orientation --target", *words(POSE[:3, :3]))
    assert PANDA.pose(document["q"])[:3, :3] == pytest.approx(POSE[:3, :3], abs=3e-6)


TEXTS = {
    "rows.txt": "\n".join(" ".join(words(row)) for row in POSE) + "\n# a comment\n",
    "printed.txt": str(POSE.tolist()),
    "commas.csv": ", ".join(words(POSE)),
    "target.json": json.dumps(POSE.tolist()),
}


@pytest.mark.quick(2)
@pytest.mark.parametrize("name", TEXTS)
def test_a_target_comes_from_a_file(capsys: Capture, tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(TEXTS[name])
    document = solved(capsys, "--robot panda --target", f"@{tmp_path / name}")
    assert PANDA.pose(document["q"]) == pytest.approx(POSE, abs=3e-6)


def test_targets_by_name_come_from_json(capsys: Capture, tmp_path: Path) -> None:
    (tmp_path / "problem.toml").write_text(
        'robot = "planar:4"\n[[task]]\nframe = "tip"\n[[task]]\nframe = "link3"\nname = "elbow"\n'
    )
    (tmp_path / "target.json").write_text('{"tip": [1.5, 1.0], "elbow": [0.5, 1.2]}')
    document = solved(capsys, f"--file {tmp_path}/problem.toml --target @{tmp_path}/target.json")
    arm = jtik.Robot.planar(4)
    assert arm.position(document["q"]) == pytest.approx([1.5, 1.0], abs=2e-6)
    assert arm.position(document["q"], "link3") == pytest.approx([0.5, 1.2], abs=2e-6)


HERE = [0.1, -0.2, 0.3, -1.5, 0.2, 1.5, 0.4]

STARTS = {
    "home": PANDA.home,
    "mid": (PANDA.lower + PANDA.upper) / 2,
    "numbers": np.array(HERE),
    "file": np.array(HERE),
}


@pytest.mark.parametrize("name", STARTS)
def test_a_start_is_numbers_a_name_or_a_file(capsys: Capture, tmp_path: Path, name: str) -> None:
    """Without an iteration, the answer is the start."""
    (tmp_path / "q0.txt").write_text(" ".join(words(HERE)))
    given = {"numbers": words(HERE), "file": [f"@{tmp_path}/q0.txt"]}.get(name, [name])
    document = solved(capsys, "--robot panda --target 2 2 2 --max-iterations 0 --q0", *given, code=1)
    assert document["q"] == pytest.approx(STARTS[name].tolist(), abs=1e-15)


def test_the_middle_of_no_limits_is_home(capsys: Capture) -> None:
    document = solved(capsys, "--robot vehicle:2 --target 9 9 --max-iterations 0 --q0 mid", code=1)
    assert document["q"] == jtik.Robot.vehicle(2).home.tolist()


MODEL = """
<mujoco><compiler angle="radian"/><worldbody><body name="a"><joint name="j" range="-1 1"/><geom size="0.1"/>
<body name="hand" pos="0.5 0 0"><joint name="k" axis="0 1 0"/><geom size="0.1"/></body></body></worldbody>
<keyframe><key name="ready" qpos="0.3 0.4"/></keyframe></mujoco>
"""


def test_a_start_is_a_keyframe_of_the_robot(capsys: Capture, tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text(MODEL)
    line = f"--robot {tmp_path}/arm.xml --target 2 2 2 --max-iterations 0 --q0"
    assert solved(capsys, line, "ready", code=1)["q"][0] == 0.3
    assert "ready" in refusal(capsys, "solve", *line.split(), "redy")


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("t.json", "[" * 100_000, "not valid JSON"),
        ("t.json", "[1, 2", "not valid JSON"),
        ("t.json", '"left"', "target"),
        ("t.txt", "1 left", "'left'"),
        ("t.txt", "", "target"),
        ("t.txt", "\udcff", "UTF-8"),
        ("t.txt", "1 " * 6_000_000, "larger than 10 MB"),
    ],
)
def test_other_files_are_refused_in_one_line(
    capsys: Capture, tmp_path: Path, name: str, content: str, said: str
) -> None:
    (tmp_path / name).write_bytes(content.encode("utf-8", "surrogateescape"))
    assert said in refusal(capsys, "solve", "--robot", "planar:3", "--target", f"@{tmp_path / name}")

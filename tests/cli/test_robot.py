"""``jtik robot``: what a robot has, and what was ignored in its file."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

import jtik
from jtik.cli import main

from .conftest import Capture

FOLLOWER = """
<robot name="gripper"><link name="base"/><link name="left"/><link name="right"/><link name="lost"/>
<joint name="finger" type="prismatic"><parent link="base"/><child link="left"/><axis xyz="0 1 0"/>
<limit lower="0" upper="0.04" velocity="0.2" effort="1"/></joint>
<joint name="other" type="prismatic"><parent link="base"/><child link="right"/><axis xyz="0 -1 0"/>
<limit lower="-0.04" upper="0.04" velocity="0.2" effort="1"/>
<mimic joint="finger" multiplier="-1" offset="0.01"/></joint>
<joint name="stray" type="revolute"><parent link="right"/><child link="lost"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="0.2" effort="1"/>MIMIC</joint></robot>
"""

IGNORED = FOLLOWER.replace("MIMIC", '<mimic joint="nobody"/>')
"""A joint that mimics one that there is not is independent, which is a warning."""


@pytest.fixture
def files(tmp_path: Path) -> Path:
    (tmp_path / "whole.urdf").write_text(FOLLOWER.replace("MIMIC", ""))
    (tmp_path / "ignored.urdf").write_text(IGNORED)
    return tmp_path


def test_every_joint_limit_frame_and_the_tip_are_shown(capsys: Capture) -> None:
    panda = jtik.Robot.builtin("panda")
    assert main(["robot", "panda"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    lines = out.splitlines()
    for i, name in enumerate(panda.joint_names):
        (line,) = [line for line in lines if line.startswith(f"{name} ")]
        assert f"{panda.lower[i]:.5g}" in line
        assert f"{panda.upper[i]:.5g}" in line
    assert all(frame in out for frame in panda.frame_names)
    assert f"tip {panda.tip}" in out
    assert "keyframes: home" in out
    assert "ignored: nothing" in out


def test_followers_are_shown(capsys: Capture, files: Path) -> None:
    assert main(["robot", str(files / "whole.urdf")]) == 0
    assert "-1 finger +0.01" in capsys.readouterr().out


def test_what_was_ignored_is_listed(capsys: Capture, files: Path) -> None:
    assert main(["robot", str(files / "ignored.urdf")]) == 0
    out, err = capsys.readouterr()
    assert "stray" in out.partition("ignored:")[2]
    assert err == ""


@pytest.mark.parametrize(("name", "code"), [("whole.urdf", 0), ("ignored.urdf", 1)])
def test_check_ends_with_1_for_warnings(capsys: Capture, files: Path, name: str, code: int) -> None:
    assert main(["robot", str(files / name), "--check"]) == code


def test_json_has_everything(capsys: Capture, files: Path) -> None:
    assert main(["robot", str(files / "ignored.urdf"), "--json", "--check"]) == 1
    document = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    with pytest.warns(UserWarning, match="stray"):
        robot = jtik.Robot.from_urdf(files / "ignored.urdf")
    assert document["tip"] == robot.tip
    assert document["frames"] == list(robot.frame_names)
    assert [joint["name"] for joint in document["joints"]] == [joint.name for joint in robot.joints]
    for shown, joint in zip(document["joints"], robot.joints, strict=True):
        for key in ("lower", "upper"):
            value = getattr(joint, key)
            assert shown[key] == (value if math.isfinite(value) else None)
    assert document["joints"][1]["mimic"] == {"joint": "finger", "multiplier": -1.0, "offset": 0.01}
    assert len(document["ignored"]) == 1


def test_a_warning_is_a_line_on_stderr_elsewhere(capsys: Capture, files: Path) -> None:
    words = ["solve", "--robot", str(files / "ignored.urdf"), "--frame", "left", "--axes", "y", "--json"]
    assert main([*words, "--target", "0", "0.02", "0"]) == 0
    out, err = capsys.readouterr()
    json.loads(out)
    assert err.startswith("jtik: warning: ")
    assert "stray" in err
    assert err.count("\n") == 1
    assert ".py" not in err


@pytest.mark.parametrize("robot", ["panda", "jaco2", "vehicle_panda", "planar:20"])
def test_lines_fit_80_columns(capsys: Capture, monkeypatch: pytest.MonkeyPatch, robot: str) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["robot", robot]) == 0
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 80

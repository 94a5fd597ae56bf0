"""Robots of a command or of a document."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jtik
from jtik.cli.document import load, read

from .conftest import Capture, position, refusal, solved


@pytest.mark.parametrize(
    ("specification", "robot"),
    [
        ("planar:3", jtik.Robot.planar(3)),
        ("planar:1,0.8,0.5", jtik.Robot.planar([1, 0.8, 0.5])),
        ("planar:2.5", jtik.Robot.planar([2.5])),
        ("vehicle:3", jtik.Robot.vehicle(3)),
        ("vehicle3", jtik.Robot.builtin("vehicle3")),
    ],
)
def test_robot_specifications(specification: str, robot: jtik.Robot) -> None:
    built = read({"robot": specification, "target": [1.0, 1.0]}).ik.robot
    q = np.linspace(0.2, 0.7, robot.nq)
    assert built.joint_names == robot.joint_names
    np.testing.assert_array_equal(built.position(q), robot.position(q))


def test_a_built_in_robot_is_named(capsys: Capture) -> None:
    start = " ".join(str(angle) for angle in jtik.Robot.builtin("panda").keyframes["home"])
    document = solved(capsys, f"--robot panda --target 0.4 0.2 0.5 --q0 {start}")
    panda = jtik.Robot.builtin("panda")
    assert document["joint_names"] == list(panda.joint_names)
    assert position(panda, document) == pytest.approx([0.4, 0.2, 0.5], abs=1e-6)
    built = read({"robot": {"kind": "builtin", "name": "panda"}, "target": [0.4, 0.2, 0.5]}).ik.robot
    assert built.frame_names == panda.frame_names


def test_dh_robots_come_from_a_file() -> None:
    rows = [{"a": 0.0, "alpha": 1.57, "d": 0.3}, {"a": 0.5, "alpha": 0.0}, [0.4, 0.0, 0.1, 0.2]]
    built = read({"robot": {"kind": "dh", "rows": rows, "convention": "modified"}, "target": [0.3, 0.3, 0.3]}).ik.robot
    q = [0.1, 0.2, 0.3]
    np.testing.assert_array_equal(built.pose(q), jtik.Robot.from_dh(rows, convention="modified").pose(q))


URDF = """
<robot name="arm"><link name="base"/><link name="upper"/><link name="wrist_link"/>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" velocity="1.5" effort="1"/></joint>
<joint name="slide" type="prismatic"><parent link="upper"/><child link="wrist_link"/><axis xyz="1 0 0"/>
<limit lower="0.2" upper="1.25" velocity="0.5" effort="1"/></joint></robot>
"""

MJCF = """
<mujoco model="arm"><compiler angle="radian"/>
<worldbody><body name="upper"><joint name="shoulder" range="-2 2"/><geom size="0.1"/>
<body name="wrist_link"><joint name="slide" type="slide" axis="1 0 0" range="0.2 1.25"/><geom size="0.1"/>
</body></body></worldbody></mujoco>
"""


@pytest.mark.parametrize(("suffix", "text"), [(".urdf", URDF), (".xml", MJCF)])
def test_a_file_is_read_by_its_suffix_and_its_tip_is_moved(
    capsys: Capture, tmp_path: Path, suffix: str, text: str
) -> None:
    file = tmp_path / f"arm{suffix}"
    file.write_text(text)
    document = solved(capsys, f"--robot {file} --axes x y --target 0.3 0.4 0")
    assert document["joint_names"] == ["shoulder", "slide"]
    assert document["q"] == pytest.approx([np.arctan2(0.4, 0.3), 0.5], abs=1e-5)


@pytest.mark.parametrize("robot", ["arm.urdf", {"kind": "urdf", "path": "arm.urdf", "tip": "upper"}])
def test_a_problem_file_names_it_from_its_own_folder(tmp_path: Path, robot: Any) -> None:
    (tmp_path / "arm.urdf").write_text(URDF)
    (tmp_path / "problem.json").write_text(json.dumps({"robot": robot, "target": [0.3, 0.4, 0]}))
    built = read(load(tmp_path / "problem.json")).ik.robot
    assert built.tip == ("wrist_link" if isinstance(robot, str) else "upper")


@pytest.mark.parametrize(
    ("specification", "said"),
    [
        ("planar:1000000000", "at most 1000 links"),
        ("vehicle:1001", "at most 1000 links"),
        ("planar:" + "9" * 5000, "robot: given"),
        ("planar:" + ",".join(["1"] * 1001), "at most 1000 links"),
        ("README.md", "robot: given"),
        ("no/panda", ".urdf, .xacro or .xml"),
        ("none.urdf", "No such file"),
        ("none.xml", "No such file"),
    ],
)
def test_other_robots_are_refused_in_one_line(capsys: Capture, specification: str, said: str) -> None:
    line = refusal(capsys, "solve", "--robot", specification, "--target", "1", "1")
    assert said in line
    assert len(line) < 2000


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"kind": "urdf"}, "path: given nothing"),
        ({"kind": "urdf", "path": 3}, "path: given 3"),
        ({"kind": "urdf", "path": "none.urdf"}, "none.urdf"),
        ({"kind": "mjcf", "path": "none.xml", "free_base": True}, "free_base"),
        ({"kind": "planar", "links": 10**300}, "at most 1000 links"),
        ({"kind": "planar", "links": [1.0] * 1001}, "at most 1000 links"),
        ({"kind": "dh", "rows": [[0, 0, 0, 0]] * 1001}, "at most 1000 links"),
    ],
)
def test_other_tables_are_refused_in_one_line(
    capsys: Capture, tmp_path: Path, table: dict[str, Any], said: str
) -> None:
    (tmp_path / "problem.json").write_text(json.dumps({"robot": table, "target": [1, 1]}))
    assert said in refusal(capsys, "solve", "--file", f"{tmp_path}/problem.json")

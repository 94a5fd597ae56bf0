"""Problem files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jtik
from jtik.cli import main
from jtik.cli.document import load, read

from .conftest import PROBLEM, Capture, position, refusal, solved


def test_a_file_describes_a_problem_completely(problem_file: Path) -> None:
    problem = read(load(problem_file))
    ik = problem.ik
    assert ik.robot.lower.tolist() == [-2.0] * 4
    assert ik.strategy == jtik.strategies["hybrid"](q_limit=0.25)  # type: ignore[call-arg]
    assert ik.parameters["joint_centering.weight"] == 0.5
    assert ik.parameters["joint_centering.stiffness"].tolist() == [2.0] * 4
    assert ik.parameters["obstacle_avoidance.centers"].tolist() == [[1.0, -1.0], [0.5, 2.0]]
    assert ik.parameters["obstacle_avoidance.radii"].tolist() == [0.3, 0.0]
    assert problem.options == {"max_iterations": 500, "q0": [0.4, 0.3, 0.2, 0.1]}


def test_json_and_toml_files_give_the_same_solution(capsys: Capture, problem_file: Path) -> None:
    as_json = problem_file.with_suffix(".json")
    as_json.write_text(json.dumps(load(problem_file)))
    first, second = (solved(capsys, "--file", str(file)) for file in (problem_file, as_json))
    assert {**first, "seconds": 0} == {**second, "seconds": 0}


def test_options_override_the_file(capsys: Capture, problem_file: Path) -> None:
    words = [
        "--file",
        str(problem_file),
        "--target",
        "1.5",
        "-1",
        "--criterion",
        "joint_centering",
        "--strategy",
        "newton",
    ]
    document = solved(capsys, *words)
    np.testing.assert_allclose(position(jtik.Robot.planar([1, 0.8, 0.6, 0.4]), document), [1.5, -1], atol=1e-6)
    assert list(document["criteria"]) == ["joint_centering"]
    assert document["strategy"].startswith("Newton")


@pytest.mark.parametrize("given", ["newton+qp", {"name": "newton+qp", "q_limit": 0.25}])
def test_a_strategy_is_paired_with_a_secondary_term(given: str | dict[str, Any]) -> None:
    strategy = read({"robot": "planar:3", "target": [1.0, 1.0], "strategy": given}).ik.strategy
    options = {} if isinstance(given, str) else {"q_limit": 0.25}
    assert strategy == jtik.strategies["newton"](secondary=jtik.secondaries["qp"](), **options)  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[task]", "[tsak]", "'task'"),
        ("frame =", "farme =", "'frame'"),
        ('kind = "planar"', 'kind = "plannar"', "'planar'"),
        ('kind = "planar"', "kind = [1]", "planar, vehicle, dh"),
        ('kind = "planar"', "", "given nothing"),
        ("links = [1.0, 0.8, 0.6, 0.4]", "", "links is missing"),
        ("links =", "lengths =", "known: links"),
        ("q_limit = 0.25", "radius = 0.25", "q_limit"),
        ("q_limit = 0.25", "q_limit = 'wide'", "q_limit: given wide; accepted: a positive, finite angle [rad]"),
        ('name = "hybrid"', "", "[strategy] name"),
        ("stiffness = 2.0", "stiffness = 'soft'", "stiffness: given soft"),
        ("stiffness = 2.0", "hardness = 2.0", "stiffness"),
        ("weight = 0.5", "weight = 'much'", "weight of joint_centering: given much; accepted: a finite number"),
        ('bodies = "both"', "obstacles = [[1, 2]]", "[obstacles]"),
        ("circles = [[1.0, -1.0, 0.3]]", "circles = [1.0, -1.0, 0.3]", "list of lists"),
        ("circles = [[1.0, -1.0, 0.3]]", "circles = [[1.0, -1.0]]", "radius"),
        ("circles =", "squares =", "circles"),
        ("max_iterations = 500", "iterations = 500", "max_iterations"),
        ("max_iterations = 500", "max_iterations = 'many'", "max_iterations"),
        ("max_iterations = 500", "limits = 'no'", "true or false"),
        ("target = [2.0, 1.5]", "target = 'left'", "target"),
        ("target = [2.0, 1.5]", "target = ", "not valid TOML"),
    ],
)
def test_wrong_files_are_refused_in_one_line(
    capsys: Capture, problem_file: Path, old: str, new: str, said: str
) -> None:
    assert old in PROBLEM
    problem_file.write_text(PROBLEM.replace(old, new, 1))
    assert said in refusal(capsys, "solve", "--file", str(problem_file))


SEVERAL = """
target = { tip = [1.5, 1.0], gaze = [3.0, 3.0] }

[robot]
kind = "planar"
links = 4

[[task]]
frame = "tip"

[[task]]
type = "look_at"
frame = "link3"
axis = [1.0, 0.0]
name = "gaze"
"""


def test_several_tasks_of_several_types(capsys: Capture, problem_file: Path) -> None:
    problem_file.write_text(SEVERAL)
    assert main(["solve", "--file", str(problem_file), "--json"]) == 0
    q = np.array(json.loads(capsys.readouterr().out)["q"])
    arm = jtik.Robot.planar(4)
    sight = np.array([3.0, 3.0]) - arm.position(q, "link3")
    assert arm.position(q) == pytest.approx([1.5, 1.0], abs=2e-6)
    assert arm.pose(q, "link3")[:2, 0] == pytest.approx(sight / np.linalg.norm(sight), abs=2e-6)


@pytest.mark.parametrize(
    ("old", "new", "options", "said"),
    [
        ('type = "look_at"', 'type = "look_up"', "", "did you mean 'look_at'"),
        ('type = "look_at"', "type = 3", "", "frame, relative, axis, look_at, center_of_mass"),
        ('type = "look_at"', 'type = "relative"', "", "'axis'"),
        ('type = "look_at"\n', "", "", "'axis'"),
        ("gaze = [3.0, 3.0]", "gaze = [3.0]", "", "target['gaze']"),
        ("links = 4", "links = 4", "--frame link2", "several"),
    ],
)
def test_wrong_tasks_are_refused_in_one_line(
    capsys: Capture, problem_file: Path, old: str, new: str, options: str, said: str
) -> None:
    assert old in SEVERAL
    problem_file.write_text(SEVERAL.replace(old, new, 1))
    assert said in refusal(capsys, "solve", "--file", str(problem_file), *options.split())


@pytest.mark.parametrize("text", ["{", "[1, 2]", "\udcff"])
def test_broken_json_is_refused(capsys: Capture, tmp_path: Path, text: str) -> None:
    file = tmp_path / "problem.json"
    file.write_bytes(text.encode("utf-8", "surrogateescape"))
    assert "problem.json" in refusal(capsys, "solve", "--file", str(file))


@pytest.mark.parametrize("task", [{}, {"frame": "panda_hand"}, {"kind": "position"}])
def test_seven_numbers_are_a_pose_as_on_the_command_line(task: dict[str, Any]) -> None:
    target = [0.4, 0.1, 0.5] if "kind" in task else [0.4, 0.1, 0.5, 0, 1, 0, 0]
    problem = read({"robot": {"kind": "builtin", "name": "panda"}, "task": task, "target": target})
    assert len(problem.ik.solve(problem.target).error) == (3 if "kind" in task else 6)


def test_options_of_a_criterion_belong_in_a_file(capsys: Capture) -> None:
    words = ["--robot", "panda", "--target", "0.4", "0.1", "0.5", "--criterion", "look_at"]
    assert "target is missing" in refusal(capsys, "solve", *words)
    assert "options of [[criteria]]" in refusal(capsys, "solve", *words)


def test_obstacles_with_a_name_and_a_table_each_are_a_scene(problem_file: Path) -> None:
    scene = jtik.Scene({"wall": jtik.HalfSpace((0, -2), (0, 1))}, {"wall": 0.5})
    scene.save(problem_file.parent / "walls.toml")
    more = """circles = [[1.0, -1.0, 0.3]]
scene = "walls.toml"
table = { shape = "box", center = [1.0, 2.0], half = [0.3, 0.1], rotation = 0.2 }
"""
    problem_file.write_text(PROBLEM.replace("circles = [[1.0, -1.0, 0.3]]", more, 1))
    problem = read(load(problem_file))
    assert isinstance(problem.obstacles, jtik.Scene)
    assert {"circle0", "wall", "table"} <= set(problem.obstacles.names)
    gains = problem.ik.parameters["obstacle_avoidance.gains"]
    assert sorted(gains[gains > 0])[0] == 0.5
    assert (gains > 0).sum() == len(problem.obstacles)


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ("table = { shape = 'box', center = [0, 0] }", "obstacles.table.half"),
        ("scene = 'nowhere.toml'", "nowhere.toml"),
        ("circle0 = { shape = 'point', center = [0, 0] }", "circle0: given twice"),
    ],
)
def test_wrong_obstacles_with_a_name(capsys: Capture, problem_file: Path, lines: str, said: str) -> None:
    problem_file.write_text(PROBLEM.replace("circles = [[1.0, -1.0, 0.3]]", f"circles = [[1, -1, 0.3]]\n{lines}", 1))
    assert said in refusal(capsys, "solve", "--file", str(problem_file))

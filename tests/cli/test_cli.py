"""The command line: what it prints, what it returns, and how it refuses."""

from __future__ import annotations

import builtins
import csv
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jtik
from jtik.cli import catalogue, main
from jtik.cli.document import load, read
from jtik.registry import Registry
from jtik.robot import gallery

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


def test_list_shows_everything_registered(capsys: Capture) -> None:
    assert main(["list"]) == 0
    out = capsys.readouterr().out
    for name in (*jtik.strategies, *jtik.secondaries, *jtik.criteria, *gallery.names()):
        assert name in out
    titles = [line for line in out.splitlines() if line.startswith(("Strategies", "Secondary", "Criteria", "Robots"))]
    assert [title.split()[0] for title in titles] == ["Strategies", "Secondary", "Criteria", "Robots"]


def test_list_shows_brackets_as_they_are(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    class Boxed(jtik.Strategy):
        summary = "keeps dq in [m] within a box"

    registry: Registry[jtik.Strategy] = Registry("strategy", jtik.Strategy, "none.strategies")
    registry.add("boxed", Boxed)
    monkeypatch.setattr(catalogue, "strategies", registry)
    assert main(["list"]) == 0
    assert "[m]" in capsys.readouterr().out


def test_list_needs_no_rich(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    without(monkeypatch, "rich")
    assert main(["list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    for row in (*jtik.strategies.rows(), *jtik.secondaries.rows(), *jtik.criteria.rows()):
        (line,) = [line for line in lines if line.startswith(f"{row.name} ")]
        assert row.summary in line
        assert line.endswith(row.source)


def test_solve_prints_the_solution(capsys: Capture) -> None:
    assert main(["solve", "--robot", "planar:3", "--target", "1", "2", "--q0", "0.1", "0.2", "0.3"]) == 0
    assert capsys.readouterr().out.startswith("Solution: converged")


@pytest.mark.parametrize("target", [("-3", "4"), ("-1e-3", "-.5"), ("-2.5E0", "1")])
def test_targets_may_be_negative(capsys: Capture, target: tuple[str, str]) -> None:
    document = solved(capsys, "--robot planar:10 --target", *target, "--q0", *["-0.1"] * 10)
    np.testing.assert_allclose(position(jtik.Robot.planar(10), document), [float(t) for t in target], atol=1e-6)


def test_json_has_every_field_of_a_solution(capsys: Capture) -> None:
    line = "--robot planar:4 --target 2 1 --q0 0.1 0.2 0.3 0.4 --criterion joint_centering=0.5"
    document = solved(capsys, line)
    ik = jtik.InverseKinematics(
        jtik.Robot.planar(4), jtik.FrameTask("tip"), criteria=0.5 * jtik.criteria["joint_centering"]()
    )
    solution = ik.solve([2, 1], q0=[0.1, 0.2, 0.3, 0.4])
    assert document["q"] == solution.q.tolist()
    assert document["status"] == solution.status.name
    assert document["why"] == solution.status.value
    assert document["converged"] is True
    assert document["iterations"] == solution.iterations
    assert document["criteria"] == dict(solution.criteria)
    assert document["active_limits"] == []
    assert document["joint_names"] == list(ik.robot.joint_names)
    public = {name for name in (*vars(solution), *dir(type(solution))) if not name.startswith("_")}
    left_out, added = (
        {"trace", "report", "inspect", "look", "gave_way", "of"},
        {"robot", "strategy", "why", "joint_names"},
    )
    assert set(document) == public - left_out | added


def test_a_target_out_of_reach_ends_with_code_1(capsys: Capture) -> None:
    document = solved(capsys, "--robot planar:2 --target 5 5 --q0 0.3 0.3", code=1)
    assert document["converged"] is False
    assert document["position_error"] == pytest.approx(np.hypot(5, 5) - 2, abs=1e-4)


def test_infinite_figures_are_null_in_json(capsys: Capture) -> None:
    document = solved(capsys, "--robot planar:2 --target 2 0 --q0 0 0")
    assert document["condition"] is None


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


def test_until_reached_stops_earlier(capsys: Capture) -> None:
    line = "--robot planar:6 --target 3 2 --q0 .9 -.3 .9 -.3 .9 -.3 --criterion joint_centering --until"
    stationary, reached = (solved(capsys, line, until) for until in ("stationary", "reached"))
    assert reached["iterations"] < stationary["iterations"]
    assert stationary["cost"] < reached["cost"]


def test_limits_can_be_ignored(capsys: Capture, problem_file: Path) -> None:
    out_of_limits = [
        "--file",
        str(problem_file),
        "--target",
        "-2.4",
        "0.5",
        "--criterion",
        "joint_centering",
        "--q0",
        "1",
        "1",
        "1",
        "1",
    ]
    limited = solved(capsys, *out_of_limits, code=1)
    assert limited["active_limits"]
    free = solved(capsys, *out_of_limits, "--no-limits")
    assert max(np.abs(free["q"])) > 2.0


def test_trace_is_one_row_an_iteration(capsys: Capture, tmp_path: Path) -> None:
    file = tmp_path / "trace.csv"
    line = "--robot planar:3 --target 1 2 --q0 0.1 0.2 0.3 --criterion joint_centering --trace"
    document = solved(capsys, line, str(file))
    rows = list(csv.DictReader(file.read_text().splitlines()))
    assert len(rows) == document["iterations"] + 1
    assert [float(rows[-1][f"q{i}"]) for i in range(3)] == document["q"]
    assert float(rows[0]["V"]) == pytest.approx(float(rows[0]["error"]) ** 2 / 2)


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
        ("dance", "'dance'"),
        ("", "command"),
    ],
)
def test_wrong_input_is_refused_in_one_line(capsys: Capture, words: str, said: str) -> None:
    assert said in refusal(capsys, *words.split())


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


def test_demo_without_rich_names_the_extra(capsys: Capture, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    without(monkeypatch, "rich")
    assert "pip install 'jtik[demo]'" in refusal(capsys, "demo", "--out", str(tmp_path))


def test_python_m_jtik_is_the_command_line() -> None:
    words = [sys.executable, "-W", "error", "-m", "jtik", "--version"]
    root = Path(jtik.__file__).parents[1]
    result = subprocess.run(words, capture_output=True, text=True, cwd=root, check=True)
    assert result.stdout.strip() == f"jtik {jtik.__version__}"


def without(monkeypatch: pytest.MonkeyPatch, package: str) -> None:
    """As if the package were not installed."""
    real = builtins.__import__

    def fake(name: str, *arguments: Any, **options: Any) -> Any:
        if name.partition(".")[0] == package:
            raise ImportError(name)
        return real(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", fake)

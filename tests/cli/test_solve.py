"""``jtik solve``: what it prints, writes and returns."""

from __future__ import annotations

import csv
import itertools
import json
from pathlib import Path

import numpy as np
import pytest

import jtik
from jtik.cli import main
from jtik.cli.document import read
from jtik.cli.output import draw_solution
from jtik.symbolic.compile import CompilerError, compiler

from .conftest import Capture, position, refusal, solved, without


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
        {"trace", "report", "inspect", "plot", "look", "gave_way", "of"},
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
    assert [float(rows[-1][f"joint{i}"]) for i in (1, 2, 3)] == document["q"]
    assert float(rows[0]["V"]) == pytest.approx(float(rows[0]["error"]) ** 2 / 2)


def test_several_postures_are_a_table(capsys: Capture, tmp_path: Path) -> None:
    line = f"--robot ur5e --kind pose --target 0.4 0.2 0.3 0 1 0 0 --restarts 50 --best-of 4 --out {tmp_path}/found.csv"
    document = solved(capsys, line)
    rows = list(csv.DictReader((tmp_path / "found.csv").read_text().splitlines()))
    postures = [[float(row[name]) for name in document["joint_names"]] for row in rows]
    assert len(rows) == 4
    assert postures == [document["q"], *[each["q"] for each in document["alternatives"]]]
    poses = [jtik.Robot.builtin("ur5e").pose(q) for q in postures]
    assert np.ptp(poses, axis=0).max() < 1e-5
    assert min(np.abs(np.subtract(a, b)).max() for a, b in itertools.combinations(postures, 2)) > 0.01


def test_the_written_json_is_the_printed_one(capsys: Capture, tmp_path: Path) -> None:
    document = solved(capsys, f"--robot planar:3 --target 1 2 --out {tmp_path}/solution.json")
    assert json.loads((tmp_path / "solution.json").read_text()) == document


def test_the_same_seed_gives_the_same_solution(capsys: Capture) -> None:
    line = "--robot panda --kind pose --target 0.4 0.2 0.3 0 1 0 0 --q0 mid --restarts 10 --best-of 2 --seed"
    first, again, other = (solved(capsys, line, seed)["alternatives"] for seed in ("1", "1", "2"))
    assert first == again
    assert first != other


@pytest.mark.slow
def test_compiled_steps_and_another_solver_lead_to_the_same_posture(capsys: Capture) -> None:
    try:
        compiler()
    except CompilerError:
        pytest.skip("needs a C compiler")
    line = "--robot planar:4 --target 2 1 --q0 .1 .2 .3 .4 --strategy hybrid+qp --criterion joint_centering"
    q = solved(capsys, line)["q"]
    assert solved(capsys, line, "--compiled")["q"] == pytest.approx(q, abs=1e-6)
    assert solved(capsys, line, "--solver", "osqp")["q"] == pytest.approx(q, abs=1e-4)


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("line", "shape"),
    [
        ("--robot planar:4 --target 2 1.5 --q0 .1 .2 .3 .4", "--obstacle 1 1.8 0.3"),
        ("--robot panda --target 0.4 0.2 0.5", "--obstacle 0.3 0 0.7 0.1"),
    ],
)
def test_obstacles_have_the_coordinates_of_the_robot(capsys: Capture, line: str, shape: str) -> None:
    count = len(shape.split()) - 1
    named = "circle" if count == 3 else "sphere"
    criterion = "--criterion obstacle_avoidance=0.1"
    one = solved(capsys, f"{line} {shape} {criterion}")
    assert one["q"] == solved(capsys, f"{line} {shape.replace('obstacle', named)} {criterion}")["q"]
    assert one["q"] != solved(capsys, line)["q"]
    point = " ".join(shape.split()[:-1])
    as_point = solved(capsys, f"{line} {point} {criterion}")["q"]
    assert as_point == solved(capsys, f"{line} {point.replace('obstacle', 'point')} {criterion}")["q"]
    assert as_point != one["q"]


def test_obstacles_that_nothing_takes_are_a_warning(capsys: Capture) -> None:
    assert main(["solve", "--robot", "planar:3", "--target", "1", "2", "--obstacle", "1", "1", "0.2", "--json"]) == 0
    out, err = capsys.readouterr()
    json.loads(out)
    assert err.startswith("jtik: warning: no criterion takes the obstacles; those that do: ")
    assert "obstacle_avoidance" in err
    assert err.count("\n") == 1


@pytest.mark.quick(2)
@pytest.mark.parametrize(
    ("suffix", "more", "robot"),
    [
        (".png", "", "planar:3"),
        (".svg", "--restarts 3 --best-of 2", "planar:3"),
        (".pdf", "", "planar:3"),
        (".png", "--restarts 3 --best-of 2", "panda"),
    ],
)
def test_a_picture_is_drawn(capsys: Capture, tmp_path: Path, robot: str, more: str, suffix: str) -> None:
    pytest.importorskip("matplotlib")
    target = "1 2" if robot == "planar:3" else "0.4 0.2 0.5"
    file = tmp_path / f"arm{suffix}"
    solved(capsys, f"--robot {robot} --target {target} {more} --plot {file}")
    begin = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}[suffix]
    assert file.read_bytes().startswith(begin)


def test_the_picture_shows_the_way_and_the_obstacles() -> None:
    pytest.importorskip("matplotlib")
    words = {"robot": "planar:3", "target": [1.0, 2.0], "criteria": ["obstacle_avoidance"], "obstacles": {}}
    problem = read({**words, "obstacles": {"balls": [[-2.0, 1.0, 0.4]]}})
    solution = problem.ik.solve(problem.target, trace=True, **problem.options)
    axes = draw_solution(problem, solution).axes[0]
    ways = [line.get_xydata() for line in axes.get_lines() if len(line.get_xydata()) == len(solution.trace) + 2]
    tips = [problem.ik.robot.position(q) for q in solution.trace.q]
    assert any(np.allclose(way[:-1], tips) for way in ways)
    left, right = axes.get_xlim()
    assert left < -2.4 < right


def test_without_matplotlib_a_picture_names_the_extra_before_the_solve(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    without(monkeypatch, "matplotlib")
    line = refusal(capsys, *["solve", "--robot", "planar:3", "--target", "1", "2", "--plot", "arm.png"])
    assert "pip install 'jtik[plot]'" in line


def test_a_file_that_cannot_be_written_costs_no_solution(capsys: Capture, tmp_path: Path) -> None:
    """A folder has the name of the first file; the second is written, and the solution is printed."""
    (tmp_path / "a.json").mkdir()
    words = f"solve --robot planar:3 --target 1 2 --json --out {tmp_path}/a.json --trace {tmp_path}/b.csv".split()
    assert main(words) == 1
    out, err = capsys.readouterr()
    assert json.loads(out)["converged"]
    assert "a.json: Is a directory" in err
    assert err.count("\n") == 1
    assert (tmp_path / "b.csv").exists()

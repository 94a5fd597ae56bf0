"""The demo: the arm follows the path without touching the field, and what it reports is what was measured."""

from __future__ import annotations

import dataclasses
import io
import itertools
import json
from pathlib import Path

import numpy as np
import pytest

import jtik
from jtik import demo
from jtik.cli import main
from jtik.demo.measure import clearances, follow_path
from jtik.demo.report import strategy_table
from jtik.demo.scene import Scene

pytestmark = pytest.mark.slow

matplotlib = pytest.importorskip("matplotlib")
image = pytest.importorskip("PIL.Image")
console = pytest.importorskip("rich.console")

SOME = ("hybrid", "newton", "transpose", "weighted_qp")
"""Strategies of the quick tests."""

SAMPLES = 2001
"""Points on a link for the brute-force distance; of a unit link, 0.5 mm apart."""


@pytest.fixture(scope="module")
def output() -> io.StringIO:
    return io.StringIO()


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory, output: io.StringIO) -> demo.DemoResult:
    """A run with some of the registered strategies."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(demo, "strategies", SOME)
        return demo.run(
            tmp_path_factory.mktemp("demo") / "out", quick=True, console=console.Console(file=output, width=170)
        )


def test_the_files_it_names_exist(result: demo.DemoResult) -> None:
    assert {file.name for file in result.files} == {"postures.png", "postures.svg", "arm.gif", "results.json"}
    with image.open(file_named(result, "postures.png")) as picture:
        assert picture.width == 1600
        assert len(picture.convert("RGB").getcolors(1 << 24)) > 50
    with image.open(file_named(result, "arm.gif")) as animation:
        assert animation.n_frames == 12


def test_the_end_effector_reaches_every_target(result: demo.DemoResult) -> None:
    scene = Scene()
    tips = [scene.robot.position(q) for q in result.path.q]
    away = np.linalg.norm(np.array(tips) - scene.path(len(tips)), axis=1)
    assert result.path.complete
    assert away.max() < 1e-6
    np.testing.assert_allclose(away, result.path.residuals, atol=1e-12)


def test_the_arm_touches_nothing_along_the_path(result: demo.DemoResult) -> None:
    assert result.path.link_clearance.min() > 0.08
    assert result.path.joint_clearance.min() >= result.path.link_clearance.min()


def test_clearances_are_those_of_points_sampled_on_the_links(result: demo.DemoResult) -> None:
    scene = Scene()
    share = np.linspace(0, 1, SAMPLES)[:, None]
    for q, expected in zip(result.path.q, result.path.link_clearance, strict=True):
        corners = np.array(
            [[0.0, 0.0], *(scene.robot.position(q, f"link{i}") for i in range(2, 11)), scene.robot.position(q)]
        )
        points = np.concatenate([(1 - share) * a + share * b for a, b in itertools.pairwise(corners)])
        sampled = min(
            float(np.linalg.norm(points - disc.center, axis=1).min()) - disc.radius for disc in scene.obstacles
        )
        assert expected == pytest.approx(sampled, abs=1e-4)


def test_the_joints_move_little_from_one_target_to_the_next(result: demo.DemoResult) -> None:
    assert np.abs(np.diff(result.path.q, axis=0)).max() < 0.4


def test_without_avoidance_the_arm_touches_the_field(result: demo.DemoResult) -> None:
    assert result.without.complete
    assert result.without.link_clearance.min() < -0.3


def test_every_strategy_is_tried(result: demo.DemoResult, output: io.StringIO) -> None:
    assert [tried.strategy for tried in result.strategies] == list(SOME)
    for tried in result.strategies:
        assert tried.strategy in output.getvalue()


def test_its_strategies_are_those_registered() -> None:
    assert list(demo.strategies) == list(jtik.strategies)


@pytest.mark.slow
def test_every_registered_strategy_is_tried(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    skip_pictures(monkeypatch, tmp_path)
    printed = io.StringIO()
    result = demo.run(tmp_path, quick=True, console=console.Console(file=printed, width=170))
    assert [tried.strategy for tried in result.strategies] == list(jtik.strategies)
    for tried in result.strategies:
        assert tried.strategy in printed.getvalue()
    document = json.loads(file_named(result, "results.json").read_text())
    assert [row["strategy"] for row in document["strategies"]] == list(jtik.strategies)


def test_the_table_fits_a_terminal_of_80_columns(result: demo.DemoResult) -> None:
    longest = max(jtik.strategies, key=len)
    table = strategy_table([dataclasses.replace(result.strategies[0], strategy=longest, iterations=12345, H=123.4)])
    printed = io.StringIO()
    console.Console(file=printed, width=80).print(table)
    shown = printed.getvalue().split()
    assert {longest, "12345", "123.4", "residual", "[m]", "[m²]", "a", "[µs]"} <= set(shown)
    words = " ".join(str(column.header) for column in table.columns).replace("\\", "").split()
    assert set(words) <= set(shown)
    assert all(len(line) <= 80 for line in printed.getvalue().splitlines())


def test_the_paper_s_strategies_reach_the_last_target_clear_of_the_field(result: demo.DemoResult) -> None:
    tried = {one.strategy: one for one in result.strategies}
    for name in ("transpose", "newton", "hybrid"):
        assert tried[name].residual < 1e-6
        assert tried[name].link_clearance > 0.08
        assert tried[name].step_seconds > 0


def test_a_compromise_is_shown_as_one(result: demo.DemoResult, output: io.StringIO) -> None:
    """weighted_qp weighs the criterion against the task: it ends off target, and that is no failure."""
    (tried,) = (one for one in result.strategies if one.strategy == "weighted_qp")
    assert tried.status is jtik.Status.COMPROMISE
    assert tried.iterations < 100
    assert "compromise:" in output.getvalue()
    others = [one for one in result.strategies if one is not tried]
    assert strategy_table(others).caption is None


def test_results_json_contains_the_measurements(result: demo.DemoResult) -> None:
    document = json.loads(file_named(result, "results.json").read_text())
    assert document["path"]["q"] == result.path.q.tolist()
    assert document["path"]["smallest_link_clearance"] == result.path.link_clearance.min()
    assert [row["strategy"] for row in document["strategies"]] == list(SOME)
    assert len(document["scene"]["obstacles"]) == len(Scene().obstacles)


def test_clearances_of_one_link_from_one_disc() -> None:
    link = [[[0.0, 0.0], [2.0, 0.0]]]
    discs = [jtik.Circle((1, 1), 0.25), jtik.Circle((4, 0), 0.5), jtik.Circle((1, 0), 0.5)]
    joints, links = clearances(link, discs)
    np.testing.assert_allclose(links, [[0.75, 1.5, -0.5]])
    np.testing.assert_allclose(joints, [[np.sqrt(2) - 0.25, 1.5, 0.5]])


def test_progress_is_reported_after_every_target() -> None:
    scene, calls = Scene(), []
    follow_path(scene, scene.path(60)[:3], advance=lambda: calls.append(1))
    assert len(calls) == 3


def skip_pictures(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    """Draw nothing: pictures take seconds, and another test checks them."""
    monkeypatch.setattr(demo, "draw_stills", lambda *_: [])
    monkeypatch.setattr(demo, "animate", lambda *_: folder / "arm.gif")


@pytest.fixture
def few_strategies(monkeypatch: pytest.MonkeyPatch) -> None:
    """One strategy in place of all, which `result` has tried."""
    monkeypatch.setattr(demo, "strategies", ("hybrid",))


@pytest.mark.slow
@pytest.mark.usefixtures("few_strategies")
def test_the_command_runs_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    skip_pictures(monkeypatch, tmp_path)
    out = tmp_path / "pictures"
    assert main(["demo", "--quick", "--out", str(out)]) == 0
    printed = capsys.readouterr()
    assert "every strategy" in printed.out
    assert printed.err == ""
    assert (out / "results.json").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("few_strategies")
def test_without_a_console_nothing_is_printed(
    tmp_path: Path, result: demo.DemoResult, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the path that `result` has followed, and whose progress another test reports."""
    skip_pictures(monkeypatch, tmp_path)
    monkeypatch.setattr(demo, "follow_path", lambda *_, **__: result.path)
    capsys.readouterr()
    demo.run(tmp_path, quick=True)
    assert capsys.readouterr() == ("", "")


def file_named(result: demo.DemoResult, name: str) -> Path:
    (file,) = (file for file in result.files if file.name == name)
    return file

"""Figures of a study show its data on labelled axes in distinct styles."""

from __future__ import annotations

import importlib

import numpy as np
import pytest

import jtik
from jtik import problems
from jtik.errors import ArgumentError, UnknownNameError
from jtik.study import Comparison, compare
from jtik.study.figures import style
from jtik.study.figures.profile import ratios
from jtik_formulations import ObstacleAvoidance

pytest.importorskip("matplotlib")


@pytest.fixture
def study(figure_study):
    return figure_study


@pytest.fixture
def bare(bare_study):
    return bare_study


PLOTS = ("convergence", "profile", "lyapunov", "criteria", "postures", "joints")


@pytest.mark.quick(3)
@pytest.mark.parametrize("name", PLOTS)
def test_every_axis_is_labelled_with_its_unit(study: Comparison, name: str) -> None:
    figure = getattr(study, f"plot_{name}")()
    texts = [axes.get_xlabel() + axes.get_ylabel() + "".join(t.get_text() for t in axes.texts) for axes in figure.axes]
    assert all(texts), name
    wanted = {"profile": "%", "criteria": "criterion H"}.get(name, "[")
    assert wanted in "".join(texts)


def test_a_figure_has_a_notebook_representation(study: Comparison) -> None:
    assert study.plot_convergence()._repr_png_().startswith(b"\x89PNG")


def test_convergence_draws_the_median_error(study: Comparison) -> None:
    axes = study.plot_convergence(kind="reachable", contenders=["newton"]).axes[0]
    line = next(each for each in axes.get_lines() if each.get_label() == "newton")
    errors = [trace.error for (who, _, case), trace in study.traces.items() if who == "newton" and "reach" in case]
    assert len(errors) == 3
    assert line.get_ydata()[0] == pytest.approx(np.median([error[0] for error in errors]))
    assert line.get_ydata()[-1] == pytest.approx(np.median([max(error[-1], style.FLOOR) for error in errors]))


def test_the_profile_is_that_of_dolan_and_more(study: Comparison) -> None:
    names = study.contenders
    found = ratios(study, "iterations", study.criteria[0], names)
    rows = {name: study.rows(contender=name, kind="reachable") for name in names}
    used = {name: np.maximum(study.columns["iterations"][rows[name]], 1) for name in names[:3]}
    best = np.min(list(used.values()), axis=0)
    for name in names[:3]:
        assert study.columns["success"][rows[name]].all()
        np.testing.assert_allclose(found[name][:4], used[name] / best)
    assert np.isinf(found["nobody"]).all()
    assert np.min([found[name] for name in names[:3]], axis=0) == pytest.approx(1.0)
    line = next(
        each for each in study.plot_profile(measure="iterations").axes[0].get_lines() if each.get_label() == "newton"
    )
    assert line.get_ydata().max() == pytest.approx(100 * np.isfinite(found["newton"]).mean())


def test_circles_mark_rises_of_V() -> None:
    robot, task = jtik.Robot.planar(10), jtik.FrameTask("tip", kind="position")
    start = 1e-3 * np.random.default_rng(1).standard_normal(10)
    undamped = jtik.strategies["newton"](q_limit=np.inf, backtracking=False)
    straight = problems.Case(name="straight", kind="straight", q0=start, targets=[(5.0, 0.0)])
    study = compare(robot, task, strategies={"undamped": undamped, "hybrid": "hybrid"}, problems=[straight], repeats=1)
    axes = study.plot_lyapunov().axes[0]
    V = study.traces["undamped", study.criteria[0], "straight"].figures["V"]
    circles = {line.get_color(): line.get_xdata() for line in axes.get_lines() if line.get_marker() == "o"}
    colors = style.lines(study.contenders)
    assert list(circles[colors["undamped"]["color"]]) == list(np.flatnonzero((V[1:] > V[:-1]) & (V[1:] > 1e-14)) + 1)
    assert len(circles[colors["undamped"]["color"]]) > 0
    assert len(circles[colors["hybrid"]["color"]]) == 0


def test_lines_have_distinct_styles() -> None:
    styles = style.lines([f"strategy {i}" for i in range(28)])
    assert len({(style["color"], str(style["linestyle"])) for style in styles.values()}) == 28


@pytest.mark.slow
def test_an_animation_has_its_minimum_number_of_frames(study: Comparison, tmp_path, monkeypatch) -> None:
    image = pytest.importorskip("PIL.Image")
    monkeypatch.setattr(importlib.import_module("jtik.study.figures.animation"), "FRAMES", 4)
    case = next(case for who, _, case in study.traces if who == "newton" and "reach" in case)
    study.animate(tmp_path / "arm.gif", contender="newton", case=case)
    with image.open(tmp_path / "arm.gif") as gif:
        assert 4 <= gif.n_frames < 30


@pytest.mark.slow
def test_an_animation_has_many_frames(study: Comparison, tmp_path) -> None:
    image = pytest.importorskip("PIL.Image")
    study.animate(tmp_path / "arm.gif", contender="newton", case="circle-000")
    with image.open(tmp_path / "arm.gif") as gif:
        assert gif.n_frames >= 30


def test_obstacles_of_a_scene_are_drawn() -> None:
    robot, task = jtik.Robot.planar(4), jtik.FrameTask("tip", kind="position")
    scenes = problems.scene(robot, task, 1, obstacles=2)
    avoid = ObstacleAvoidance(problems.obstacles_of(scenes[0]), bodies="links")
    study = compare(robot, task, strategies="hybrid", criteria=avoid, problems=scenes, repeats=1, max_iterations=50)
    figure = study.plot_postures()
    drawn = {tuple(np.round(patch.center, 9)) for patch in figure.axes[0].patches}
    assert {tuple(np.round(center, 9)) for center in scenes[0].parameters["obstacle_avoidance.centers"]} <= drawn


@pytest.mark.slow
def test_obstacles_of_criteria_and_of_clearances_are_drawn_each_once(tmp_path) -> None:
    robot, task = jtik.Robot.planar(4), jtik.FrameTask("tip", kind="position")
    near, far = jtik.Circle((2.0, 2.5), 0.3), jtik.Circle((-2.0, 1.5), 0.4)
    study = compare(
        robot,
        task,
        strategies="weighted_qp",
        criteria={"with": ObstacleAvoidance([near]), "without": None},
        clearances=jtik.Clearance(ObstacleAvoidance([near, far])),
        count=1,
        repeats=1,
        max_iterations=20,
    )
    study.save(tmp_path / "study.npz")
    for each in (study, Comparison.load(tmp_path / "study.npz")):
        for criteria in ("with", "without"):
            patches = each.plot_postures(criteria=criteria).axes[0].patches
            drawn = sorted(tuple(np.round(patch.center, 9)) for patch in patches if patch.radius in (0.3, 0.4))
            assert drawn == [(-2.0, 1.5), (2.0, 2.5)]


def test_only_the_attempt_that_led_to_the_answer_is_drawn() -> None:
    robot, task = jtik.Robot.planar(3), jtik.FrameTask("tip", kind="position")
    out_of_reach = problems.Case(name="far", kind="far", q0=[2.5, -2.9, 2.9], targets=[(4.0, 0.0)])
    study = compare(robot, task, strategies="newton", problems=[out_of_reach], repeats=1, restarts=3, max_iterations=8)
    (trace,) = study.traces.values()
    assert len(np.unique(trace.attempt)) > 2
    line = next(line for line in study.plot_postures().axes[0].get_lines() if len(line.get_xdata()) > 1)
    rows = trace.answer_rows
    assert len(line.get_xdata()) == len(rows) + 1 < len(trace.q)
    expected = [robot.position(q) for q in (*trace.q[rows], trace.q[-1])]
    np.testing.assert_allclose(np.column_stack(line.get_data()), expected, atol=1e-9)
    V = study.plot_lyapunov().axes[0].get_lines()[0].get_ydata()
    np.testing.assert_array_equal(V, np.maximum(trace.V[rows], style.FLOOR))


@pytest.mark.slow
def test_a_spatial_robot_is_drawn_in_3d() -> None:
    robot = jtik.Robot.builtin("ur5e")
    study = compare(robot, jtik.FrameTask(robot.tip), strategies=["hybrid"], count=1, repeats=1)
    figure = study.plot_postures()
    (axes,) = figure.axes
    assert axes.name == "3d"
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    boxes = [axis.label.get_window_extent(renderer) for axis in (axes.xaxis, axes.yaxis, axes.zaxis)]
    boxes += [text.get_window_extent(renderer) for text in figure.texts]
    for k, box in enumerate(boxes):
        assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
        assert figure.bbox.y0 <= box.y0 < box.y1 <= figure.bbox.y1
        assert not box.count_overlaps(boxes[:k])
    assert study.plot_joints()._repr_png_()


def test_missing_data_is_refused(study: Comparison, bare: Comparison, tmp_path) -> None:
    with pytest.raises(UnknownNameError, match="contender"):
        study.plot_convergence(contenders=["else"])
    with pytest.raises(UnknownNameError, match="case"):
        study.plot_postures(case="reachable-003")  # solved, but not recorded
    with pytest.raises(UnknownNameError, match="kind"):
        study.plot_convergence(kind="scene")
    with pytest.raises(UnknownNameError, match="criteria"):
        study.plot_profile(criteria="else")
    with pytest.raises(ArgumentError, match="measure"):
        study.plot_profile(measure="hours")
    with pytest.raises(ArgumentError, match="traces"):
        bare.plot_convergence()
    with pytest.raises(ArgumentError, match="gif"):
        study.animate(tmp_path / "arm.mp4")

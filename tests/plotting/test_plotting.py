"""Pictures: the ends of links are those of the kinematics, and what is drawn is where it should be."""

from __future__ import annotations

import builtins
import itertools
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jtik
from jtik import plotting

from ..geometry.shapes import distance

pytest.importorskip("matplotlib")
image = pytest.importorskip("PIL.Image")

PIXEL = 1.5
"""Tolerance of a comparison in pixels: anti-aliasing and rounding."""

SNAP = 1e-3
"""Share of pixels that may differ because lines snap to the grid; an arm covers ten times as many."""
OUTLINE = 1.0
"""What half the line around a disc adds to its radius, in pixels."""


@pytest.fixture
def arm() -> jtik.Robot:
    return jtik.Robot.planar([1.0, 0.5, 0.25])


def closed_form(lengths: list[float], q: np.ndarray) -> np.ndarray:
    """Both ends of every link of a planar arm."""
    angles = np.cumsum(q)
    corners = np.cumsum(
        [[0, 0], *(length * np.array([np.cos(a), np.sin(a)]) for length, a in zip(lengths, angles, strict=True))],
        axis=0,
    )
    return np.stack([corners[:-1], corners[1:]], axis=1)


def empty(window: plotting.Window, width: float) -> tuple[Any, Any]:
    """A figure without ticks and frame."""
    figure, axes = plotting.blank_figure(window, width)
    axes.set_axis_off()
    return figure, axes


def share_of_different(one: np.ndarray, other: np.ndarray) -> float:
    """Of the pixels of two pictures."""
    return float((np.abs(one - other).max(axis=2) > 128).mean())


def pixels(figure: Any) -> np.ndarray:
    figure.canvas.draw()
    return np.asarray(figure.canvas.buffer_rgba())[..., :3].astype(int)


def test_links_of_a_planar_arm(arm: jtik.Robot) -> None:
    q = np.array([0.3, -1.1, 2.0])
    np.testing.assert_allclose(plotting.Skeleton(arm).links(q), closed_form([1.0, 0.5, 0.25], q), atol=1e-14)


def test_links_of_many_configurations_are_those_of_each(arm: jtik.Robot) -> None:
    skeleton = plotting.Skeleton(arm)
    q = np.random.default_rng(1).uniform(-3, 3, (5, 3))
    np.testing.assert_array_equal(skeleton.links(q), [skeleton.links(each) for each in q])


def test_links_of_a_vehicle_start_at_the_vehicle() -> None:
    links = plotting.Skeleton(jtik.Robot.vehicle(2)).links([3.0, 4.0, 0.0, np.pi / 2])
    np.testing.assert_allclose(links, [[[3, 4], [4, 4]], [[4, 4], [4, 5]]], atol=1e-14)


@pytest.mark.parametrize("shape", [(2,), (4,), (2, 4), (1, 1, 3)])
def test_configurations_of_another_shape_are_refused(arm: jtik.Robot, shape: tuple[int, ...]) -> None:
    with pytest.raises(jtik.ArgumentError, match="accepted: shape"):
        plotting.Skeleton(arm).links(np.zeros(shape))


@pytest.mark.parametrize("width", [6.0, 11.0])
def test_a_figure_shows_its_window_at_equal_scale(width: float) -> None:
    figure, axes = plotting.blank_figure((-1, 3, -0.5, 1.5), width)
    figure.canvas.draw()
    assert figure.get_size_inches()[0] == width
    assert (*axes.get_xlim(), *axes.get_ylim()) == (-1, 3, -0.5, 1.5)
    origin, right, up = axes.transData.transform([(0, 0), (1, 0), (0, 1)])
    assert right[0] - origin[0] == pytest.approx(up[1] - origin[1])
    assert plotting.points_per_metre(axes) == pytest.approx((right[0] - origin[0]) * 72 / figure.dpi)


def test_an_empty_window_is_refused() -> None:
    with pytest.raises(jtik.ArgumentError, match="left < right"):
        plotting.blank_figure((1, 1, 0, 2))


def test_a_link_is_drawn_in_its_place_and_width() -> None:
    figure, axes = empty((-1, 2, -1, 1), 6.0)
    plotting.DrawnArm(axes, jtik.Robot.planar(1), color="black", width=0.2, joints=False, halo=False).move([0.0])
    dark = pixels(figure).mean(axis=2) < 128
    rows, columns = np.nonzero(dark)
    scale = plotting.points_per_metre(axes) * figure.dpi / 72
    x0, y0 = axes.transData.transform((0, 0))
    assert np.ptp(rows) + 1 == pytest.approx(0.2 * scale, abs=PIXEL)
    assert columns.min() == pytest.approx(x0 - 0.1 * scale, abs=PIXEL)  # half a width more: the cap is round
    assert columns.max() == pytest.approx(x0 + 1.1 * scale, abs=PIXEL)
    assert dark.shape[0] - rows.mean() == pytest.approx(y0, abs=PIXEL)


def test_a_drawn_arm_moves() -> None:
    figure, axes = empty((-1.5, 1.5, -1.5, 1.5), 4.0)
    drawn = plotting.DrawnArm(axes, jtik.Robot.planar(1), color="black").move([0.0])
    first = pixels(figure)
    drawn.move([np.pi / 2])
    assert share_of_different(pixels(figure), np.rot90(first)) < SNAP
    assert share_of_different(pixels(figure), first) > 10 * SNAP


def test_postures_go_from_light_to_dark() -> None:
    brightness = [sum(color[:3]) for color in plotting.shades(12)]
    assert all(np.diff(brightness) < 0)


def test_discs_and_points_are_drawn_where_they_are() -> None:
    figure, axes = empty((-2, 2, -1, 1), 4.0)
    blank = pixels(figure)
    plotting.draw_obstacles(axes, [jtik.Circle((1, 0), 0.5), jtik.Point((-1, 0))])
    changed = np.abs(pixels(figure) - blank).max(axis=2) > 8
    scale = plotting.points_per_metre(axes) * figure.dpi / 72
    left, right = np.split(changed, 2, axis=1)
    assert right.sum() == pytest.approx(np.pi * (0.5 * scale + OUTLINE) ** 2, rel=0.03)
    _, columns = np.nonzero(left)
    assert columns.mean() == pytest.approx(axes.transData.transform((-1, 0))[0], abs=PIXEL)


def test_spheres_are_refused() -> None:
    _, axes = plotting.blank_figure((-1, 1, -1, 1))
    with pytest.raises(jtik.ArgumentError, match="circles"):
        plotting.draw_obstacles(axes, [jtik.Sphere((0, 0, 0), 1.0)])


def test_robots_out_of_the_plane_are_refused_on_plane_axes() -> None:
    _, axes = plotting.blank_figure((-1, 1, -1, 1))
    with pytest.raises(jtik.ArgumentError, match="planar"):
        plotting.DrawnArm(axes, jtik.Robot.from_dh([(0.5, 0.0, 0.0, 0.0)]))


def test_a_window_holds_points_and_obstacles() -> None:
    left, right, bottom, top = plotting.window_around([[0, 0], [1, 2]], [jtik.Circle((3, 0), 0.5)], margin=0.0)
    assert (left, right, bottom, top) == (0, 3.5, -0.5, 2)


def test_a_posture_figure_takes_one_configuration_or_several(arm: jtik.Robot) -> None:
    one = plotting.posture_figure(arm, [0.1, 0.2, 0.3], width=4.0)
    several = plotting.posture_figure(
        arm, [[0.1, 0.2, 0.3], [2.0, 0.2, 0.3]], obstacles=[jtik.Circle((1, 1), 0.2)], path=[(0, 0), (1, 1)], width=4.0
    )
    dark = [(pixels(figure).min(axis=2) < 200).sum() for figure in (one, several)]
    assert dark[0] > 100
    assert len(several.axes[0].collections) == 2 * len(one.axes[0].collections)
    bases = len(one.axes[0].patches)
    assert len(several.axes[0].patches) == bases + 1


def test_an_animation_has_the_frames_it_was_given(arm: jtik.Robot, tmp_path: Path) -> None:
    figure, axes = plotting.blank_figure((-2, 2, -2, 2), 2.0)
    drawn = plotting.DrawnArm(axes, arm, color="black")
    file = tmp_path / "arm.gif"
    plotting.write_animation(file, figure, lambda k: drawn.move([0.5 * k, 0, 0]) and None, 4, seconds=0.1, hold=0.5)
    with image.open(file) as animation:
        assert animation.n_frames == 4
        durations, frames = [], []
        for k in range(4):
            animation.seek(k)
            durations.append(animation.info["duration"])
            frames.append(np.asarray(animation.convert("RGB")).astype(int))
    assert durations == [100, 100, 100, 500]
    assert all(np.abs(a - b).max() > 128 for a, b in itertools.pairwise(frames))
    np.testing.assert_allclose(frames[-1], pixels(figure), atol=48)


def test_the_label_of_an_axis_has_room(arm: jtik.Robot) -> None:
    figure = plotting.posture_figure(arm, [1.2, 0.1, -0.3], width=4.0)
    figure.canvas.draw()
    axes, renderer = figure.axes[0], figure.canvas.get_renderer()
    names = [text.get_window_extent(renderer) for text in axes.texts]
    ticks = [each.get_window_extent(renderer) for each in (*axes.get_xticklabels(), *axes.get_yticklabels())]
    assert len(names) == 2
    assert len(ticks) > 4
    assert not any(name.overlaps(tick) for name in names for tick in ticks)


def test_a_missing_matplotlib_is_named_with_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    without(monkeypatch, "matplotlib")
    with pytest.raises(jtik.MissingExtraError, match=r"matplotlib.*pip install 'jtik\[plot\]'"):
        plotting.blank_figure((0, 1, 0, 1))


def test_a_missing_pillow_is_named_with_its_extra(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    figure, _ = plotting.blank_figure((0, 1, 0, 1), 1.0)
    without(monkeypatch, "PIL")
    with pytest.raises(jtik.MissingExtraError, match=r"pillow.*pip install 'jtik\[plot\]'"):
        plotting.write_animation(tmp_path / "a.gif", figure, lambda k: None, 1)


def without(monkeypatch: pytest.MonkeyPatch, package: str) -> None:
    """As if the package were not installed."""
    real = builtins.__import__

    def fake(name: str, *arguments: Any, **options: Any) -> Any:
        if name.partition(".")[0] == package:
            raise ImportError(name)
        return real(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", fake)


@pytest.mark.slow
def test_importing_plotting_does_not_import_matplotlib() -> None:
    root = Path(jtik.__file__).parents[1]
    code = (
        "import sys, jtik.plotting, jtik.demo, jtik.cli; sys.exit('matplotlib' in sys.modules or 'rich' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], cwd=root, check=False).returncode == 0


def test_the_former_module_has_the_same_names() -> None:
    from jtik.plotting import planar

    assert all(getattr(planar, name) is getattr(plotting, name) for name in plotting.__all__)


@pytest.mark.slow
def test_every_planar_obstacle_is_drawn_where_it_is() -> None:
    obstacles = [
        jtik.Capsule((0.0, 0.0), (1.0, 0.5), 0.2),
        jtik.Box.at((2.0, 1.0), (0.5, 0.2), 0.4),
        jtik.Polygon([(-1, 1), (0, 1), (-0.5, 2)]),
        jtik.HalfSpace((0.0, -1.0), (0.0, 2.0)),
    ]
    left, right, bottom, top = plotting.window_around([(0.0, 0.0)], obstacles)
    _, axes = plotting.blank_figure((left, right, bottom, top))
    plotting.draw_obstacles(axes, obstacles)
    assert axes.get_xlim() == (left, right)
    assert axes.get_ylim() == (bottom, top)
    outlines = [patch.get_path().transformed(patch.get_patch_transform()) for patch in axes.patches]
    for x in np.linspace(left, right, 30):
        for y in np.linspace(bottom, top, 30):
            inside = any(outline.contains_point((x, y)) for outline in outlines)
            depth = min(distance(each, (x, y))[0] for each in obstacles)
            if abs(depth) > 0.01:
                assert inside == (depth < 0)

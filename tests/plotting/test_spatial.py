"""Pictures of robots in space: where surfaces are, equal scale, and labels that can be read."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

import jtik
from jtik.geometry import HalfSpace
from jtik.plotting.body import Body, Poses
from jtik.plotting.surfaces import extent_of

pytest.importorskip("matplotlib")

TOUCHING = 0.5
"""Overlap of two texts in pixels that is rounding."""


@pytest.fixture(scope="module")
def arm() -> jtik.Robot:
    return jtik.Robot.builtin("ur5e")


def drawn_triangles(figure: Any) -> np.ndarray:
    """The corners (m, 3, 3) of all triangles."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    (collection,) = [each for each in figure.axes[0].collections if isinstance(each, Poly3DCollection)]
    return np.asarray(collection._vec[:3].T.reshape(-1, 3, 3) if hasattr(collection, "_vec") else collection._faces)


def texts(figure: Any) -> list[Any]:
    """The boxes of all labels of 3-D axes."""
    figure.canvas.draw()
    axes, renderer = figure.axes[0], figure.canvas.get_renderer()
    boxes = []
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        low, high = sorted(axis.get_view_interval())  # others are not drawn
        labels = [axis.label, *(tick.label1 for tick in axis.majorTicks if low <= tick.get_loc() <= high)]
        boxes += [each.get_window_extent(renderer) for each in labels if each.get_text()]
    return boxes


def test_poses_are_those_of_the_kinematics(arm: jtik.Robot) -> None:
    q = arm.random_configuration(1)
    for frame, pose in Poses(arm)(q).items():
        np.testing.assert_allclose(pose, arm.pose(q, frame), atol=1e-12)


def test_solids_are_drawn_at_their_frames(arm: jtik.Robot) -> None:
    q = arm.random_configuration(2)
    drawn = Body(arm).surfaces(q)
    solids = [(frame, solid) for frame, own in arm.shapes.items() for solid in own]
    for (frame, solid), each in zip(solids, drawn, strict=True):
        pose = arm.pose(q, frame)
        middle = pose[:3, :3] @ ((solid.start + solid.end) / 2) + pose[:3, 3]
        np.testing.assert_allclose(each.vertices.mean(axis=0), middle, atol=1e-9)


def test_a_robot_without_solids_is_drawn_by_links() -> None:
    robot = jtik.Robot.from_dh([(0.4, 0.3, 0.1, 0.0), (0.3, 0.0, 0.0, 0.0)])
    body = Body(robot)
    q = [0.3, -0.4]
    assert len(body.links) == len(body.surfaces(q)) == len(robot.segments)
    for (inner, outer), each in zip(body.links, body.surfaces(q), strict=True):
        middle = (robot.position(q, inner) + robot.position(q, outer)) / 2
        np.testing.assert_allclose(each.vertices.mean(axis=0), middle, atol=1e-9)


def test_what_is_drawn_is_the_body_and_the_obstacles(arm: jtik.Robot) -> None:
    field = [jtik.Sphere((0.5, 0.5, 0.5), 0.1), jtik.Box.at((0.5, -0.5, 0.1), (0.1, 0.1, 0.1))]
    corners = drawn_triangles(arm.plot(obstacles=field, width=3.0)).reshape(-1, 3)
    own = np.concatenate([each.vertices for each in Body(arm).surfaces(arm.home)])
    low, high = own.min(axis=0), own.max(axis=0)
    for point in (low, high):
        assert np.abs(corners - point).min(axis=0).max() < 1e-9
    assert corners[:, 1].max() == pytest.approx(0.6, abs=0.03)  # only what is seen of it
    assert corners[:, 1].min() == pytest.approx(-0.6, abs=1e-9)


@pytest.mark.slow
def test_every_shape_in_space_is_drawn(arm: jtik.Robot) -> None:
    bare = len(drawn_triangles(arm.plot(show="links", width=2.0)))
    field = [
        jtik.Point((0.5, 0, 0.5)),
        jtik.Sphere((0.5, 0.5, 0.5), 0.1),
        jtik.Capsule((0.5, 0.5, 0.5), (0.5, 0.5, 0.8), 0.05),
        jtik.Cylinder((0.5, 0.5, 0.5), (0.5, 0.5, 0.8), 0.05),
        jtik.Box.at((0.5, -0.5, 0.1), (0.1, 0.1, 0.1)),
        HalfSpace((0, 0, -0.1), (0, 0, 1)),
    ]
    for obstacle in field:
        assert len(drawn_triangles(arm.plot(obstacles=obstacle, show="links", width=2.0))) > bare


@pytest.mark.slow
def test_several_postures_have_their_own_colours(arm: jtik.Robot) -> None:
    table = np.array([arm.home, arm.home + 0.3, arm.home + 0.6])
    figure = arm.plot(table, width=3.0)
    colors = {tuple(color) for color in np.round(figure.axes[0].collections[0].get_facecolor(), 2)}
    assert len(colors) > 3
    assert len(drawn_triangles(figure)) > 2.5 * len(drawn_triangles(arm.plot(table[0], show="links", width=3.0)))


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    ("q", "view"),
    [
        (np.zeros(6), (22.0, -52.0)),
        (np.array([0.0, -np.pi / 2, 0, 0, 0, 0]), (50.0, -120.0)),
        (np.array([1.0, -1.2, 1, 0, 0, 0]), (15.0, 35.0)),
    ],
    ids=["straight", "upright", "bent"],
)
def test_labels_do_not_overlap_and_the_scale_is_equal(
    arm: jtik.Robot, q: np.ndarray, view: tuple[float, float]
) -> None:
    figure = arm.plot(q, width=4.0, view=view)
    boxes = texts(figure)
    assert len(boxes) >= 9
    for one, other in itertools.combinations(boxes, 2):
        across = min(one.x1, other.x1) - max(one.x0, other.x0)
        up = min(one.y1, other.y1) - max(one.y0, other.y0)
        assert min(across, up) < TOUCHING
    axes = figure.axes[0]
    spans = np.array([np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim()), np.ptp(axes.get_zlim())])
    shares = axes._box_aspect / spans
    np.testing.assert_allclose(shares, shares[0], rtol=1e-6)


def test_the_picture_fills_the_figure(arm: jtik.Robot) -> None:
    figure = arm.plot(width=4.0)
    figure.canvas.draw()
    picture = np.asarray(figure.canvas.buffer_rgba())[..., :3].astype(int)
    inked = np.abs(picture - picture[0, 0]).max(axis=2) > 20
    rows, columns = np.nonzero(inked)
    assert figure.get_size_inches()[0] == 4.0
    assert np.ptp(columns) > 0.9 * picture.shape[1]
    assert np.ptp(rows) > 0.9 * picture.shape[0]
    assert inked.any(axis=1)[:3].sum() == inked.any(axis=0)[:3].sum() == 0  # and nothing is cut off


def test_arguments_of_a_figure_in_space_are_checked(arm: jtik.Robot) -> None:
    with pytest.raises(jtik.ArgumentError, match="window"):
        arm.plot(window=(0, 1, 0, 1))
    with pytest.raises(jtik.ArgumentError, match="show"):
        arm.plot(show="meshes")
    with pytest.raises(jtik.ArgumentError, match="view"):
        arm.plot(view=3.0)
    with pytest.raises(jtik.ArgumentError, match="in space"):
        arm.plot(obstacles=[jtik.Circle((0, 0), 1.0)])


def test_an_extent_is_the_ball_around_the_box_of_points() -> None:
    extent = extent_of(np.array([[0.0, 0, 0], [2, 2, 1]]))
    np.testing.assert_array_equal(extent.middle, [1, 1, 0.5])
    assert extent.radius == pytest.approx(1.5)

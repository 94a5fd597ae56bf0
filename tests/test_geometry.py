"""Points, circles and spheres, and signed distances to them."""

from __future__ import annotations

import pickle

import casadi
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import jtik
from jtik.geometry import centers_and_radii, enclosing_segment, point_to_ball, segment_to_ball

from .conftest import EXACT


def evaluate(distance, *arguments):
    """Value and gradient with respect to all arguments but the radius."""
    symbols = [casadi.SX.sym(f"a{i}", len(np.atleast_1d(a))) for i, a in enumerate(arguments)]
    value = distance(*symbols)
    everything = casadi.vertcat(*symbols[:-1])
    function = casadi.Function("distance", symbols, [value, casadi.gradient(value, everything)])
    value, gradient = function(*arguments)
    return float(value), gradient.full()[:, 0]


@pytest.mark.parametrize("dimension", [2, 3])
def test_point_to_ball(dimension, rng):
    for _ in range(20):
        point, center = rng.standard_normal((2, dimension))
        value, gradient = evaluate(point_to_ball, point, center, 0.3)
        away = point - center
        assert value == pytest.approx(np.linalg.norm(away) - 0.3, abs=EXACT)
        assert gradient[:dimension] == pytest.approx(away / np.linalg.norm(away), abs=EXACT)


def test_at_its_centre_a_ball_has_minus_its_radius_and_no_gradient():
    value, gradient = evaluate(point_to_ball, [1.0, 2.0], [1.0, 2.0], 0.5)
    assert value == pytest.approx(-0.5, abs=EXACT)
    assert np.isfinite(gradient).all()


@pytest.mark.parametrize("dimension", [2, 3])
def test_segment_to_ball_finds_the_closest_point(dimension, rng):
    for _ in range(50):
        start, end, center = rng.standard_normal((3, dimension))
        value, _ = evaluate(segment_to_ball, start, end, center, 0.2)
        best = minimize_scalar(
            lambda t, s=start, e=end, c=center: np.sum((s + t * (e - s) - c) ** 2),
            bounds=(0, 1),
            method="bounded",
            options={"xatol": 1e-12},
        )
        closest = min(best.fun, np.sum((start - center) ** 2), np.sum((end - center) ** 2))
        assert value == pytest.approx(np.sqrt(closest) - 0.2, abs=1e-7)  # the bounded search stops at sqrt(eps)


@pytest.mark.parametrize("center", [(0.5, 0.0), (0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (-1.0, 0.0), (0.5, 1.0)])
def test_segment_to_ball_and_its_derivative_are_finite_everywhere(center):
    for end in ((1.0, 0.0), (0.0, 0.0)):
        value, gradient = evaluate(segment_to_ball, (0.0, 0.0), end, center, 0.1)
        assert np.isfinite(value)
        assert np.isfinite(gradient).all()


def test_a_segment_of_length_zero_is_a_point():
    assert evaluate(segment_to_ball, (1.0, 1.0), (1.0, 1.0), (4.0, 5.0), 1.0)[0] == pytest.approx(4.0, abs=EXACT)


def test_shapes_keep_their_numbers_and_cannot_change():
    center = np.array([1.0, 2.0])
    circle = jtik.Circle(center=center, radius=0.5)
    center[0] = 9.0
    assert circle.center.tolist() == [1.0, 2.0]
    assert circle.radius == 0.5
    assert "(1.0, 2.0)" in repr(circle)
    assert "0.5" in repr(circle)
    with pytest.raises(ValueError, match="read-only"):
        circle.center[0] = 3.0
    with pytest.raises(AttributeError):
        circle.radius = 1.0


@pytest.mark.parametrize(
    ("shape", "center"),
    [
        (jtik.Circle, (0, 0, 0)),
        (jtik.Sphere, (0, 0)),
        (jtik.Point, (0,)),
        (jtik.Point, 3.0),
        (jtik.Circle, (np.nan, 0)),
        (jtik.Sphere, (0, 0, np.inf)),
    ],
)
def test_a_centre_of_another_dimension_or_not_finite_is_refused(shape, center):
    with pytest.raises(jtik.ArgumentError, match="center.*finite coordinates"):
        shape(center)


@pytest.mark.parametrize("radius", [-0.1, np.nan, np.inf, (1.0, 2.0)])
def test_a_radius_is_a_finite_length(radius):
    with pytest.raises(jtik.ArgumentError, match="radius"):
        jtik.Circle((0, 0), radius)


def test_centers_and_radii_of_a_mixed_field():
    centers, radii = centers_and_radii([jtik.Point((1, 2)), jtik.Circle((3, 4), 0.5)], 2)
    assert centers.tolist() == [[1, 2], [3, 4]]
    assert radii.tolist() == [0.0, 0.5]


@pytest.mark.parametrize(("obstacle", "dimension"), [(jtik.Circle((0, 0)), 3), (jtik.Sphere((0, 0, 0)), 2), ("x", 2)])
def test_obstacles_of_another_dimension_are_refused(obstacle, dimension):
    with pytest.raises(jtik.ArgumentError, match=f"obstacles.*{dimension}-dimensional"):
        centers_and_radii([obstacle], dimension)


class TestEnclosingSegment:
    """A capsule about the axis holds every corner and rim of the solid."""

    def distance(self, points, segment):
        start, end, _ = segment
        along = end - start
        share = np.clip((points - start) @ along / max(along @ along, 1e-300), 0, 1)
        return np.linalg.norm(points - start - share[:, None] * along, axis=1)

    def test_of_a_box(self, rng):
        pose = np.eye(4)
        pose[:3, :3] = np.linalg.qr(rng.standard_normal((3, 3)))[0]
        pose[:3, 3] = 1.0, 2.0, 3.0
        half = np.array([0.1, 0.4, 0.2])
        corners = np.array(list(np.ndindex(2, 2, 2))) * 2 - 1
        segment = enclosing_segment(jtik.Box(pose, half))
        reach = self.distance((corners * half) @ pose[:3, :3].T + pose[:3, 3], segment)
        # the edges end at the ends of the axis, their corners as far from it as the radius
        assert reach.max() == pytest.approx(segment[2])

    def test_of_a_cylinder(self):
        segment = enclosing_segment(jtik.Cylinder((0, 0, 0), (0, 0, 1), 0.2))
        angle = np.linspace(0, 2 * np.pi, 50)
        rim = np.stack([0.2 * np.cos(angle), 0.2 * np.sin(angle), np.ones(50)], axis=1)
        assert self.distance(rim, segment).max() <= 0.2 + 1e-12

    def test_of_balls_and_of_anything_else(self):
        start, end, radius = enclosing_segment(jtik.Sphere((1, 2, 3), 0.4))
        assert start.tolist() == end.tolist() == [1, 2, 3]
        assert radius == 0.4
        assert enclosing_segment(jtik.Circle((1, 2), 0.4))[0].tolist() == [1, 2, 0]
        with pytest.raises(jtik.ArgumentError, match="solid"):
            enclosing_segment("box")


@pytest.mark.parametrize(
    ("build", "argument"),
    [
        (lambda: jtik.Capsule((0, 0), (0, 0, 1), 0.1), "end"),
        (lambda: jtik.Capsule((0, 0, 0), (0, 0, np.nan), 0.1), "end"),
        (lambda: jtik.Cylinder((0, 0, 0), (0, 0, 1), 0.0), "radius"),
        (lambda: jtik.Box(np.eye(3), (1, 1, 1)), "pose"),
        (lambda: jtik.Box(np.eye(4), (1, 0, 1)), "half"),
    ],
)
def test_solids_are_checked(build, argument):
    with pytest.raises(jtik.ArgumentError, match=argument):
        build()


@pytest.mark.parametrize(
    "solid",
    [
        jtik.Capsule((0, 0, 0), (0, 0, 1), 0.1),
        jtik.Cylinder((0, 0, 0), (0, 0, 1), 0.1),
        jtik.Box(np.eye(4), (1, 1, 1)),
    ],
)
def test_solids_survive_pickling(solid):
    again = pickle.loads(pickle.dumps(solid))
    assert type(again) is type(solid)
    assert repr(again) == repr(solid)


@pytest.mark.parametrize("solid", [jtik.HalfSpace((0, 0, 0), (0, 0, 1)), jtik.Polygon([(0, 0), (1, 0), (0, 1)])])
def test_half_spaces_and_polygons_are_no_bodies_of_a_robot(solid):
    with pytest.raises(jtik.ArgumentError, match=r"shapes\['tip'\].*Sphere"):
        jtik.Robot(jtik.Robot.planar(2).joints, planar=True, shapes={"tip": [solid]})


@pytest.mark.parametrize(
    "solid",
    [
        jtik.Circle((1, 2), 0.3),
        jtik.Capsule((0, 1, 2), (1, -1, 2), 0.2),
        jtik.Cylinder((0, 0, 0), (1, 2, 3), 0.3),
        jtik.Box.at((1, 2, 3), (0.1, 0.2, 0.3), (1, 2, 3, 4)),
        jtik.Polygon([(0, 0), (2, 0), (1, 1)]),
    ],
)
def test_the_bounds_of_a_solid_touch_it(solid, rng):
    """Along each axis a half-space beside the bounds touches the solid: judged by its support, sampled."""
    low, high = jtik.geometry.bounds(solid)
    match solid:
        case jtik.Circle():
            points = solid.center + solid.radius * np.stack([np.cos(t := np.linspace(0, 7, 4000)), np.sin(t)], axis=1)
        case jtik.Polygon():
            points = solid.vertices
        case jtik.Box():
            corners = np.array(list(np.ndindex(2, 2, 2))) * 2 - 1
            points = (corners * solid.half) @ solid.pose[:3, :3].T + solid.center
        case _:
            around = rng.normal(size=(200_000, 3))
            if isinstance(solid, jtik.Cylinder):
                axis = (solid.end - solid.start) / np.linalg.norm(solid.end - solid.start)
                around -= np.outer(around @ axis, axis)
            around *= solid.radius / np.linalg.norm(around, axis=1)[:, None]
            points = np.concatenate([solid.start + around, solid.end + around])
    assert points.min(axis=0) == pytest.approx(low, abs=1e-3)
    assert points.max(axis=0) == pytest.approx(high, abs=1e-3)


@pytest.mark.parametrize("half", [(0.4, 0.3, 0.1), (0.3, 0.3, 0.3), (1.0, 0.9, 0.01), (0.5, 0.1, 0.1)])
def test_balls_cover_a_box_and_are_thinner_than_its_capsule(half, rng):
    box = jtik.Box.at((1, 2, 3), half, (1, 2, 3, 4))
    balls = jtik.geometry.enclosing_balls(box)
    thickness = enclosing_segment(box)[2]
    if half in ((0.5, 0.1, 0.1), (0.3, 0.3, 0.3)):
        assert not balls  # a rod or a cube: the capsule is tighter
        return
    assert 1 <= len(balls) <= 64
    assert all(radius < thickness for _, radius in balls)
    points = rng.uniform(-1, 1, (3000, 3))
    points[:2000] /= np.abs(points[:2000]).max(axis=1)[:, None]  # on the surface
    points = np.concatenate([points, np.array(list(np.ndindex(2, 2, 2))) * 2 - 1]) * half
    world = points @ box.pose[:3, :3].T + box.center
    assert (np.min([np.linalg.norm(world - c, axis=1) - r for c, r in balls], axis=0) <= 1e-12).all()


def test_only_boxes_are_covered_by_balls():
    assert jtik.geometry.enclosing_balls(jtik.Cylinder((0, 0, 0), (0, 0, 1), 0.2)) == []
    with pytest.raises(jtik.ArgumentError, match="solid"):
        jtik.geometry.enclosing_balls(jtik.HalfSpace((0, 0, 0), (0, 0, 1)))

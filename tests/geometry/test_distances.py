"""Signed distances of points and segments to every shape: gradients, kinks, penetration, degenerate cases."""

from __future__ import annotations

import casadi
import numpy as np
import pytest
from scipy.spatial import ConvexHull

import jtik
from jtik.geometry import Axis, segment_to_cylinder

from ..conftest import EXACT
from .shapes import PLANAR, SPATIAL, distance, hessian, random_bodies, random_obstacle

EVERY = [*((kind, 2) for kind in PLANAR), *((kind, 3) for kind in SPATIAL)]

AXIS = 1e-6
"""Distance of a body from the axis of a ball or capsule below which the normal is not judged."""


@pytest.mark.quick(5)
@pytest.mark.parametrize(("kind", "dimension"), EVERY)
def test_moved_along_its_normal_a_body_gains_that_distance(kind, dimension, rng):
    """The gradient is finite everywhere, and that of a translation is a unit vector away from the obstacle."""
    for _ in range(15):
        obstacle = random_obstacle(kind, dimension, rng)
        for body in random_bodies(obstacle, 8, rng):
            d, gradient = distance(obstacle, *body)
            assert np.isfinite(d)
            assert np.isfinite(gradient).all()
            rounding = getattr(obstacle, "radius", 0.0) if kind in ("ball", "capsule") else 0.0
            if abs(d + rounding) < AXIS:
                continue
            normal = sum(np.split(gradient, len(body)))
            assert np.linalg.norm(normal) == pytest.approx(1, abs=1e-6)
            h = 1e-5
            there, back = (distance(obstacle, *(p + side * h * normal for p in body))[0] for side in (1, -1))
            assert there >= d + h * (1 - 1e-6) - 1e-9 or d < 0  # inside, the nearest side may be another one
            assert back <= d + 1e-9 or d < 0
            assert abs(there - d) <= h * (1 + 1e-6) + 1e-9  # it changes no faster than the body moves


@pytest.mark.quick(5)
@pytest.mark.parametrize(("kind", "dimension"), EVERY)
def test_the_gradient_agrees_with_differences(kind, dimension, rng):
    """Where both one-sided differences agree, so that no kink is near."""
    compared = 0
    for _ in range(25):
        obstacle = random_obstacle(kind, dimension, rng)
        for body in random_bodies(obstacle, 4, rng):
            _, gradient = distance(obstacle, *body)
            flat = np.concatenate(body)
            along = rng.normal(size=flat.size)
            h = 1e-6
            value = [distance(obstacle, *np.split(flat + s * h * along, len(body)))[0] for s in (-1, 0, 1)]
            if abs(value[2] - 2 * value[1] + value[0]) > 1e-3 * h:
                continue
            compared += 1
            assert gradient @ along == pytest.approx((value[2] - value[0]) / (2 * h), abs=1e-3)
    assert compared > 40


def to_segment(point, start, end):
    along = end - start
    share = np.clip((point - start) @ along / max(along @ along, 1e-300), 0, 1)
    return np.linalg.norm(start + share * along - point)


def planar_truth(corners, body):
    """The signed distance of two convex sets: that of the origin to their Minkowski difference."""
    differences = np.concatenate([corners - point for point in body])
    hull = ConvexHull(differences)
    depth = hull.equations[:, -1].max()
    around = differences[hull.vertices]
    if depth <= 0:
        return depth
    return min(to_segment(np.zeros(2), a, b) for a, b in zip(around, np.roll(around, -1, axis=0), strict=True))


def corners_of(obstacle):
    """The corners of what a planar obstacle is all points near."""
    if isinstance(obstacle, jtik.Polygon):
        return obstacle.vertices
    if isinstance(obstacle, jtik.Capsule):
        return np.array([obstacle.start, obstacle.end])
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * obstacle.half
    return corners @ obstacle.pose[:2, :2].T + obstacle.center


@pytest.mark.quick(1)
@pytest.mark.parametrize("kind", ["polygon", "box", "capsule"])
def test_in_the_plane_it_is_exact_outside_and_inside(kind, rng):
    """Against the Minkowski difference of both sets: inside, the depth is the shortest translation apart."""
    inside = 0
    for _ in range(60):
        obstacle = random_obstacle(kind, 2, rng)
        rounding = obstacle.radius if kind == "capsule" else 0.0
        for body in random_bodies(obstacle, 8, rng, reach=1.0):
            if kind == "capsule" and (len(body) == 1 or to_segment(body[0], *body) + np.ptp(body) == 0):
                continue  # no hull
            if kind == "capsule" and abs(np.linalg.det([body[1] - body[0], obstacle.end - obstacle.start])) < 1e-9:
                continue  # parallel: no hull
            truth = planar_truth(corners_of(obstacle), body)
            inside += truth < 0
            assert distance(obstacle, *body)[0] == pytest.approx(truth - rounding, abs=1e-9)
    assert inside > 20


def to_cylinder(points, cylinder):
    """Signed distances of points (k, 3)."""
    axis = cylinder.end - cylinder.start
    length = np.linalg.norm(axis)
    centered = points - (cylinder.start + cylinder.end) / 2
    height = centered @ axis / length
    beside = np.linalg.norm(centered - np.outer(height, axis / length), axis=1) - cylinder.radius
    beyond = np.stack([beside, np.abs(height) - length / 2], axis=1)
    return np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0)


def test_to_a_cylinder_it_is_that_of_the_closest_or_deepest_point(rng):
    """Against points of the segment, ever closer together around the best of them."""
    inside = 0
    for _ in range(60):
        obstacle = random_obstacle("cylinder", 3, rng)
        for body in random_bodies(obstacle, 8, rng):
            low, high = 0.0, 1.0
            for _ in range(10):
                share = np.linspace(low, high, 101)
                found = to_cylinder(body[0] + share[:, None] * (body[-1] - body[0]), obstacle)
                low, high = share[max(found.argmin() - 1, 0)], share[min(found.argmin() + 1, 100)]
            inside += found.min() < 0
            tolerance = 1e-8 if found.min() > 0 else 2e-6
            assert distance(obstacle, *body)[0] == pytest.approx(found.min(), abs=tolerance)
    assert inside > 5


@pytest.mark.parametrize("height", [0.3, 1e-3, 1e-6])
def test_a_segment_beside_a_face_of_a_box(height):
    """All points of a part of it are equally close; the normal is that of the face, and nothing jumps."""
    box = jtik.Box.at((0, 0, 0), (1, 1, 1))
    for tilt in (0.0, 1e-15, 1e-12, 1e-9, 1e-6):
        d, gradient = distance(box, np.array([-2.0, 0.2, 1 + height]), np.array([2.0, 0.2, 1 + height + tilt]))
        assert d == pytest.approx(height, abs=1e-6 if tilt == 1e-6 else 1e-8)
        normal = gradient[:3] + gradient[3:]
        assert normal == pytest.approx([0, 0, 1], abs=1e-6)
        assert np.abs(gradient).max() < 2.1


def test_a_segment_through_a_box_is_as_deep_as_the_shortest_way_out():
    box = jtik.Box.at((0, 0, 0), (1.0, 0.5, 0.2))
    d, gradient = distance(box, np.array([-3.0, 0.1, 0.05]), np.array([3.0, 0.1, 0.05]))
    assert d == pytest.approx(-0.15, abs=EXACT)
    assert gradient[:3] + gradient[3:] == pytest.approx([0, 0, 1], abs=EXACT)
    assert distance(box, np.zeros(3))[0] == pytest.approx(-0.2, abs=EXACT)


def test_a_segment_that_crosses_the_axis_of_a_capsule_in_the_plane_is_pushed_out():
    capsule = jtik.Capsule((-1.0, 0.0), (1.0, 0.0), 0.1)
    d, gradient = distance(capsule, np.array([0.0, -0.3]), np.array([0.0, 2.0]))
    assert d == pytest.approx(-0.4, abs=EXACT)
    assert gradient[:2] + gradient[2:] == pytest.approx([0, 1], abs=EXACT)


def test_corners_that_are_repeated_change_nothing():
    triangle = jtik.Polygon([(0, 0), (1, 0), (0, 1)])
    for point, expected in (((0.25, 0.25), -0.25), ((0.5, -0.5), 0.5), ((2, 0), 1), ((1, 1), np.sqrt(0.5))):
        assert distance(triangle, np.array(point, dtype=float))[0] == pytest.approx(expected, abs=EXACT)


@pytest.mark.thinned
@pytest.mark.parametrize("radius", [1e-6, 0.1, 1e6])
@pytest.mark.parametrize("across", [(0.0, 0.0, 0.01), (0.3, 0.0, 0.0)])
@pytest.mark.parametrize("along", [(0.0, -1e-6, 0.0), (0.0, 1.0, 0.0)])
def test_derivatives_of_a_segment_whose_middle_is_on_the_axis_of_a_cylinder_are_finite(radius, across, along):
    """As of a capsule about a joint that a cylinder stands on: the distance from the axis is zero there."""
    middle = np.array([0.6581505646763794, 0.5024167236629001, 0.0628])
    ends = [casadi.SX.sym(name, 3) for name in "ab"]
    axis = Axis.between(casadi.SX(middle), casadi.SX(middle + along), casadi.SX(radius))
    d = segment_to_cylinder(*ends, axis)
    H, g = casadi.hessian(d, casadi.vertcat(*ends))
    found = casadi.Function("derivatives", ends, [d, g, H])(middle - across, middle + across)
    assert all(np.isfinite(each.full()).all() for each in found)


@pytest.mark.parametrize(("kind", "dimension"), [each for each in EVERY if each[0] not in ("half_space", "polygon")])
@pytest.mark.parametrize("size", [1, 2])
def test_at_its_very_centre_an_obstacle_can_be_left(kind, dimension, size, rng):
    """A point at the centre, or a segment through it: finite derivatives; from a box or cylinder they lead out."""
    for _ in range(20):
        obstacle = random_obstacle(kind, dimension, rng)
        ends = (obstacle.start, obstacle.end) if hasattr(obstacle, "start") else (obstacle.center, obstacle.center)
        middle = (ends[0] + ends[1]) / 2
        along = rng.normal(size=dimension)
        body = [middle] if size == 1 else [middle - along, middle + along]
        d, gradient = distance(obstacle, *body)
        assert np.isfinite(d)
        assert np.isfinite(gradient).all()
        if kind not in ("ball", "capsule"):  # where the way out is as long in every direction
            assert np.linalg.norm(gradient) > 1e-3
        h = hessian(obstacle, *body)
        assert np.isfinite(h).all()
        assert np.abs(h).max() < 1e15

"""Closest points and normals: on both surfaces, as far apart as the distance says, and those of coal."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik.geometry import witness

from ..conftest import EXACT
from .shapes import PLANAR, SPATIAL, distance, random_bodies, random_obstacle

EVERY = [*((kind, 2) for kind in PLANAR), *((kind, 3) for kind in SPATIAL)]
RADIUS = 0.05

CLOSE = 1e-6
"""Tolerance of points [m]; for a cylinder the closest point of a segment is found to 1e-7 of its length."""


def to_segment(point, body):
    """Distance of a point from a point or a segment."""
    along = body[-1] - body[0]
    share = np.clip((point - body[0]) @ along / max(along @ along, 1e-300), 0, 1)
    return np.linalg.norm(body[0] + share * along - point)


@pytest.mark.quick(4)
@pytest.mark.parametrize(("kind", "dimension"), EVERY)
def test_both_points_are_on_their_surfaces_and_the_distance_apart(kind, dimension, rng):
    apart = 0
    for _ in range(4):
        obstacle = random_obstacle(kind, dimension, rng)
        for body in random_bodies(obstacle, 4, rng):
            found = witness(obstacle, *body, radius=RADIUS)
            assert found.distance == pytest.approx(distance(obstacle, *body)[0] - RADIUS, abs=EXACT)
            if distance(obstacle, *body)[0] < 1e-3:
                continue
            apart += 1
            assert np.linalg.norm(found.normal) == pytest.approx(1, abs=1e-9)
            assert found.on_body - found.on_obstacle == pytest.approx(found.distance * found.normal, abs=1e-9)
            assert distance(obstacle, found.on_obstacle)[0] == pytest.approx(0, abs=CLOSE)
            assert to_segment(found.on_body, body) == pytest.approx(RADIUS, abs=CLOSE)
    assert apart > 1


@pytest.mark.quick(2)
@pytest.mark.parametrize("kind", SPATIAL)
def test_they_are_those_of_coal(kind, rng):
    from .coal_distances import coal, frame_along, in_coal

    differences = []
    for _ in range(60 if kind == "half_space" else 15):
        solid = random_obstacle(kind, 3, rng)
        for body in random_bodies(solid, 3, rng):
            found = witness(solid, *body, radius=RADIUS)
            if found.distance < 1e-2 or len(body) == 1 or np.array_equal(*body):
                continue
            result = coal.DistanceResult()
            request = coal.DistanceRequest()
            request.gjk_tolerance, request.gjk_max_iterations = 1e-12, 1000
            capsule = coal.Capsule(RADIUS, np.linalg.norm(body[1] - body[0]))
            coal.distance(*in_coal(solid), capsule, frame_along(*body), request, result)
            pairs = ((found.on_obstacle, result.getNearestPoint1()), (found.on_body, result.getNearestPoint2()))
            differences.append(max(np.abs(ours - theirs).max() for ours, theirs in pairs))
    assert len(differences) > 8
    assert np.quantile(differences, 0.9) < 1e-4  # coal stops early, and parallel edges have several pairs
    assert np.median(differences) < 1e-5


def test_expressions_give_the_same_numbers(rng):
    solid, start, end = random_obstacle("box", 3, rng), np.array([1.5, 2.0, 0.3]), np.array([2.0, -1.0, 1.0])
    numbers = witness(solid, start, end, radius=RADIUS)
    for kind in (casadi.SX, casadi.MX):
        ends = [kind.sym("a", 3), kind.sym("b", 3)]
        function = casadi.Function("f", ends, list(witness(solid, *ends, radius=RADIUS)))
        for one, other in zip(function(start, end), numbers, strict=True):
            assert one.full().ravel() == pytest.approx(np.ravel(other), abs=EXACT)
    mixed = witness(solid, casadi.SX(start), end, radius=RADIUS)
    assert float(mixed.distance) == pytest.approx(numbers.distance, abs=EXACT)


def test_a_ball_by_hand():
    found = witness(jtik.Sphere([1.0, 0.0, 0.0], 0.25), [0.0, 0.0, -1.0], [0.0, 0.0, 1.0], radius=0.05)
    assert found.distance == pytest.approx(0.7)
    assert found.on_body == pytest.approx([0.05, 0, 0])
    assert found.on_obstacle == pytest.approx([0.75, 0, 0])
    assert found.normal == pytest.approx([-1, 0, 0])


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((5, [0.0, 0.0]), "obstacle: given 5; accepted: jtik.Point"),
        ((jtik.Circle([0, 0], 1.0),), "points: given 0 points; accepted: one point"),
        ((jtik.Circle([0, 0], 1.0), [0, 0], [1, 0], [2, 0]), "points: given 3 points"),
        ((jtik.Circle([0, 0], 1.0), [0, 0, 1]), r"points\[0\]: given .*shape \(2,\)"),
        ((jtik.Circle([0, 0], 1.0), [0, 0], casadi.SX.sym("x", 3)), r"points\[1\]: given an expression of shape"),
        ((jtik.Circle([0, 0], 1.0), [np.nan, 0]), r"points\[0\]"),
    ],
)
def test_what_cannot_be_used_is_named(arguments, says):
    with pytest.raises(jtik.ArgumentError, match=says):
        witness(*arguments)
    with pytest.raises(jtik.ArgumentError, match="radius: given -1"):
        witness(jtik.Circle([0, 0], 1.0), [0, 0], radius=-1.0)

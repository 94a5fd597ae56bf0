"""The distance between two segments, against MuJoCo's capsules and a search in extended precision."""

from __future__ import annotations

import casadi
import mujoco
import numpy as np
import pytest

from jtik.geometry import closest_points, segment_distances, segment_to_segment
from jtik.geometry.segments import CROSSING

from ..conftest import EXACT

RADIUS = 0.01
CAPSULES = f"""<mujoco><worldbody>
  <body><freejoint/><geom type="capsule" size="{RADIUS} 1"/></body>
  <body><freejoint/><geom type="capsule" size="{RADIUS} 1"/></body>
</worldbody></mujoco>"""

NEARLY_PARALLEL = 2e-10
"""Within 1e-6 rad of parallel, at more than 1 mm and up to 1 m long: (1e-6)^2 / 4 over twice the distance."""


@pytest.fixture(scope="module", params=[2, 3])
def evaluated(request):
    """Distance, gradient, Hessian and the two points as functions of four ends in the plane or in space."""
    ends = casadi.SX.sym("ends", 4 * request.param)
    distance = segment_to_segment(*casadi.vertsplit(ends, request.param))
    points = closest_points(*casadi.vertsplit(ends, request.param))
    hessian, gradient = casadi.hessian(distance, ends)
    return casadi.Function("distance", [ends], [distance, gradient, hessian, *points]), request.param


def share_between(point, start, end):
    along = end - start
    return np.clip((point - start) @ along / (along @ along), 0, 1) if along @ along > 0 else 0


def smallest(ends):
    """The distance of two segments: of an end to the other segment, or of the lines where these are closest inside."""
    a, b, c, d = (np.pad(np.asarray(end, np.longdouble), (0, 3 - len(end))) for end in ends)
    sides = [(a, c, d), (b, c, d), (c, a, b), (d, a, b)]
    found = [np.linalg.norm(p + share_between(x, p, q) * (q - p) - x) for x, p, q in sides]
    normal = np.cross(b - a, d - c)
    if normal @ normal > 0:
        s, t = (np.cross(c - a, each) @ normal / (normal @ normal) for each in (d - c, b - a))
        if 0 <= s <= 1 and 0 <= t <= 1:
            found.append(np.linalg.norm(c + t * (d - c) - a - s * (b - a)))
    return float(min(found))


def some_ends(rng, kind, dimension):
    a, b, c, d = rng.uniform(-1, 1, (4, dimension)) / 2
    middle = rng.uniform(-0.3, 0.3, dimension)
    if kind == "parallel":
        d = c + (b - a) * rng.uniform(-2, 2)
    elif kind == "in line":
        c, d = (a + (b - a) * rng.uniform(-2, 3) for _ in range(2))
    elif kind == "crossing":
        b, d = 2 * middle - a, 2 * middle - c
    elif kind == "a point":
        b = a
    elif kind == "points":
        b, d = a, c
    elif kind == "one point":
        b = c = d = a
    return a, b, c, d


KINDS = ("skew", "parallel", "in line", "crossing", "a point", "points", "one point")


@pytest.mark.quick(5)
@pytest.mark.parametrize("kind", KINDS)
def test_it_is_the_smallest_distance_of_their_points_and_its_derivatives_are_finite(evaluated, kind, rng):
    function, dimension = evaluated
    for _ in range(60):
        ends = some_ends(rng, kind, dimension)
        for order in ((0, 1, 2, 3), (3, 2, 0, 1)):
            distance, gradient, hessian, *_ = function(np.concatenate([ends[i] for i in order]))
            expected = smallest(ends)
            assert float(distance) == pytest.approx(expected if expected > CROSSING else 0, abs=EXACT)
            assert gradient.full().any() == (expected > CROSSING)
            assert np.isfinite(gradient.full()).all()
            assert np.abs(gradient.full()).max() <= 1 + 1e-6
            assert np.isfinite(hessian.full()).all()


@pytest.mark.quick(3)
@pytest.mark.parametrize("exponent", range(-16, -2, 2))
def test_it_is_accurate_for_segments_that_are_nearly_parallel(exponent, rng):
    ends = casadi.SX.sym("ends", 12)
    function = casadi.Function("distance", [ends], [segment_to_segment(*casadi.vertsplit(ends, 3))])
    for _ in range(200):
        a, b, c = rng.uniform(-1, 1, (3, 3)) / 2
        d = c + (b - a) * rng.uniform(-1, 1) + 10.0**exponent * rng.standard_normal(3)
        distance = smallest((a, b, c, d))
        if distance > 1e-3:
            assert float(function(np.concatenate([a, b, c, d]))) == pytest.approx(distance, abs=NEARLY_PARALLEL)


@pytest.mark.parametrize("kind", ["skew", "parallel", "in line", "crossing"])
def test_capsules_around_them_are_as_far_apart_as_mujoco_says(kind, rng):
    ends = casadi.SX.sym("ends", 12)
    function = casadi.Function("distance", [ends], [segment_to_segment(*casadi.vertsplit(ends, 3)) - 2 * RADIUS])
    model = mujoco.MjModel.from_xml_string(CAPSULES)
    data = mujoco.MjData(model)
    for _ in range(60):
        given = some_ends(rng, kind, 3)
        for geom in range(2):
            start, end = given[2 * geom : 2 * geom + 2]
            along = end - start
            model.geom_size[geom, 1] = np.linalg.norm(along) / 2
            turn = np.zeros(4)
            mujoco.mju_quatZ2Vec(turn, along / np.linalg.norm(along))
            data.qpos[7 * geom : 7 * geom + 7] = [*(start + end) / 2, *turn]
        mujoco.mj_kinematics(model, data)
        expected = mujoco.mj_geomDistance(model, data, 0, 1, 10.0, None)
        assert float(function(np.concatenate(given))) == pytest.approx(expected, abs=1e-12)


def test_its_gradient_is_that_of_the_closest_points(evaluated, rng):
    """Along the line between them, on each end by its share: the derivative of the shares adds nothing."""
    function, dimension = evaluated
    compared = 0
    while compared < 100:
        ends = some_ends(rng, "skew", dimension)
        distance, gradient, _, first, second = (each.full().squeeze() for each in function(np.concatenate(ends)))
        if distance < 1e-3:
            continue
        compared += 1
        away = (first - second) / distance
        s, t = share_between(first, *ends[:2]), share_between(second, *ends[2:])
        expected = np.concatenate([(1 - s) * away, s * away, -(1 - t) * away, -t * away])
        assert gradient == pytest.approx(expected, abs=1e-9)


APART = {
    "inside both": [-1.0, 0.1, 0, 1, -0.1, 0.1, 0.2, -1, 0.6, 0.1, 1, 0.5],
    "an end of one": [-1.0, 0.1, 0, 1, -0.1, 0.1, 0.2, 0.1, 0.6, 0.3, 0.4, 1.5],
    "an end of the other": [0.2, 0.1, 0.6, 0.3, 0.4, 1.5, -1.0, 0.1, 0, 1, -0.1, 0.1],
    "two ends": [-1.0, 0.1, 0, 1, -0.1, 0.1, 1.5, 0.1, 0.6, 2.3, 0.4, 1.5],
}


@pytest.mark.parametrize("where", APART)
def test_its_hessian_has_the_motion_of_the_closest_points(where):
    """Against differences of the gradient, away from where a closest point reaches an end."""
    ends = casadi.SX.sym("ends", 12)
    hessian, gradient = casadi.hessian(segment_to_segment(*casadi.vertsplit(ends, 3)), ends)
    function = casadi.Function("distance", [ends], [gradient, hessian])
    given = np.array(APART[where])
    step = 1e-5
    rows = [
        (function(given + step * unit)[0] - function(given - step * unit)[0]).full()[:, 0] / (2 * step)
        for unit in np.eye(12)
    ]
    assert np.array(rows) == pytest.approx(function(given)[1].full(), abs=1e-7)


def test_near_parallel_segments_the_gradient_has_length_one(rng):
    """Where the closest points move most: a Newton step from them multiplies rounding errors only."""
    ends = casadi.SX.sym("ends", 12)
    distance = segment_to_segment(*casadi.vertsplit(ends, 3))
    function = casadi.Function("distance", [ends], [distance, casadi.gradient(distance, ends)])
    for exponent in np.linspace(-9, -1, 33):
        for _ in range(50):
            middle, u = rng.uniform(-1, 1, (2, 3)) / 2
            v, gap = u + 10.0**exponent * rng.standard_normal(3), rng.standard_normal(3)
            gap *= 0.1 / np.linalg.norm(gap)
            given = np.concatenate([middle - u, middle + u, middle + gap - v, middle + gap + v])
            _, gradient = function(given)
            rate = (gradient.full().reshape(4, 3)[:2].sum(axis=0) ** 2).sum()
            assert rate == pytest.approx(1, abs=1e-4)


@pytest.mark.quick(3)
@pytest.mark.parametrize("kind", KINDS)
def test_many_at_once_are_as_far_apart_as_one_by_one(kind, rng):
    given = np.array([some_ends(rng, kind, 3) for _ in range(200)])
    expected = [smallest(each) for each in given]
    assert segment_distances(*given.swapaxes(0, 1)) == pytest.approx(expected, abs=EXACT)


def test_first_derivatives_alone_are_the_same(evaluated, rng):
    _, dimension = evaluated
    ends = casadi.SX.sym("ends", 4 * dimension)
    parts = casadi.vertsplit(ends, dimension)
    both = [segment_to_segment(*parts), segment_to_segment(*parts, first_order=True)]
    function = casadi.Function("both", [ends], [*both, *(casadi.gradient(each, ends) for each in both)])
    for _ in range(200):
        d, other, gradient, of_other = function(rng.uniform(-1, 1, 4 * dimension))
        assert float(d) == pytest.approx(float(other), abs=EXACT)
        if float(d) > 0.01:
            assert of_other.full() == pytest.approx(gradient.full(), abs=1e-9)

"""Random obstacles and bodies, and their distances as functions."""

from __future__ import annotations

import functools

import casadi
import numpy as np

import jtik
from jtik.geometry.kinds import KINDS

KIND = {kind.name: kind for kind in KINDS}

SPATIAL = ("ball", "capsule", "box", "half_space", "cylinder")
PLANAR = ("ball", "capsule", "box", "half_space", "polygon")


def quaternion(rng):
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


def polygon(rng):
    """A polygon with three to six corners on an ellipse."""
    while True:
        angles = np.sort(rng.uniform(0, 2 * np.pi, rng.integers(3, 7)))
        corners = np.stack([np.cos(angles), np.sin(angles)], axis=1) * rng.uniform(0.2, 0.8, 2)
        try:
            return jtik.Polygon(rng.uniform(-0.5, 0.5, 2) + corners[:: rng.choice([-1, 1])])
        except jtik.ArgumentError:  # too flat
            continue


def random_obstacle(kind, dimension, rng):
    center = rng.uniform(-1, 1, dimension)
    if kind == "ball":
        return (jtik.Circle if dimension == 2 else jtik.Sphere)(center, rng.uniform(0, 0.5))
    if kind == "box":
        rotation = rng.uniform(-4, 4) if dimension == 2 else quaternion(rng)
        return jtik.Box.at(center, rng.uniform(0.05, 0.6, dimension), rotation)
    if kind == "half_space":
        return jtik.HalfSpace(center, rng.normal(size=dimension))
    if kind == "polygon":
        return polygon(rng)
    solid = jtik.Capsule if kind == "capsule" else jtik.Cylinder
    return solid(center, center + 0.5 * rng.normal(size=dimension), rng.uniform(0.05, 0.4))


@functools.cache
def compiled(kind, dimension, points, sizes):
    """(points, numbers of the obstacle) -> distance, and its gradient with respect to the points."""
    ends = [casadi.SX.sym(f"p{i}", dimension) for i in range(points)]
    numbers = [casadi.SX.sym(f"n{i}", size) for i, size in enumerate(sizes)]
    d = KIND[kind].distances(*numbers).of(*ends)
    first = casadi.gradient(d, casadi.vertcat(*ends))
    return casadi.Function("distance", [*ends, *numbers], [d, first]), casadi.Function(
        "hessian", [*ends, *numbers], [casadi.jacobian(first, casadi.vertcat(*ends))]
    )


def distance(obstacle, *points):
    """Signed distance of a point, or of a segment, and its gradient with respect to the points."""
    d, gradient = evaluated(0, obstacle, *points)
    return float(d), gradient.full()[:, 0]


def hessian(obstacle, *points):
    """The Hessian of that distance with respect to the points."""
    return evaluated(1, obstacle, *points).full()


def evaluated(which, obstacle, *points):
    kind = next(kind for kind in KINDS if isinstance(obstacle, kind.solid))
    numbers = [np.asarray(each, dtype=float).ravel() for each in kind.numbers(obstacle)]
    if kind.name == "polygon":  # corners that are repeated, as in a slot
        numbers = [np.pad(numbers[0].reshape(-1, 2), ((0, 8 - len(numbers[0]) // 2), (0, 0)), mode="edge").ravel()]
    functions = compiled(kind.name, len(points[0]), len(points), tuple(each.size for each in numbers))
    return functions[which](*points, *numbers)


def random_bodies(obstacle, count, rng, reach=1.5):
    """Points and segments, some of them parallel to an axis of the obstacle, or of length zero."""
    axis = {
        jtik.Capsule: lambda: obstacle.end - obstacle.start,
        jtik.Cylinder: lambda: obstacle.end - obstacle.start,
        jtik.Box: lambda: obstacle.pose[:-1, rng.integers(obstacle.dimension)],
        jtik.HalfSpace: lambda: np.linalg.svd(obstacle.normal[None])[2][-1],
        jtik.Polygon: lambda: obstacle.vertices[1] - obstacle.vertices[0],
    }.get(type(obstacle), lambda: rng.normal(size=obstacle.dimension))
    for i in range(count):
        start, end = rng.uniform(-reach, reach, (2, obstacle.dimension))
        if i % 4 == 0:
            yield (start,)
        elif i % 8 == 1:
            yield start, start.copy()
        elif i % 8 == 3:
            yield start, start + rng.uniform(-2, 2) * axis()
        else:
            yield start, end

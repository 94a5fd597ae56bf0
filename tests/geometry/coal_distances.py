"""Distances of segments with a radius to solids in space, by coal."""

from __future__ import annotations

import numpy as np
import pytest

import jtik

coal = pytest.importorskip("coal")


def frame_along(start, end):
    z = (end - start) / np.linalg.norm(end - start)
    x = np.linalg.svd(z[None])[2][1]
    return coal.Transform3s(np.stack([x, np.cross(z, x), z], axis=1), (start + end) / 2)


def in_coal(solid):
    """The geometry and the pose of a solid."""
    if isinstance(solid, jtik.Sphere):
        return coal.Sphere(solid.radius), coal.Transform3s(np.eye(3), solid.center)
    if isinstance(solid, jtik.Box):
        return coal.Box(*(2 * solid.half)), coal.Transform3s(solid.pose[:3, :3], solid.center)
    if isinstance(solid, jtik.HalfSpace):
        return coal.Halfspace(solid.normal, float(solid.normal @ solid.point)), coal.Transform3s.Identity()
    kind = coal.Capsule if isinstance(solid, jtik.Capsule) else coal.Cylinder
    return kind(solid.radius, np.linalg.norm(solid.end - solid.start)), frame_along(solid.start, solid.end)


def by_coal(placed, body, radius):
    """Signed distance of a point or a segment with a radius to what `in_coal` returned."""
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = 1e-12
    request.gjk_max_iterations = 1000
    if len(body) == 1 or np.array_equal(*body):
        capsule, at = coal.Sphere(radius), coal.Transform3s(np.eye(3), body[0])
    else:
        capsule, at = coal.Capsule(radius, np.linalg.norm(body[1] - body[0])), frame_along(*body)
    return coal.distance(*placed, capsule, at, request, coal.DistanceResult())

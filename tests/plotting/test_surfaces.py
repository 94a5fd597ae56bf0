"""Surfaces of solids: closed, with the right volume and place, and outward."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

import jtik
from jtik.geometry import HalfSpace, Polygon
from jtik.plotting.surfaces import SIDES, Extent, Surface, extent_of, obstacle_surface, surface

ROUND = 0.06
"""Share of a volume that is missing where circles are polygons of `SIDES` corners, in two directions of a ball."""

EVERYTHING = Extent(np.array([0.3, 0.2, 0.1]), 1.5)

SOLIDS = {
    "sphere": (jtik.Sphere((0.1, 0.2, 0.3), 0.4), 4 / 3 * np.pi * 0.4**3),
    "capsule": (jtik.Capsule((0, 0, 0), (1, 2, -1), 0.3), np.pi * 0.3**2 * np.sqrt(6) + 4 / 3 * np.pi * 0.3**3),
    "cylinder": (jtik.Cylinder((0, 0, 0), (1, 2, -1), 0.3), np.pi * 0.3**2 * np.sqrt(6)),
    "box": (jtik.Box.at((1, 2, 3), (0.1, 0.2, 0.3), (0.5, 0.1, -0.4, 0.7)), 8 * 0.1 * 0.2 * 0.3),
}
FLAT = {
    "circle": (jtik.Circle((0.1, 0.2), 0.4), np.pi * 0.4**2),
    "capsule": (jtik.Capsule((0.0, 0.0), (1.0, 2.0), 0.3), np.pi * 0.3**2 + 0.6 * np.sqrt(5)),
    "box": (jtik.Box.at((1.0, 2.0), (0.1, 0.2), 0.4), 4 * 0.1 * 0.2),
    "polygon": (Polygon([(0, 0), (2, 0), (1, 1)]), 1.0),
}


def volume(drawn: Surface) -> float:
    """By the divergence theorem; negative where faces are clockwise."""
    a, b, c = drawn.vertices[drawn.faces].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def is_closed(drawn: Surface) -> bool:
    """Whether each edge has two faces, of opposite directions; corners at the same place are one."""
    _, same = np.unique(drawn.vertices.round(9), axis=0, return_inverse=True)
    edges = Counter(
        (int(face[i]), int(face[j])) for face in same.reshape(-1)[drawn.faces] for i, j in ((0, 1), (1, 2), (2, 0))
    )
    return all(count == 1 and edges[end, start] == 1 for (start, end), count in edges.items())


@pytest.mark.parametrize("name", SOLIDS)
def test_surfaces_are_closed_and_have_the_volume_of_the_solid(name: str) -> None:
    solid, expected = SOLIDS[name]
    drawn = surface(solid)
    assert is_closed(drawn)
    assert volume(drawn) == pytest.approx(expected, rel=1e-9 if name == "box" else ROUND)


@pytest.mark.parametrize("name", FLAT)
def test_obstacles_in_the_plane_are_discs_of_their_area(name: str) -> None:
    solid, area = FLAT[name]
    drawn = obstacle_surface(solid, EVERYTHING)
    height = float(np.ptp(drawn.vertices[:, 2]))
    assert is_closed(drawn)
    assert 0 < height < 0.1 * EVERYTHING.radius
    assert volume(drawn) / height == pytest.approx(area, rel=ROUND)


def test_corners_of_round_solids_are_on_them() -> None:
    start, end = np.array([0.0, 0, 0]), np.array([1.0, 2, -1])
    vertices = surface(SOLIDS["capsule"][0]).vertices
    share = np.clip((vertices - start) @ (end - start) / ((end - start) @ (end - start)), 0, 1)
    distance = np.linalg.norm(vertices - start - share[:, None] * (end - start), axis=1)
    np.testing.assert_allclose(distance, 0.3, atol=1e-12)
    ball = surface(SOLIDS["sphere"][0]).vertices
    np.testing.assert_allclose(np.linalg.norm(ball - [0.1, 0.2, 0.3], axis=1), 0.4, atol=1e-12)
    assert len(ball) > SIDES


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (1.0, -2.0, 0.5)])
def test_a_half_space_is_a_patch_below_its_plane_and_beside_what_is_drawn(normal: tuple[float, ...]) -> None:
    plane = HalfSpace((0.0, 0.3, -0.4), normal)
    drawn = obstacle_surface(plane, EVERYTHING)
    height = (drawn.vertices - plane.point) @ plane.normal
    assert height.max() == pytest.approx(0.0, abs=1e-12)
    assert height.min() < 0
    middle = EVERYTHING.middle - ((EVERYTHING.middle - plane.point) @ plane.normal) * plane.normal
    across = drawn.vertices.mean(axis=0) - middle
    assert np.linalg.norm(across - (across @ plane.normal) * plane.normal) < 1e-12
    assert np.linalg.norm(drawn.vertices - middle, axis=1).max() > EVERYTHING.radius


def test_a_half_space_in_the_plane_is_a_strip_below_its_line() -> None:
    line = HalfSpace((0.0, -0.4), (0.6, 0.8))
    drawn = obstacle_surface(line, EVERYTHING)
    height = (drawn.vertices[:, :2] - line.point) @ line.normal
    assert height.max() == pytest.approx(0.0, abs=1e-12)
    assert is_closed(drawn)
    assert volume(drawn) > 0


def test_a_point_is_a_small_ball() -> None:
    extent = extent_of(surface(jtik.Point((1.0, 2.0, 3.0))).vertices)
    np.testing.assert_allclose(extent.middle, [1, 2, 3], atol=1e-12)
    assert 0 < extent.radius < 0.02


def test_what_is_not_in_space_is_refused() -> None:
    with pytest.raises(jtik.ArgumentError, match="in space"):
        surface(jtik.Circle((0, 0), 1.0))
    with pytest.raises(jtik.ArgumentError, match="in space"):
        surface("ball")

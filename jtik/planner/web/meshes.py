"""The meshes of a robot as the page draws them: corners with normals and triangles, as binary data."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from jtik.errors import RobotFileError
from jtik.robot import Robot
from jtik.types import Array

CREASE = math.cos(math.radians(40.0))
"""Cosine of the angle between a triangle and the surface around its corner from which on there is an edge."""


class Meshes(NamedTuple):
    """The meshes of a robot.

    Attributes:
        data: 32-bit words, little-endian: the number of parts; for each part the index of its frame, the number of its
            corners c and of its triangles t, all as unsigned integers, then position [m] and unit normal of each corner
            in the coordinates of the frame as floats (c, 6), and the corners of each triangle as integers (t, 3).
        notes: what could not be read, in words.
    """

    data: bytes
    notes: tuple[str, ...]


def encoded(robot: Robot) -> Meshes:
    """The meshes of all frames. A frame with a mesh that cannot be read has no part, and a note."""
    parts, notes = list[bytes](), list[str]()
    for number, frame in enumerate(robot.frame_names):
        try:
            own = [shaded(*mesh.triangles()) for mesh in robot.meshes.get(frame, ())]
        except RobotFileError as error:
            notes.append(f"{frame} is shown by capsules: {error}")
            continue
        for corners, triangles in own:
            head = np.array([number, len(corners), len(triangles)], "<u4")
            parts.append(head.tobytes() + corners.astype("<f4").tobytes() + triangles.astype("<u4").tobytes())
    return Meshes(b"".join([np.array([len(parts)], "<u4").tobytes(), *parts]), tuple(notes))


def shaded(vertices: Array, faces: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
    """Corners with normals (c, 6), smooth but for edges, and the corners of each triangle (t, 3).

    Corners at one place are one corner, except at edges, where each triangle has its own with its own normal. Triangles
    without an area are left out.

    Args:
        vertices: places of the corners (n, 3) [m].
        faces: corners of each triangle (m, 3), anticlockwise seen from outside.
    """
    places, same = np.unique(vertices, axis=0, return_inverse=True)
    triangles = same.reshape(-1)[faces]
    a, b, c = (places[triangles[:, k]] for k in range(3))
    areas = np.cross(b - a, c - a)
    sizes = np.linalg.norm(areas, axis=1)
    triangles, flat = triangles[sizes > 0], areas[sizes > 0] / sizes[sizes > 0, None]
    around = np.zeros_like(places)
    for k in range(3):  # weighted by the angle of the triangle at its corner
        here, after, before = (places[triangles[:, (k + i) % 3]] for i in range(3))
        np.add.at(around, triangles[:, k], _angles(after - here, before - here)[:, None] * flat)
    around /= np.maximum(np.linalg.norm(around, axis=1, keepdims=True), np.finfo(float).tiny)
    edges = np.einsum("tkd,td->tk", around[triangles], flat) < CREASE
    own = np.concatenate([places[triangles[edges]], np.repeat(flat, edges.sum(axis=1), axis=0)], axis=1)
    corners = np.concatenate([np.concatenate([places, around], axis=1), own])
    found = triangles.copy()
    found[edges] = len(places) + np.arange(len(own))
    return corners, found


def _angles(a: Array, b: Array) -> Array:
    """Angles between the rows of two arrays [rad]."""
    found: Array = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.einsum("kd,kd->k", a, b))
    return found

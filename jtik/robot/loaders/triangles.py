"""Triangles of mesh files, for pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from jtik.errors import RobotFileError
from jtik.robot.loaders.collada import read_collada
from jtik.robot.loaders.meshes import READABLE, mesh_model, vertices_of
from jtik.types import Array


def read_triangles(file: Path, scale: Array) -> tuple[Array, NDArray[np.int64]]:
    """The triangles of a mesh file.

    Args:
        file: a .stl, .obj, .msh or .dae file.
        scale: factor of each coordinate, (3,).

    Returns:
        Corners (n, 3) [m] and the corners of each triangle (m, 3).

    Raises:
        RobotFileError: when the file is missing or cannot be read.
    """
    suffix = file.suffix.lower()
    if suffix == ".dae":
        vertices, faces = read_collada(file)
        vertices = vertices * scale
        mirrored = np.prod(scale) < 0
        return vertices, np.ascontiguousarray(faces[:, ::-1]) if mirrored else faces
    model = mesh_model(file, scale)
    if model is None:
        problem = f"no mesh that can be read; accepted: {', '.join(READABLE)} and .dae files"
        raise RobotFileError(str(file), "", problem)
    return vertices_of(model, 0), np.array(model.mesh_face, dtype=np.int64)

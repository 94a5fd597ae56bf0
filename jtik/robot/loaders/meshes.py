"""Meshes as capsules or balls: the mesh file is found next to the file of the robot and read by MuJoCo."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from jtik.geometry import Capsule, Solid, Sphere
from jtik.robot.loaders.transforms import pose_of
from jtik.types import Array

READABLE = (".stl", ".obj", ".msh")
"""Suffixes of the mesh files that MuJoCo reads."""

_ROUNDING = 1e-6
"""Relative margin that is added to a solid: MuJoCo keeps vertices in single precision."""


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A mesh of a description, read when its vertices are needed.

    Attributes:
        paths: candidate paths of its file, in the order in which they are tried.
        vertices: its vertices (n, 3) [m] when the description contains them.
        scale: factor of each coordinate, (3,).
    """

    paths: tuple[Path, ...]
    vertices: Array
    scale: Array

    @classmethod
    def of(cls, mesh: Any, spec: Any, folder: Path | None) -> MeshFile:
        """The mesh of a ``mujoco.MjSpec`` whose file is in ``folder``."""
        paths = () if folder is None or not mesh.file else tuple(_candidates(mesh.file, folder, spec.meshdir))
        return cls(paths, np.array(list(mesh.uservert), dtype=float).reshape(-1, 3), np.array(mesh.scale))

    @cached_property
    def points(self) -> Array:
        """Its vertices (n, 3) [m] in the geom's frame; none when its file is missing or MuJoCo cannot read it."""
        if self.vertices.size:
            return self.vertices * self.scale
        return np.zeros((0, 3)) if self.file is None else _read(self.file, self.scale)

    @cached_property
    def file(self) -> Path | None:
        """The first of its paths that is a file; None without one."""
        return next(filter(_is_file, self.paths), None)


def first_file(file: str, folder: Path, meshdir: str) -> Path | None:
    """The file that a description in ``folder`` names; None where it is not found."""
    return next(filter(_is_file, _candidates(file, folder, meshdir)), None) if file else None


def _candidates(file: str, folder: Path, meshdir: str) -> Iterator[Path]:
    """Candidate paths of a file that a description in ``folder`` names.

    A ``package://`` address is searched in the folder and in every folder above it: packages are next to their robots.
    """
    address = file.partition("://")
    if not address[1]:
        yield folder / meshdir / file
        yield folder / file
        return
    inside = Path(address[2].lstrip("/"))
    if not inside.parts:  # an address of no file
        return
    for above in (folder, *folder.parents):
        yield above / inside
        if above.name == inside.parts[0]:
            yield above.joinpath(*inside.parts[1:])


def _is_file(path: Path) -> bool:
    """Whether there is such a file; a name that the system refuses, for instance as too long, names none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def _read(path: Path, scale: Array) -> Array:
    model = mesh_model(path, scale)
    return np.zeros((0, 3)) if model is None else vertices_of(model, 0)


def mesh_model(path: Path, scale: Array) -> Any:
    """A ``mujoco.MjModel`` of one mesh; None for a file that MuJoCo cannot read."""
    if path.suffix.lower() not in READABLE:
        return None
    spec = mujoco.MjSpec()
    mesh = spec.add_mesh(name="mesh", file=str(path), scale=scale)
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh", contype=0, conaffinity=0)
    try:
        return spec.compile()
    except ValueError:  # a file that MuJoCo refuses counts as missing
        return None


def vertices_of(model: Any, geom: int) -> Array:
    """Vertices (n, 3) [m] of a mesh geom of a ``mujoco.MjModel``, in the frame of its body."""
    mesh = model.geom_dataid[geom]
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    pose = pose_of(model.geom_pos[geom], model.geom_quat[geom])
    vertices = np.array(model.mesh_vert[first : first + count], dtype=float)
    return vertices @ pose[:3, :3].T + pose[:3, 3]


def solid_around(points: Array) -> Solid:
    """The smallest solid around points: of a ball, and of capsules along the principal axes and the coordinate axes.

    Args:
        points: (n, 3) [m], at least one.
    """
    center = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = float(np.linalg.norm(points - center, axis=1).max())
    best: Solid = Sphere(center, radius * (1 + _ROUNDING))
    smallest = radius**3 * 4 / 3
    _, principal = np.linalg.eigh(np.cov(points.T, bias=True))
    for axes in (principal, np.eye(3)):
        for permuted in (np.roll(axes, k, axis=1) for k in range(3)):
            start, end, radius = _capsule(points, permuted)
            volume = radius**2 * (float(np.linalg.norm(end - start)) + radius * 4 / 3)
            if 0 < volume < smallest:
                best, smallest = Capsule(start, end, radius * (1 + _ROUNDING)), volume
    return best


def _capsule(points: Array, axes: Array) -> tuple[Array, Array, float]:
    """Ends and radius of the shortest capsule around ``points`` along the first of ``axes``, centred in the others."""
    local = points @ axes
    center = (local.min(axis=0) + local.max(axis=0)) / 2
    distance = np.linalg.norm(local[:, 1:] - center[1:], axis=1)
    radius = float(distance.max())
    cap = np.sqrt(np.maximum(radius**2 - distance**2, 0.0))
    low, high = float((local[:, 0] + cap).min()), float((local[:, 0] - cap).max())
    if low > high:
        low = high = (low + high) / 2
    return axes @ [low, *center[1:]], axes @ [high, *center[1:]], radius

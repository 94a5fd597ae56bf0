"""Geoms of a MuJoCo model as solids on its bodies."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import mujoco
import numpy as np

from jtik.geometry import Box, Capsule, Cylinder, Solid, Sphere
from jtik.robot.loaders.meshes import MeshFile, solid_around, vertices_of
from jtik.robot.loaders.transforms import pose_of
from jtik.types import Array

Reader: TypeAlias = Callable[[Array, Array], Solid]
"""Makes a solid from the pose (4, 4) of a geom in its body and its size (3,) [m]."""


def solids(model: Any, meshes: Mapping[int, MeshFile]) -> dict[int, list[Solid]]:
    """The solids on each body, by its number, in the body's frame.

    Geoms that collide are used; where none does, all are. An ellipsoid becomes the capsule around it, a mesh the
    capsule or ball around it. Planes, height fields and meshes that cannot be read have no solid.

    Args:
        model: a ``mujoco.MjModel``.
        meshes: meshes that were removed from the model, by the number of the geom that replaces them.
    """
    collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    chosen = np.flatnonzero(collides) if collides.any() else range(model.ngeom)
    found: dict[int, list[Solid]] = {}
    for geom in map(int, chosen):
        solid = _solid(model, geom, meshes)
        if solid is not None:
            found.setdefault(int(model.geom_bodyid[geom]), []).append(solid)
    return found


def _solid(model: Any, geom: int, meshes: Mapping[int, MeshFile]) -> Solid | None:
    pose = pose_of(model.geom_pos[geom], model.geom_quat[geom])
    if geom in meshes:
        points = meshes[geom].points @ pose[:3, :3].T + pose[:3, 3]
    elif model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        points = vertices_of(model, geom)
    else:
        read = _READERS.get(mujoco.mjtGeom(model.geom_type[geom]))
        return None if read is None else read(pose, np.array(model.geom_size[geom], dtype=float))
    return solid_around(points) if len(points) else None


def _along(pose: Array, axis: int, half: float) -> tuple[Array, Array]:
    """Ends (3,) [m] of the segment of length 2 ``half`` on an axis of ``pose``, about its origin."""
    vector = half * pose[:3, axis]
    return pose[:3, 3] - vector, pose[:3, 3] + vector


def _sphere(pose: Array, size: Array) -> Solid:
    return Sphere(pose[:3, 3], float(size[0]))


def _capsule(pose: Array, size: Array) -> Solid:
    return Capsule(*_along(pose, 2, float(size[1])), float(size[0]))


def _cylinder(pose: Array, size: Array) -> Solid:
    return Cylinder(*_along(pose, 2, float(size[1])), float(size[0]))


def _box(pose: Array, size: Array) -> Solid:
    return Box(pose, size)


def _ellipsoid(pose: Array, size: Array) -> Solid:
    longest = int(size.argmax())
    radius = float(np.delete(size, longest).max())
    return Capsule(*_along(pose, longest, float(size[longest]) - radius), radius)


_READERS: dict[Any, Reader] = {
    mujoco.mjtGeom.mjGEOM_SPHERE: _sphere,
    mujoco.mjtGeom.mjGEOM_CAPSULE: _capsule,
    mujoco.mjtGeom.mjGEOM_CYLINDER: _cylinder,
    mujoco.mjtGeom.mjGEOM_BOX: _box,
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: _ellipsoid,
}

"""Meshes for pictures: those of a URDF, and those of a MuJoCo model."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from jtik.robot.loaders.meshes import MeshFile, first_file
from jtik.robot.loaders.source import Source
from jtik.robot.loaders.transforms import pose_of, rotation_about
from jtik.robot.mesh import Mesh
from jtik.types import Array


def urdf_meshes(source: Source) -> dict[str, list[Mesh]]:
    """The meshes on each link whose files exist: its visual ones, or, where it has none, those that collide.

    Args:
        source: the URDF.
    """
    if source.path is None:
        return {}
    folder, compiler = source.path.resolve().parent, source.root.find("mujoco/compiler")
    meshdir = "" if compiler is None else compiler.get("meshdir", "")
    found: dict[str, list[Mesh]] = {}
    for link in source.root.findall("link"):
        for tag in ("visual", "collision"):
            own = list(_of_link(link, tag, lambda file: first_file(file, folder, meshdir)))
            if own:
                found[link.get("name", "")] = own
                break
    return found


def _of_link(link: Element, tag: str, find: Callable[[str], Any]) -> Iterator[Mesh]:
    for shape in link.findall(tag):
        mesh = shape.find("geometry/mesh")
        file = None if mesh is None else find(mesh.get("filename", ""))
        if mesh is None or file is None:
            continue
        scale = _numbers(mesh.get("scale", "1 1 1"))
        scale = scale * np.ones(3) if len(scale) == 1 else scale[:3]
        origin = shape.find("origin")
        pose = np.eye(4) if origin is None else _pose(origin)
        if len(scale) == 3 and np.isfinite(scale).all() and pose is not None:
            yield Mesh(file, pose, scale)


def _pose(origin: Element) -> Array | None:
    """The pose of an <origin>; None where it has none."""
    xyz, rpy = (_numbers(origin.get(name, "0 0 0")) for name in ("xyz", "rpy"))
    if len(xyz) != 3 or len(rpy) != 3 or not np.isfinite([*xyz, *rpy]).all():
        return None
    pose = np.eye(4)
    for axis, angle in zip(np.eye(3), rpy.tolist(), strict=True):
        pose = rotation_about(axis, angle) @ pose
    pose[:3, 3] = xyz
    return pose


def _numbers(text: str) -> Array:
    try:
        return np.array([float(word) for word in text.split()])
    except ValueError:
        return np.zeros(0)


def model_meshes(model: Any, meshes: Mapping[int, MeshFile]) -> dict[int, list[Mesh]]:
    """The meshes on each body whose files exist, by its number: those that do not collide, or, without any, all.

    Args:
        model: a ``mujoco.MjModel``.
        meshes: meshes that were removed from the model, by the number of the geom that replaces them.
    """
    visible: dict[int, list[Mesh]] = {}
    every: dict[int, list[Mesh]] = {}
    for geom, mesh in meshes.items():
        if mesh.file is None:
            continue
        body = int(model.geom_bodyid[geom])
        kept = Mesh(mesh.file, pose_of(model.geom_pos[geom], model.geom_quat[geom]), mesh.scale)
        every.setdefault(body, []).append(kept)
        if not (model.geom_contype[geom] or model.geom_conaffinity[geom]):
            visible.setdefault(body, []).append(kept)
    return every | visible

"""Triangles of a COLLADA file (.dae): its geometry in the scene, without materials, skins and animations."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from xml.etree.ElementTree import Element, ParseError, XMLParser, fromstring

import numpy as np
from numpy.typing import NDArray

from jtik.errors import RobotFileError
from jtik.robot.loaders.reading import read_description
from jtik.robot.loaders.transforms import rotation_about
from jtik.types import Array

_DEEPEST = 100
"""How deep nodes may be nested, instances included: a file whose nodes contain themselves ends here."""

_Triangles = tuple[Array, NDArray[np.int64]]


def read_collada(file: Path) -> _Triangles:
    """The triangles of a file, in metres.

    As in other readers of robot descriptions, its upward axis is not used: its axes are those of the frame.

    Raises:
        RobotFileError: when it cannot be read or has no triangle.
    """
    content = read_description(file, "COLLADA")
    try:
        return _Collada(_without_names(fromstring(content, XMLParser()))).triangles()
    except (ParseError, ValueError, IndexError, KeyError) as error:
        raise RobotFileError(str(file), "", f"no COLLADA mesh: {error}") from error


def _without_names(root: Element) -> Element:
    """The document without its XML name space."""
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
    return root


class _Collada:
    def __init__(self, root: Element) -> None:
        self._root = root
        self._by_id = {element.get("id", ""): element for element in root.iter() if element.get("id")}

    def triangles(self) -> _Triangles:
        unit = self._root.find("asset/unit")
        meter = 1.0 if unit is None else float(unit.get("meter", "1"))
        parts: list[_Triangles] = []
        for scene in self._root.findall("library_visual_scenes/visual_scene")[:1]:
            for node in scene.findall("node"):
                parts += self._of_node(node, np.eye(4), 0)
        if not parts:
            for geometry in self._root.findall("library_geometries/geometry"):
                parts += self._of_geometry(geometry, np.eye(4))
        if not any(len(faces) for _, faces in parts):
            raise ValueError("it has no triangle")
        offsets = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
        vertices = np.concatenate([vertices for vertices, _ in parts])
        faces = np.concatenate([faces + offset for (_, faces), offset in zip(parts, offsets[:-1], strict=True)])
        return meter * vertices, faces

    def _of_node(self, node: Element, above: Array, depth: int) -> Iterator[_Triangles]:
        if depth > _DEEPEST:
            raise ValueError("its nodes are nested too deeply")
        pose = above
        for element in node:
            pose = pose @ _transform(element)
        for instance in node.findall("instance_geometry"):
            yield from self._of_geometry(self._referenced(instance), pose)
        for instance in node.findall("instance_controller"):
            skin = self._referenced(instance).find("skin")
            if skin is not None:
                yield from self._of_geometry(self._by_id[skin.get("source", "").lstrip("#")], pose)
        for child in [*node.findall("node"), *map(self._referenced, node.findall("instance_node"))]:
            yield from self._of_node(child, pose, depth + 1)

    def _referenced(self, instance: Element) -> Element:
        return self._by_id[instance.get("url", "").lstrip("#")]

    def _of_geometry(self, geometry: Element, pose: Array) -> Iterator[_Triangles]:
        mesh = geometry.find("mesh")
        for group in () if mesh is None else mesh:
            if group.tag not in ("triangles", "polylist", "polygons", "trifans", "tristrips"):
                continue
            inputs = {each.get("semantic"): each for each in group.findall("input")}
            stride = 1 + max(int(each.get("offset", "0")) for each in group.findall("input"))
            source = self._by_id[inputs["VERTEX"].get("source", "").lstrip("#")]
            positions = next(each for each in source.findall("input") if each.get("semantic") == "POSITION")
            vertices = self._positions(self._by_id[positions.get("source", "").lstrip("#")])
            offset = int(inputs["VERTEX"].get("offset", "0"))
            runs = [np.array((p.text or "").split(), dtype=np.int64)[offset::stride] for p in group.findall("p")]
            faces = _faces(group, runs)
            if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
                raise ValueError("a corner that it does not have")
            turned = vertices @ pose[:3, :3].T + pose[:3, 3]
            yield turned, faces if np.linalg.det(pose[:3, :3]) >= 0 else faces[:, ::-1]

    def _positions(self, source: Element) -> Array:
        numbers = source.find("float_array")
        accessor = source.find("technique_common/accessor")
        if numbers is None or accessor is None:
            raise ValueError("positions without numbers")
        table = np.array((numbers.text or "").split(), dtype=np.float64)
        stride, first = int(accessor.get("stride", "3")), int(accessor.get("offset", "0"))
        count = int(accessor.get("count", str((len(table) - first) // stride)))
        return np.asarray(table[first : first + count * stride].reshape(count, stride)[:, :3])


def _faces(group: Element, runs: list[NDArray[np.int64]]) -> NDArray[np.int64]:
    """The corners (m, 3) of the triangles of a group; a polygon is a fan of triangles."""
    if group.tag == "triangles":
        return np.concatenate([np.zeros(0, dtype=np.int64), *runs]).reshape(-1, 3)
    if group.tag == "polylist":
        sizes = np.array(group.findtext("vcount", "").split(), dtype=np.int64)
        runs = np.split(runs[0], np.cumsum(sizes)[:-1]) if len(sizes) else []
    fans = []
    for run in runs:
        if group.tag == "tristrips":
            fans += [(run[k], run[k + 1 + k % 2], run[k + 2 - k % 2]) for k in range(len(run) - 2)]
        else:
            fans += [(run[0], a, b) for a, b in pairwise(run[1:])]
    return np.array(fans, dtype=np.int64).reshape(-1, 3)


def _transform(element: Element) -> Array:
    """The transform (4, 4) of an element of a node; the identity for what is none."""
    pose = np.eye(4)
    if element.tag not in ("matrix", "translate", "rotate", "scale"):
        return pose
    numbers = np.array((element.text or "").split(), dtype=np.float64)
    if element.tag == "matrix":
        return np.asarray(numbers.reshape(4, 4))
    if element.tag == "translate":
        pose[:3, 3] = numbers[:3]
    elif element.tag == "rotate":
        axis = numbers[:3] / np.linalg.norm(numbers[:3])
        pose = rotation_about(axis, np.deg2rad(numbers[3]))
    else:
        pose[:3, :3] = np.diag(numbers[:3])
    return pose

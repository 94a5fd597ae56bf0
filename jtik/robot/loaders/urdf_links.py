"""The part of a URDF that MuJoCo reads: the tree, inertias and shapes, without what it refuses.

Kinematics needs neither inertias nor colours, so a URDF with an invalid one is completed or read without it. Inertias
are read here, since MuJoCo refuses many that are written.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

from jtik.robot.loaders.source import Source
from jtik.robot.loaders.transforms import rotation_of_angles
from jtik.robot.masses_and_shapes import is_inertia
from jtik.types import Array

_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
_SIZES = {"box": (("size", 3),), "sphere": (("radius", 1),), "mesh": ()} | dict.fromkeys(
    ("cylinder", "capsule"), (("radius", 1), ("length", 1))
)
"""The attributes of each geometry, and how many numbers each has."""


@dataclass(frozen=True)
class MujocoText:
    """A URDF for MuJoCo.

    Attributes:
        text: the URDF.
        notes: one sentence for each element that is left out.
        changes: one sentence for each element that is completed.
        inertias: the inertia of each link that has one about its centre of mass, in the axes of the link, divided by
            its mass, (3, 3) [m^2].
    """

    text: str
    notes: tuple[str, ...]
    changes: tuple[str, ...]
    inertias: Mapping[str, Array]


def mujoco_text(source: Source) -> MujocoText:
    """The links, the joints and the MuJoCo options of a URDF, without limits, couplings, names of shapes and colours.

    The joint types of other dialects that `jtik.robot.loaders.urdf` accepts become those of MuJoCo.
    """
    root = Element("robot", {"name": source.root.get("name", "robot")})
    links = _Links()
    for element in source.root:
        if element.tag == "mujoco":
            root.append(element)
        elif element.tag == "link":
            links.append_to(root, element)
        elif element.tag == "joint":
            kind = element.get("type", "")
            joint = SubElement(root, "joint", {**element.attrib, "type": "floating" if kind == "spherical" else kind})
            joint.extend(found for tag in ("parent", "child", "origin", "axis") for found in element.findall(tag)[:1])
    return MujocoText(tostring(root, encoding="unicode"), tuple(links.notes), tuple(links.changes), links.inertias)


class _Links:
    def __init__(self) -> None:
        self.notes: list[str] = []
        self.changes: list[str] = []
        self.inertias: dict[str, Array] = {}

    def append_to(self, root: Element, element: Element) -> None:
        """Append the link to ``root``, with the inertias and shapes that can be used."""
        link = SubElement(root, "link", {"name": element.get("name", "")})
        for inertial in element.findall("inertial")[:1]:
            link.extend(self._inertial(element.get("name", ""), inertial))
        for tag in ("visual", "collision"):
            for shape in element.findall(tag):
                link.extend(self._shape(f"link {link.get('name')!r}", shape))

    def _inertial(self, name: str, element: Element) -> Iterator[Element]:
        who = f"link {name!r}"
        mass, inertia, origin = (element.find(tag) for tag in ("mass", "inertia", "origin"))
        if mass is None or not _are_numbers(mass, "value", 1):
            self.changes.append(f"{who} has an <inertial> without a mass: it counts as massless")
            return
        if float(mass.get("value", "")) < 0:
            self.changes.append(f"{who} has a negative mass: it counts as massless")
            return
        inertial = Element("inertial")
        if origin is not None and not _is_origin(origin):
            self.notes.append(f"{who}: the <origin> of its <inertial> is not three numbers; it is not used")
        elif origin is not None:
            inertial.append(origin)
        inertial.append(mass)
        if inertia is None or not all(_are_numbers(inertia, moment, 1) for moment in _MOMENTS):
            self.changes.append(f"{who} has a mass without an inertia: it counts as a point mass")
            inertia = Element("inertia", dict.fromkeys(_MOMENTS, "0") | dict.fromkeys(_MOMENTS[:3], "1"))
        elif float(mass.get("value", "")) > 0:
            tensor = _tensor(inertia, inertial.find("origin"))
            if is_inertia(tensor):
                self.inertias[name] = tensor / float(mass.get("value", ""))
            else:
                self.changes.append(f"{who} has an inertia with a negative principal moment: it counts as a point mass")
        inertial.append(inertia)
        yield inertial

    def _shape(self, who: str, element: Element) -> Iterator[Element]:
        geometry, origin = element.find("geometry"), element.find("origin")
        solid = next(iter(() if geometry is None else geometry), None)
        where = f"{who}: a <{element.tag}>"
        if solid is None:
            self.notes.append(f"{where} without a geometry is not used")
        elif solid.tag not in _SIZES or (solid.tag == "mesh" and not solid.get("filename")):
            self.notes.append(f"{where} with the geometry <{solid.tag}> is not used")
        elif not all(_are_numbers(solid, *size) for size in _SIZES[solid.tag]):
            self.notes.append(f"{where} is not used: the size of its <{solid.tag}> is not a number")
        elif origin is not None and not _is_origin(origin):
            self.notes.append(f"{where} is not used: its <origin> is not three numbers")
        else:
            shape = Element(element.tag)
            shape.extend([] if origin is None else [origin])
            SubElement(shape, "geometry").append(self._scaled(where, solid))
            yield shape

    def _scaled(self, where: str, solid: Element) -> Element:
        """The geometry with a scale of three numbers where it is a mesh with another scale."""
        text = solid.get("scale")
        if solid.tag != "mesh" or text is None or _are_numbers(solid, "scale", 3):
            return solid
        words = text.split()
        if len(words) == 1 and _are_numbers(solid, "scale", 1):
            used = words * 3
        elif len(words) > 3 and _are_numbers(solid, "scale", len(words)):
            used = words[:3]
        else:
            used = ["1", "1", "1"]
        self.changes.append(
            f"{where} has a mesh of scale {text!r}, where three numbers are due; {' '.join(used)} is used"
        )
        return Element("mesh", {**solid.attrib, "scale": " ".join(used)})


def _tensor(inertia: Element, origin: Element | None) -> Array:
    """The inertia in the axes of the link, (3, 3) [kg m^2]."""
    xx, yy, zz, xy, xz, yz = (float(inertia.get(moment, "")) for moment in _MOMENTS)
    angles = "0 0 0" if origin is None else origin.get("rpy", "0 0 0")
    R = rotation_of_angles([float(word) for word in angles.split()])
    tensor: Array = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T
    return tensor


def _is_origin(origin: Element) -> bool:
    return all(origin.get(attribute) is None or _are_numbers(origin, attribute, 3) for attribute in ("xyz", "rpy"))


def _are_numbers(element: Element, attribute: str, count: int) -> bool:
    """Whether an attribute is that many finite numbers."""
    try:
        numbers = [float(word) for word in element.get(attribute, "").split()]
    except ValueError:
        return False
    return len(numbers) == count and all(map(math.isfinite, numbers))

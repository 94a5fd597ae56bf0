"""A spatial arm whose last link has a plate far from its skeleton, as a mesh file: it is seen with meshes only."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import jtik

CORNERS = np.array([[x, y, z] for x in (-0.15, 0.15) for y in (-0.02, 0.02) for z in (-0.15, 0.15)])
FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
"""Corners of each side, anticlockwise seen from outside."""

TRIANGLES = np.array([each for a, b, c, d in FACES for each in ((a, b, c), (a, c, d))])

MIDDLE = (0.0, 0.5, 0.1)
"""Middle of the plate in the coordinates of the last link [m]."""

LINK = """<link name="link{k}">{more}
 <collision><origin xyz="0 0 0.12"/><geometry><sphere radius="0.05"/></geometry></collision></link>
 <joint name="joint{k}" type="revolute"><parent link="{before}"/><child link="link{k}"/><axis xyz="{axis}"/>
 <origin xyz="0 0 0.25"/><limit lower="-2" upper="2" effort="1" velocity="2"/></joint>"""


def plated_arm(folder: Path, *, file: str = "plate.obj") -> jtik.Robot:
    """An arm of six joints, with its mesh in a file in a folder."""
    rows = [f"v {x} {y} {z}" for x, y, z in CORNERS] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in TRIANGLES]
    (folder / "plate.obj").write_text("\n".join(rows) + "\n")
    place = " ".join(map(str, MIDDLE))
    plate = f'<visual><origin xyz="{place}"/><geometry><mesh filename="{file}"/></geometry></visual>'
    links = [
        LINK.format(k=k, before=f"link{k - 1}" if k > 1 else "base", axis=axis, more=plate if k == 6 else "")
        for k, axis in enumerate(("0 0 1", "0 1 0", "0 1 0", "0 0 1", "0 1 0", "1 0 0"), 1)
    ]
    description = f'<robot name="plated"><link name="base"/>{"".join(links)}</robot>'
    path = folder / "plated.urdf"
    path.write_text(description)
    return jtik.Robot.from_urdf(path)
